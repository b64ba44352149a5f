// SPDX-License-Identifier: MIT
// Predictions and calibrated random effects of a fit.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>
#include <variant>

#include "fronts/call.hpp"
#include "fronts/result_columns.hpp"
#include "prediction/fitted_labels.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/missing_codes.hpp"
#include "silvafit/fit/calibration.hpp"
#include "silvafit/fit/prediction.hpp"
#include "silvafit/stand/tree_columns.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/idle_settings.hpp"
#include "silvafit/study/table_checks.hpp"

namespace silvafit::study {
namespace {

using data::Table;

/// The columns that identify the groups of a term; of nested terms those of all.
std::vector<std::string> columns_of(const std::vector<fit::RandomEffects>& terms,
                                    std::size_t term) {
  std::vector<std::string> result;
  if (terms[term].is_crossed) {
    result = terms[term].within;
    result.push_back(terms[term].group);
  } else {
    for (const fit::RandomEffects& of : terms) result.push_back(of.group);
  }
  return result;
}

/// What the predictions of groups are that are not in the fit, with the first of their labels;
/// empty if there are none.
/// \param unknown  see Prediction::unknown_terms
std::string note_on_new_groups(const std::vector<fit::RandomEffects>& terms,
                               const Table& table,
                               const std::vector<unsigned>& unknown,
                               bool is_calibrated) {
  const std::size_t count = unknown.size() - std::ranges::count(unknown, 0U);
  if (count == 0 || terms.empty()) return {};
  constexpr std::size_t kMostShown = 5;
  std::vector<std::string> by_term;
  for (std::size_t t = 0; t < terms.size(); ++t) {
    const std::vector<std::string> columns = columns_of(terms, t);
    std::vector<data::TextColumn> labels;
    for (const std::string& column : columns) labels.push_back(table.labels(column));
    std::vector<std::string> shown;
    for (std::size_t row = 0; row < unknown.size() && shown.size() <= kMostShown; ++row) {
      if ((unknown[row] >> t & 1U) == 0) continue;
      std::vector<std::string> parts;
      for (const data::TextColumn& of : labels) {
        parts.emplace_back(of.is_missing(row) ? "missing" : of[row]);
      }
      const std::string label = fmt::format("{}", fmt::join(parts, " / "));
      if (std::ranges::find(shown, label) != shown.end()) continue;
      shown.push_back(shown.size() < kMostShown ? label : "...");
    }
    if (shown.empty()) continue;
    by_term.push_back(fmt::format("{} {}", fmt::join(columns, "/"), fmt::join(shown, ", ")));
  }
  return fmt::format(
      "{} of groups that are not in the fit{} ({}): their predictions have {}; `new_groups` has "
      "other choices",
      counted(count, "row is", "rows are"),
      is_calibrated ? " and have no measured row" : "",
      fmt::join(by_term, "; "),
      terms.size() > 1 ? "the effects of the known groups only" : "random effects 0");
}

/// On labels of factors that are not in the fit, whose predictions are missing.
std::string note_on_new_levels(const fit::ColumnLevels& levels, const Table& table) {
  if (!table.has(levels.column)) return {};
  const data::TextColumn labels = table.labels(levels.column);
  const std::vector<bool> is_new = has_unknown_label(levels, table);
  std::vector<std::string> shown;
  for (std::size_t row = 0; row < is_new.size(); ++row) {
    if (!is_new[row]) continue;
    const std::string label(labels[row]);
    if (std::ranges::find(shown, label) == shown.end()) shown.push_back(label);
  }
  if (shown.empty()) return {};
  return fmt::format("column {} has levels that are not in the fit ({}): {} missing",
                     levels.column,
                     data::list_of(shown),
                     counted(static_cast<std::size_t>(std::ranges::count(is_new, true)),
                             "prediction is",
                             "predictions are"));
}

/// Calibration is by the measured response, so that a missing column or text is an error.
void check_measured(const fit::FittedModel& fit, const Table& table) {
  const std::string& response = fit.specification.formula.left;
  const auto fail = [&](const char* what) { throw InputError(what, {.column = response}); };
  if (!table.has(response)) {
    fail("calibration needs this column, with a missing value where it was not measured");
  }
  if (!table.is_numeric(response)) {
    const data::TextColumn& column = table.text(response);
    for (std::size_t row = 0; row < column.size(); ++row) {
      if (!column.is_missing(row)) fail("this column has text, but calibration needs numbers");
    }
  }
}

/// Rows whose covariates cannot be real: infinite, or negative where the fit had positive ones.
void warn_of_impossible(const fit::FittedModel& fit,
                        const Table& table,
                        std::vector<std::string>& warnings) {
  for (const fit::ColumnRange& range : fit.ranges) {
    if (!table.has(range.column) || !table.is_numeric(range.column)) continue;
    const auto count = std::ranges::count_if(table.numbers(range.column), [&](double value) {
      return std::isinf(value) || (range.low > 0.0 && value < 0.0);
    });
    if (count == 0) continue;
    warnings.push_back(fmt::format(
        "{} an infinite or negative value of {}, which is {:.6g} to {:.6g} in the data of the fit",
        counted(static_cast<std::size_t>(count), "row has", "rows have"),
        range.column,
        range.low,
        range.high));
  }
}

/// The rows for a prediction, where codes of missing values are missing as in files. The covariates
/// of a model of the catalogue must be in its domain.
Table rows_for(const fit::FittedModel& fit,
               const data::TableSource& source,
               const Catalogue* catalogue,
               bool is_calibrated,
               std::vector<std::string>& warnings) {
  Table table = *std::get<std::shared_ptr<const Table>>(source);
  if (is_calibrated) check_measured(fit, table);
  data::MissingCodes codes;
  data::take_missing_codes(table, codes);
  const BaseModel* const model = base_model_of(fit, catalogue);
  if (model != nullptr) {
    std::vector<std::string> names = model->covariates;
    names.push_back(model->response);
    for (const std::string& name : names) {
      if (!stand::is_measure(name)) continue;
      stand::take_missing_codes(
          name, {name}, true, table, [&codes](const std::string& column, const std::string& code) {
            codes.add(column, code);
          });
    }
  }
  if (!codes.empty()) warnings.push_back(codes.note());
  warn_of_impossible(fit, table, warnings);
  if (model != nullptr) {
    require_domain_of_covariates(*model, table);
    if (is_calibrated) require_possible(model->response, table);
  }
  return table;
}

/// The catalogue, if a fit is of one of its models.
std::shared_ptr<const Catalogue> catalogue_for(const fit::FittedModel& fit,
                                               const AnalysisCall& call) {
  return fit.model.empty() ? nullptr : call.catalogue();
}

Table table_of_prediction(const fit::Prediction& found, fit::IntervalKind kind) {
  Table table(static_cast<std::size_t>(found.value.size()));
  table.set("value", numbers(found.value));
  add_if_known("lower", found.lower, table);
  add_if_known("upper", found.upper, table);
  const bool is_mean = kind == fit::IntervalKind::kConfidence;
  add_if_known("standard_error", is_mean ? found.mean_error : found.prediction_error, table);
  if (!found.calibrated_from.empty()) {
    const auto& trees = found.calibrated_from;
    table.set("calibrated_from", std::vector<double>(trees.begin(), trees.end()));
  }
  return table;
}

}  // namespace

/// Without the argument `new_groups` a warning names the groups that are not in the fit.
AnalysisWork predict_work(AnalysisCall& call) {
  const auto settings = call.read_with_threads<PredictionSettings>();
  refuse_idle_settings(settings);
  return [fit = &call.fit(),
          table = call.table(),
          catalogue = catalogue_for(call.fit(), call),
          says_new = !call.find("new_groups"),
          settings](const AnalysisCallbacks& /*callbacks*/) {
    const fit::Level level = settings.level;
    const bool is_calibrated = level == fit::Level::kCalibrated;
    AnalysisResult result;
    const Table rows = rows_for(*fit, table, catalogue.get(), is_calibrated, result.warnings);
    const fit::Prediction found = fit::predict(*fit, rows, level, prediction_options(settings));
    if (says_new && (is_calibrated || level == fit::Level::kConditional)) {
      result.warnings.push_back(
          note_on_new_groups(fit->specification.random, rows, found.unknown_terms, is_calibrated));
    }
    for (const fit::ColumnLevels& levels : fit->levels) {
      result.warnings.push_back(note_on_new_levels(levels, rows));
    }
    std::erase(result.warnings, "");
    result.tables.emplace_back("rows", table_of_prediction(found, settings.kind_of_errors()));
    return result;
  };
}

/// The random effects of the groups of each term, with their labels: a table "groups 1", ...
AnalysisWork calibrate_work(AnalysisCall& call) {
  const auto settings = call.read_with_threads<PredictionSettings>();
  const fit::CalibrationOptions options{.seen_groups = settings.seen_groups,
                                        .threads = settings.threads};
  return [fit = &call.fit(),
          table = call.table(),
          catalogue = catalogue_for(call.fit(), call),
          options](const AnalysisCallbacks& /*callbacks*/) {
    AnalysisResult result;
    const Table rows = rows_for(*fit, table, catalogue.get(), true, result.warnings);
    const fit::Calibration found = fit::calibrate(*fit, rows, options);
    for (std::size_t term = 0; term < found.random.size(); ++term) {
      const fit::CalibratedEffects& of = found.random[term];
      Table groups(of.labels.size());
      data::TextColumn labels;
      for (const std::string& label : of.labels) labels.append(label);
      groups.set("label", std::move(labels));
      groups.set("measured", std::vector<double>(of.measured.begin(), of.measured.end()));
      for (std::size_t k = 0; k < fit->random[term].names.size(); ++k) {
        const Eigen::VectorXd effects = of.effects.row(static_cast<Eigen::Index>(k));
        groups.set(fit->random[term].names[k], numbers(effects));
      }
      result.tables.emplace_back(fmt::format("groups {}", term + 1), std::move(groups));
    }
    return result;
  };
}

}  // namespace silvafit::study
