// SPDX-License-Identifier: MIT
// Large stands: trees of like shape share one model.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/morphology.hpp"
#include "silvafit/tree/scene_writer.hpp"

namespace silvafit::tree {

/// How far a tree's model, stretched to its height and crown diameters, is from its measurements.
struct ShapeError {
  double hcb_cm = 0.0;     ///< height to crown base
  double hc_cm = 0.0;      ///< height of the widest crown
  double dbh_cm = 0.0;     ///< at 1.3 m above the ground, by the area of the mesh's section there
  double radius_cm = 0.0;  ///< largest of the four crown radii
};

/// A tree as a stretched copy of a model. Height and crown width are the tree's own.
struct SharedTree {
  std::size_t model = 0;
  double stretch_east = 1.0;  ///< crown diameter east-west by the model's
  double stretch_up = 1.0;    ///< height by the model's
  double stretch_north = 1.0;
  ShapeError error{};
};

struct SharedModel {
  Morphology morphology{};  ///< in the middle of the trees that share it
  const Builder* builder = nullptr;
  std::vector<std::size_t> trees{};  ///< those that share it
};

struct SharedModels {
  std::vector<SharedModel> models{};
  std::vector<SharedTree> trees{};  ///< in the order of the morphologies
};

/// Divides the trees of each preset into classes of like shape: beginning with all in one, the
/// class in which trees differ most is halved at the middle of that measure, until there are as
/// many classes as asked for or all trees of each are alike. Trees differ by what stretching does
/// not mend (crown base, widest height, stem thickness, skewness of the crown, in cm) and, with
/// less weight, by how much they would be stretched.
/// What DBH is off is known only of meshes: see measure_stems().
/// \param builders    one a tree
/// \param per_preset  classes of a preset at most
/// \throws UsageError if the sizes differ or `per_preset` is 0; DomainError as complete()
SharedModels share_models(std::span<const Morphology> trees,
                          std::span<const Builder* const> builders,
                          std::size_t per_preset);

/// Cuts a model's mesh where it stands at 1.3 m above the ground once it is stretched to each of
/// its trees, and notes how far the section's diameter is from the tree's DBH. Where a model is
/// measured at several levels of detail, the largest error stays.
/// \param trees  as given to share_models()
void measure_stems(std::size_t model,
                   const Mesh& mesh,
                   std::span<const Morphology> trees,
                   SharedModels& shared);

}  // namespace silvafit::tree
