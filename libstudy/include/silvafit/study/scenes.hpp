// SPDX-License-Identifier: MIT
// Scenes: a reference tree of each structural class with four neighbors that give it this class.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/study/model_library.hpp"

namespace silvafit::study {

struct SceneOptions {
  std::vector<std::string> species{};      ///< of the reference trees; empty: all of the library
  std::map<std::string, double> dbh_cm{};  ///< of the reference trees, by species; else that
                                           ///< the most frequent one in the library's inventory
  std::string role = "nlme";               ///< which of the library's models predict
  std::string group{};                     ///< predict with the random effects of this group
  double uniform_angle_index = 0.5;        ///< W where no model of the species depends on it
  double spacing_m = 25.0;                 ///< between reference trees of neighboring scenes
};

/// The design of a species' scenes.
struct SpeciesScenes {
  std::string species{};
  double dbh_cm = 0.0;
  std::vector<std::string> indices{};  ///< W, M, C, U: those that a model of the species depends on
  std::size_t scenes = 0;
};

struct Scenes {
  std::vector<SpeciesScenes> species{};
  /// Five rows a scene, the reference tree first. Columns plot (the scene: `SM-C0.25-M1`), tree
  /// (1 to 5), species, x, y [m], dbh [cm], h, hcb, cw [m] and, for reference trees only, W, M, U,
  /// C.
  data::Table trees{};
};

/// One scene for every combination of the classes 0, 0.25, 0.5, 0.75, 1 of the indices that a
/// species' models depend on.
///
/// The reference tree has the species' commonest DBH and the library's predictions for its indices.
/// The positions, species, DBH and crown widths of its neighbors are chosen such that it has these
/// indices (docs/stands-in-3d.md); their own sizes are predicted for indices of 0.5. Indices that
/// no model depends on: W as the options say, M, U, C 0.5. Scenes are in rows, one species after
/// another.
/// \throws UsageError if a species has no model of h, hcb or cw of the role, or its DBH is not
///   known; NumericalError that names a prediction which is no possible tree; InputError as
///   predict_responses
Scenes scenes_of(const ModelLibrary& library, const SceneOptions& options = {});

/// The most frequent of some diameters [cm]: the maximum of the density estimated by a Gaussian
/// kernel with Silverman's bandwidth, to 0.1 cm.
/// \param diameters_cm  NaN are ignored, and values above 2000 cm unless all are; at least one
double commonest_dbh_cm(const std::vector<double>& diameters_cm);

}  // namespace silvafit::study
