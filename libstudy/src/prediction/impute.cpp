// SPDX-License-Identifier: MIT
#include "silvafit/study/impute.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "prediction/fitted_labels.hpp"
#include "prediction/impute_models.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "silvafit/fit/calibrated_fit.hpp"
#include "silvafit/fit/calibration.hpp"
#include "silvafit/fit/prediction.hpp"
#include "silvafit/study/table_checks.hpp"
#include "simulation/covariance_root.hpp"

namespace silvafit::study {
namespace {

using Eigen::Index;

bool is_measured(double value) { return std::isfinite(value); }

void check(const data::Table& table, const ImputeOptions& options) {
  for (const std::string& name : {options.response, options.by, options.group}) {
    if (name.empty() || table.has(name)) continue;
    throw UsageError(data::no_such_column(name, table.names()));
  }
  if (!options.formula.empty() && !options.models.empty()) {
    throw UsageError("give either `formula` or `models`, not both");
  }
  if (options.add_residual && options.interval > 0.0) {
    throw UsageError(
        "intervals are those of values without random residuals; omit `add_residual` or `coverage`",
        {.column = "`add_residual`"});
  }
  require_numbers(table, {options.response});
  const auto values = table.numbers(options.response);
  const auto infinite =
      std::ranges::find_if(values, [](double value) { return std::isinf(value); });
  if (infinite != values.end()) {
    const auto row = static_cast<std::size_t>(infinite - values.begin());
    throw InputError("the value is not finite", data::place_of(table, row, options.response));
  }
  require_possible(options.response, table);
}

/// The trees of one model: their rows, and those it is fitted to.
struct Part {
  std::string label{};
  std::vector<std::size_t> rows{};
  std::vector<std::size_t> measured{};
};

/// Values of the column `by` with enough measured trees have a part of their own. All others share
/// the last part, which may have no rows; its model is fitted to the measured trees of all.
std::vector<Part> parts_of(const data::Table& table, const ImputeOptions& options) {
  const auto response = table.numbers(options.response);
  std::vector<Part> parts;
  std::vector<std::size_t> part_of_level;
  std::optional<data::TextColumn> labels;
  if (!options.by.empty()) {
    labels = table.labels(options.by);
    std::vector<std::size_t> counts(labels->levels().size(), 0);
    for (std::size_t row = 0; row < table.rows(); ++row) {
      if (!labels->is_missing(row) && is_measured(response[row])) ++counts[labels->code(row)];
    }
    for (std::size_t level = 0; level < counts.size(); ++level) {
      const bool is_own = counts[level] >= options.minimum_trees;
      part_of_level.push_back(is_own ? parts.size() : std::string::npos);
      if (is_own) parts.push_back({.label = labels->levels()[level]});
    }
  }
  Part others;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (is_measured(response[row])) others.measured.push_back(row);
    const bool has_label = labels && !labels->is_missing(row);
    const std::size_t part = has_label ? part_of_level[labels->code(row)] : std::string::npos;
    if (part == std::string::npos) {
      others.rows.push_back(row);
      continue;
    }
    parts[part].rows.push_back(row);
    if (is_measured(response[row])) parts[part].measured.push_back(row);
  }
  if (others.measured.empty()) {
    throw InputError(
        fmt::format("no tree has a measured {}, so no model can be fitted", options.response),
        {.file = table.file(), .column = options.response});
  }
  parts.push_back(std::move(others));
  return parts;
}

/// (N) why the model has no value for a row, or why the value is doubtful.
std::vector<std::string> flags_of(const fit::FittedModel& fit, const data::Table& table) {
  std::vector<std::string> flags(table.rows());
  const auto say = [&flags](std::size_t row, const std::string& text) {
    if (flags[row].empty()) flags[row] = text;
  };
  for (const fit::ColumnRange& range : fit.ranges) {
    const std::span<const double> values = table.numbers(range.column);
    for (std::size_t row = 0; row < flags.size(); ++row) {
      if (std::isnan(values[row])) say(row, range.column + " is missing");
      if (values[row] < range.low || values[row] > range.high) {
        say(row, range.column + " is outside the fitted range");
      }
    }
  }
  for (const fit::ColumnLevels& levels : fit.levels) {
    const data::TextColumn labels = table.labels(levels.column);
    const std::vector<bool> is_unknown = has_unknown_label(levels, table);
    for (std::size_t row = 0; row < flags.size(); ++row) {
      if (labels.is_missing(row)) say(row, levels.column + " is missing");
      if (is_unknown[row]) say(row, levels.column + " is not in the fit");
    }
  }
  return flags;
}

/// The random effects of the groups of some rows, given their measured trees.
class Groups {
 public:
  Groups(const fit::FittedModel& fit, const data::Table& rows)
      : fit_(fit), found_(fit::calibrate(fit, rows)) {
    for (const fit::CalibratedEffects& term : found_.random) {
      std::vector<bool>& is_measured = is_measured_.emplace_back();
      for (std::size_t g = 0; g < term.labels.size(); ++g) {
        is_measured.push_back(term.fitted_group[g] >= 0 || term.measured[g] > 0);
      }
    }
  }

  /// Random effects of the groups without measured trees, from their distribution.
  void draw(Random& random) {
    for (std::size_t k = 0; k < found_.random.size(); ++k) {
      draw(is_measured_[k], fit_.random[k].covariance, random, found_.random[k].effects);
    }
  }

  /// The fit with the random effects of these groups.
  fit::FittedModel known() const { return with_groups(fit_, found_); }

  ImputeLevel level(std::size_t row) const {
    const std::size_t last = found_.random.size() - 1;
    if (is_known(last, row)) return ImputeLevel::kPlot;
    if (last > 0 && is_known(0, row)) return ImputeLevel::kStand;
    return ImputeLevel::kPopulation;
  }

 private:
  static void draw(const std::vector<bool>& is_measured,
                   const Eigen::MatrixXd& covariance,
                   Random& random,
                   Eigen::MatrixXd& effects) {
    if (is_measured.empty()) return;
    const std::optional<Eigen::MatrixXd> root = covariance_root(covariance);
    if (!root)
      throw NumericalError(
          "the covariance matrix of the random effects is not positive semidefinite");
    Eigen::VectorXd normal(covariance.rows());
    for (std::size_t g = 0; g < is_measured.size(); ++g) {
      // Drawn for all groups, so that one more measurement does not change the others.
      for (double& value : normal) value = random.normal();
      if (!is_measured[g]) effects.col(static_cast<Index>(g)) = *root * normal;
    }
  }

  /// Whether the effects of a row's group come from trees; NaN if the modes were not found.
  bool is_known(std::size_t term, std::size_t row) const {
    const Index group = found_.random[term].group_of_row[row];
    return group >= 0 && is_measured_[term][static_cast<std::size_t>(group)] &&
           found_.random[term].effects.col(group).allFinite();
  }

  const fit::FittedModel& fit_;
  fit::Calibration found_;
  std::vector<std::vector<bool>> is_measured_{};  ///< by term and group
};

/// Fills in the rows of one part.
class Filling {
 public:
  Filling(const data::Table& table, const ImputeOptions& options, Imputation& result)
      : table_(table), options_(options), result_(result) {}

  /// \param stream  of random numbers, one a part
  void fill(const Part& part, const fit::FittedModel& fit, std::uint64_t stream) {
    const data::Table rows = table_.select(part.rows);
    const std::vector<std::string> flags = flags_of(fit, rows);
    Random random(options_.seed, stream);
    std::optional<Groups> groups;
    if (fit.has_random_effects()) groups.emplace(fit, rows);
    if (groups && options_.add_residual) groups->draw(random);
    const fit::Prediction prediction =
        fit::predict(groups ? groups->known() : fit, rows, fit::Level::kConditional);
    fit::Prediction limits;
    if (options_.interval > 0.0) {
      limits = fit::predict(fit,
                            rows,
                            groups ? fit::Level::kCalibrated : fit::Level::kPopulation,
                            {.interval = options_.interval, .threads = options_.threads});
    }
    for (std::size_t i = 0; i < part.rows.size(); ++i) {
      const std::size_t row = part.rows[i];
      // Drawn for all trees, so that one more measurement does not change the others.
      const double noise = options_.add_residual ? random.normal() : 0.0;
      if (is_measured(result_.value[row])) continue;
      result_.flag[row] = flags[i];
      const auto at = static_cast<Index>(i);
      const double value = options_.add_residual
                               ? with_residual(prediction.value[at],
                                               prediction.residual_sd[at],
                                               noise,
                                               Random(options_.seed, (stream << kRowBits) + row),
                                               row)
                               : prediction.value[at];
      if (!std::isfinite(value)) {
        if (result_.flag[row].empty()) result_.flag[row] = "outside the domain of the model";
        continue;
      }
      result_.value[row] = value;
      if (options_.interval > 0.0) {
        result_.lower[row] = limits.lower[at];
        result_.upper[row] = limits.upper[at];
      }
      result_.source[row] = ImputeSource::kImputed;
      result_.level[row] = groups ? groups->level(i) : ImputeLevel::kPopulation;
    }
  }

 private:
  // Streams of rows beside those of parts.
  static constexpr int kRowBits = 40;

  /// A possible value of a row; NaN if none was drawn.
  /// \param again  for residuals instead of one that makes the value impossible
  double with_residual(
      double mean, double residual_sd, double noise, Random again, std::size_t row) const {
    const bool has_height = table_.has("h") && table_.is_numeric("h");
    const double h_m = has_height ? table_.numbers("h")[row] : kNaN;
    constexpr int kDraws = 1000;
    for (int draw = 0; draw < kDraws; ++draw) {
      const double value = mean + noise * residual_sd;
      if (!std::isfinite(value) || is_possible_value(options_.response, value, h_m)) return value;
      noise = again.normal();
    }
    return kNaN;
  }

  const data::Table& table_;
  const ImputeOptions& options_;
  Imputation& result_;
};

}  // namespace

namespace {

/// The model of a part; none if the part has a label and no model of it converged: its trees are
/// then predicted by the model of all.
std::optional<fit::FittedModel> model_of(const Part& part,
                                         const data::Table& table,
                                         const Catalogue& catalogue,
                                         const ImputeOptions& options,
                                         std::vector<std::string>& notes) {
  const data::Table measured = table.select(part.measured);
  try {
    return imputation_model(measured, catalogue, options, notes);
  } catch (const NumericalError& error) {
    if (part.label.empty()) throw;
    std::string reason = error.message();
    if (reason.ends_with('.')) reason.pop_back();
    notes.push_back(reason + "; the model for all trees is used");
    return std::nullopt;
  }
}

}  // namespace

std::size_t Imputation::count(ImputeSource which) const {
  return static_cast<std::size_t>(std::ranges::count(source, which));
}

std::size_t Imputation::count(ImputeLevel which) const {
  return static_cast<std::size_t>(std::ranges::count(level, which));
}

void add_labels(const data::Table& table,
                const ImputeOptions& options,
                std::vector<std::string>& labels) {
  const auto add = [&labels](const std::string& label) {
    if (std::ranges::find(labels, label) == labels.end()) labels.push_back(label);
  };
  if (options.by.empty()) return add("");
  const data::TextColumn by = table.labels(options.by);
  for (const std::string& label : by.levels()) add(label);
  for (std::size_t row = 0; row < by.size(); ++row) {
    if (by.is_missing(row)) return add("");
  }
}

ImputeModels imputation_models(const data::Table& table,
                               const Catalogue& catalogue,
                               const ImputeOptions& options,
                               const std::vector<std::string>& labels) {
  check(table, options);
  require_model_numbers(table, catalogue, options);
  ImputeModels result;
  if (options.random.empty() && plot_column(table, options).empty()) {
    result.notes.emplace_back(
        "the column 'plot' is missing (use `group` to name another), so the model has no random "
        "effects");
  }
  std::vector<Part> parts = parts_of(table, options);
  const auto place = [&labels](const Part& part) { return std::ranges::find(labels, part.label); };
  std::stable_sort(parts.begin(), parts.end() - 1, [&](const Part& left, const Part& right) {
    return place(left) < place(right);
  });
  if (!options.by.empty()) {
    const data::TextColumn by = table.labels(options.by);
    for (const std::size_t row : parts.back().measured) {
      if (!by.is_missing(row)) result.measured_labels.emplace(by[row]);
    }
  }
  std::vector<std::string> open = labels;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Part& part = parts[i];
    if (part.label.empty() && open.empty()) continue;
    std::vector<std::string> notes;
    const auto model = model_of(part, table, catalogue, options, notes);
    for (const std::string& note : notes) {
      result.notes.push_back(part.label.empty() ? note : part.label + ": " + note);
    }
    if (!model) continue;
    std::erase(open, part.label);
    result.models.push_back({.label = part.label, .fit = *model, .stream = i + 1});
  }
  return result;
}

/// Flags imputed heights at or below the measured crown base, and crown bases not below the top.
void flag_contradictions(const data::Table& table,
                         const std::string& response,
                         Imputation& result) {
  const bool is_height = response == "h";
  const char* const other = is_height ? "hcb" : "h";
  if ((!is_height && response != "hcb") || !table.has(other) || !table.is_numeric(other)) return;
  const auto measured = table.numbers(other);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (result.source[row] != ImputeSource::kImputed || !result.flag[row].empty()) continue;
    const double h = is_height ? result.value[row] : measured[row];
    const double hcb = is_height ? measured[row] : result.value[row];
    if (h <= hcb) result.flag[row] = is_height ? "not above the crown base" : "not below the top";
  }
}

Imputation impute_with(const ImputeModels& models,
                       const data::Table& table,
                       const ImputeOptions& options) {
  check(table, options);
  const auto response = table.numbers(options.response);
  Imputation result{.models = models.models,
                    .value = std::vector<double>(table.rows(), kNaN),
                    .source = std::vector<ImputeSource>(table.rows(), ImputeSource::kMissing),
                    .level = std::vector<ImputeLevel>(table.rows(), ImputeLevel::kNone),
                    .flag = std::vector<std::string>(table.rows()),
                    .notes = models.notes};
  if (options.interval > 0.0) {
    result.lower.assign(table.rows(), kNaN);
    result.upper = result.lower;
  }
  std::vector<Part> parts(models.models.size());
  std::map<std::string, std::size_t, std::less<>> part_of;
  for (std::size_t i = 0; i < parts.size(); ++i) part_of.emplace(models.models[i].label, i);
  std::optional<data::TextColumn> labels;
  if (!options.by.empty()) labels = table.labels(options.by);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (is_measured(response[row])) {
      result.value[row] = response[row];
      result.source[row] = ImputeSource::kMeasured;
    }
    const auto own = labels ? part_of.find((*labels)[row]) : part_of.end();
    parts[own == part_of.end() ? parts.size() - 1 : own->second].rows.push_back(row);
  }
  Filling filling(table, options, result);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].rows.empty()) continue;
    filling.fill(parts[i], models.models[i].fit, models.models[i].stream);
  }
  flag_contradictions(table, options.response, result);
  if (!labels) return result;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const bool is_by_others = result.source[row] == ImputeSource::kImputed &&
                              !labels->is_missing(row) &&
                              !models.measured_labels.contains(std::string((*labels)[row]));
    if (is_by_others && result.flag[row].empty()) {
      result.flag[row] = fmt::format("no tree of its {} is measured", options.by);
    }
  }
  return result;
}

Imputation impute(const data::Table& table,
                  const Catalogue& catalogue,
                  const ImputeOptions& options) {
  check(table, options);
  std::vector<std::string> labels;
  add_labels(table, options, labels);
  return impute_with(imputation_models(table, catalogue, options, labels), table, options);
}

}  // namespace silvafit::study
