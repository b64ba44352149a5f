// SPDX-License-Identifier: MIT
// A study and its inputs.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/sampling_design.hpp"
#include "silvafit/stand/stand_report.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/stand/thinning.hpp"
#include "silvafit/study/study.hpp"
#include "silvafit/study/study_configuration.hpp"

namespace silvafit::study {

/// The mean height of a species by dbh.
struct HeightCurve {
  std::string species{};
  fit::FittedModel fit;
};

/// The dominant height of a plot at the base age of a curve.
struct SiteIndex {
  std::string plot{};
  double age = 0.0;          ///< mean of its trees [years]; NaN if no tree has one
  double dominant_m = 0.0;   ///< dominant height now
  double at_base_age = 0.0;  ///< [m]
};

/// A study with all of its inputs, which its files document.
struct StudyRecord {
  std::string version{};  ///< of silvafit
  std::string command{};  ///< the command line or call as it was given
  /// Sources of columns and structural units; settings of models are in `study.options`. A window
  /// is relative to the current folder.
  StudyConfiguration settings{};
  /// Decisions before fitting, for the report: window, edge correction, ...
  std::vector<std::pair<std::string, std::string>> decisions{};
  stand::CheckedInventory inventory{};
  /// Of sampled plots: the areas, and which trees were counted.
  std::optional<stand::DesignedSample> sample{};
  std::optional<stand::StructuralUnits> units{};
  data::Table table{};  ///< inventory_table() of the two
  Study study{};
  // For the first part of the report:
  std::optional<stand::StandReport> stand{};  ///< none without areas
  std::optional<stand::Thinning> thinning{};
  std::vector<SiteIndex> sites{};
  std::vector<HeightCurve> height_curves{};
  std::string volume{};  ///< how the volume of `stand` was computed; empty: it has none
};

}  // namespace silvafit::study
