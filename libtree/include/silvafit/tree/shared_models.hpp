// SPDX-License-Identifier: MIT
// Large stands: trees of similar shape share one model.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/morphology.hpp"
#include "silvafit/tree/scene_writer.hpp"

namespace silvafit::tree {

/// Differences between a tree's scaled model and the tree's measurements.
struct ShapeError {
  double hcb_cm = 0.0;     ///< height to crown base
  double hc_cm = 0.0;      ///< height of the widest crown
  double dbh_cm = 0.0;     ///< at 1.3 m above the ground, by the area of the mesh's section there
  double radius_cm = 0.0;  ///< largest of the four crown radii
};

/// A tree as a scaled copy of a model. Height and crown width are exact.
struct SharedTree {
  std::size_t model = 0;
  double stretch_east = 1.0;  ///< east-west crown diameter divided by the model's
  double stretch_up = 1.0;    ///< height divided by the model's
  double stretch_north = 1.0;
  ShapeError error{};
};

struct SharedModel {
  Morphology morphology{};  ///< in the middle of the range of its trees
  const Builder* builder = nullptr;
  std::vector<std::size_t> trees{};  ///< the trees that share it
};

struct SharedModels {
  std::vector<SharedModel> models{};
  std::vector<SharedTree> trees{};  ///< in the order of the morphologies
};

/// Divides the trees of each preset into classes of similar shape. It starts with one class; the
/// class with the largest range of a measure is divided at the middle of that range, until there
/// are as many classes as requested or all trees of each are equal. Measures are those that scaling
/// does not correct (crown base, widest height, stem thickness, skewness of the crown, in cm) and,
/// with less weight, the scales themselves. The error of DBH is known only from meshes: see
/// measure_stems().
/// \param builders    one per tree
/// \param per_preset  maximum number of classes per preset
/// \throws UsageError if the sizes differ or `per_preset` is 0; DomainError as complete()
SharedModels share_models(std::span<const Morphology> trees,
                          std::span<const Builder* const> builders,
                          std::size_t per_preset);

/// Cuts a model's mesh at the height that is 1.3 m above the ground after scaling to each of its
/// trees, and stores the difference between the section's diameter and the tree's DBH. For a model
/// measured at several levels of detail, the largest error is kept.
/// \param trees  as given to share_models()
void measure_stems(std::size_t model,
                   const Mesh& mesh,
                   std::span<const Morphology> trees,
                   SharedModels& shared);

/// Appends the branches to the stem, so that a model is drawn with one call for its wood and one
/// for its foliage. The part keeps the kind of the stem; a mesh without branches does not change.
Mesh with_joined_wood(Mesh mesh);

}  // namespace silvafit::tree
