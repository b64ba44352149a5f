// SPDX-License-Identifier: MIT
// The arguments of an analysis.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "silvafit/study/analyses.hpp"
#include "silvafit/study/study_configuration.hpp"
#include "silvafit/study/tree_equations.hpp"
#include "silvafit/study/unit_settings.hpp"
#include "study/settings_json.hpp"

namespace silvafit::study {

/// A call of an analysis, whose arguments are read one after the other.
class AnalysisCall {
 public:
  explicit AnalysisCall(AnalysisInput input);

  /// The settings of a list.
  template <typename Settings>
  Settings read(Settings settings = {}) {
    each_setting(settings, reader_);
    return settings;
  }
  /// Settings with the elements `threads` and `seed`, if they have them.
  template <typename Settings>
  Settings read_with_threads(Settings settings = {}) {
    settings = read(std::move(settings));
    add_threads(settings);
    return settings;
  }
  template <typename Settings>
  void add_threads(Settings& settings) {
    if (const auto json = find("threads")) settings.threads = static_cast<unsigned>(count(*json));
    if constexpr (requires { settings.seed; }) {
      if (const auto json = find("seed")) settings.seed = count(*json);
    }
  }
  std::optional<data::JsonReader> find(std::string_view key) {
    others_.emplace_back(key);
    return reader_.find(key);
  }
  /// A text, empty if it is absent.
  std::string text(std::string_view key);
  bool truth(std::string_view key);
  /// Changes nothing if it is absent.
  void read_names(std::string_view key, std::vector<std::string>& names);
  std::size_t number(std::string_view key, std::size_t otherwise);

  UnitSettings units();          ///< with windows in memory
  SamplingSettings sampling();   ///< with the table of plots
  EquationSettings equations();  ///< with the folder of the catalogue
  void complete(UnitSettings& units);
  void complete(SamplingSettings& sampling) const;

  const data::TableSource& table() const;
  const fit::FittedModel& fit() const;
  std::shared_ptr<const Catalogue> catalogue() const;
  const AnalysisInput& input() const { return input_; }

  /// \throws UsageError that lists the settings, for an argument that nobody has read
  void finish() const;

 private:
  static std::size_t count(const data::JsonReader& json);

  AnalysisInput input_;
  SettingsReader reader_;
  std::vector<std::string> others_{};  ///< keys that are no settings
};

/// JSON whose sentences (`verdict`, `doubts`, ...) are in the words of a front end.
std::string in_words(nlohmann::ordered_json json, Front front);

// One function for each analysis: it reads the arguments, and returns the work.
AnalysisWork structural_units_work(AnalysisCall& call);
AnalysisWork stand_summary_work(AnalysisCall& call);
AnalysisWork stand_growth_work(AnalysisCall& call);
AnalysisWork impute_work(AnalysisCall& call);
AnalysisWork predict_library_work(AnalysisCall& call);
AnalysisWork study_work(AnalysisCall& call);
AnalysisWork grow_work(AnalysisCall& call);
AnalysisWork view_work(AnalysisCall& call);
AnalysisWork fit_work(AnalysisCall& call);
AnalysisWork predict_work(AnalysisCall& call);
AnalysisWork intervals_work(AnalysisCall& call);
AnalysisWork bootstrap_work(AnalysisCall& call);
AnalysisWork cross_validate_work(AnalysisCall& call);
AnalysisWork compare_work(AnalysisCall& call);
AnalysisWork simulate_work(AnalysisCall& call);
AnalysisWork residuals_work(AnalysisCall& call);
AnalysisWork covariance_work(AnalysisCall& call);
AnalysisWork term_tests_work(AnalysisCall& call);
AnalysisWork calibrate_work(AnalysisCall& call);

}  // namespace silvafit::study
