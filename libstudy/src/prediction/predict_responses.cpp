// SPDX-License-Identifier: MIT
#include "silvafit/study/predict_responses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "prediction/chosen_models.hpp"
#include "prediction/fitted_labels.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/fit/response.hpp"
#include "silvafit/study/table_checks.hpp"

namespace silvafit::study {
namespace {

using Names = std::vector<std::string>;

bool contains(const Names& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

/// Predicts the responses in turn, and replaces missing values that later ones need.
class Predictor {
 public:
  Predictor(const data::Table& table,
            const PredictionSettings& settings,
            const Catalogue* catalogue)
      : table_(table), settings_(settings), catalogue_(catalogue), flags_(table.rows()) {}

  PredictedResponse predict(const ResponseModels& models) {
    if (is_calibrated()) fit::add_response(models.response, table_);
    std::map<const LibraryModel*, std::vector<std::size_t>> rows_of;
    for (std::size_t row = 0; row < table_.rows(); ++row) {
      const std::string species = species_of(models, row);
      const LibraryModel* model = models.model_for(species);
      if (model != nullptr) {
        rows_of[model].push_back(row);
      } else if (!models.remarks.contains(species)) {
        flag(row,
             fmt::format("no model of {}{}",
                         models.response,
                         species.empty() ? "" : " for species " + species));
      }
    }
    PredictedResponse result = empty_response(models.response);
    errors_[models.response] = {.mean = missing(), .tree = missing()};
    for (const auto& [model, rows] : rows_of) predict_rows(model->fit, rows, result);
    flag_remarks(models);
    return result;
  }

  /// Uses predictions in place of missing measurements.
  void fill(const std::string& column, const std::vector<double>& predicted) {
    std::vector<double> values(table_.rows(), data::kMissing);
    if (table_.has(column)) {
      require_numbers(table_, {column});
      std::ranges::copy(table_.numbers(column), values.begin());
    }
    std::vector<bool>& filled = filled_[column];
    filled.assign(values.size(), false);
    Errors& errors = errors_[column];
    for (std::size_t row = 0; row < values.size(); ++row) {
      if (!std::isnan(values[row]) || std::isnan(predicted[row])) {
        errors.mean[row] = errors.tree[row] = 0.0;
        continue;
      }
      values[row] = predicted[row];
      filled[row] = true;
    }
    table_.set(column, std::move(values));
  }

  /// How far the last two rules of quadrature differ in marginal means, relative to them.
  double marginal_difference() const { return marginal_difference_; }

  Names joined_flags() const {
    Names result;
    for (const Names& flags : flags_) result.push_back(fmt::format("{}", fmt::join(flags, "; ")));
    return result;
  }

 private:
  void flag(std::size_t row, const std::string& text) {
    if (!contains(flags_[row], text)) flags_[row].push_back(text);
  }

  void flag_remarks(const ResponseModels& models) {
    if (models.remarks.empty()) return;
    for (std::size_t row = 0; row < table_.rows(); ++row) {
      const std::string species = species_of(models, row);
      const bool has_own = models.by_species.contains(species) || models.remarks.contains(species);
      const auto remark = models.remarks.find(has_own ? species : "");
      if (remark != models.remarks.end()) flag(row, remark->second);
    }
  }

  std::string species_of(const ResponseModels& models, std::size_t row) {
    if (!models.is_by_species()) return "";
    if (!table_.has("species")) {
      throw InputError("the column 'species' is missing; the library selects its models by species",
                       {.file = table_.file()});
    }
    if (species_.size() != table_.rows()) species_ = table_.labels("species");
    return std::string(species_[row]);
  }

  /// Standard deviations of a response's predictions, 0 where it was measured.
  struct Errors {
    std::vector<double> mean{};  ///< (N)
    std::vector<double> tree{};  ///< (N)
  };

  std::vector<double> missing() const { return std::vector<double>(table_.rows(), data::kMissing); }
  bool is_calibrated() const { return settings_.level == fit::Level::kCalibrated; }

  PredictedResponse empty_response(const std::string& response) const {
    PredictedResponse result{.response = response, .value = missing()};
    if (settings_.interval > 0.0) result.lower = result.upper = missing();
    if (settings_.wants_errors()) result.standard_error = missing();
    if (is_calibrated()) result.trees = missing();
    return result;
  }

  /// Predictors of some rows that are predicted themselves, with their errors.
  std::vector<fit::UncertainColumn> uncertain_columns(const fit::FittedModel& fit,
                                                      const std::vector<std::size_t>& rows) {
    std::vector<fit::UncertainColumn> result;
    for (const std::string& column : fit.specification.predictors()) {
      if (!filled_.contains(column) || !settings_.wants_errors()) continue;
      const Errors& errors = errors_.at(column);
      fit::UncertainColumn added{.name = column};
      added.mean_variance.resize(static_cast<Eigen::Index>(rows.size()));
      added.tree_variance = added.mean_variance;
      for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto at = static_cast<Eigen::Index>(i);
        added.mean_variance[at] = std::pow(errors.mean[rows[i]], 2);
        added.tree_variance[at] = std::pow(errors.tree[rows[i]], 2);
        const bool has_error = std::isfinite(added.tree_variance[at]);
        if (settings_.interval == 0.0 || !has_error || !filled_.at(column)[rows[i]]) continue;
        flag(rows[i],
             fmt::format(
                 "{} interval includes the error of {}", fit.specification.formula.left, column));
      }
      result.push_back(std::move(added));
    }
    return result;
  }

  /// Trees with predicted predictors are not used for calibration.
  void hide_responses(const fit::FittedModel& fit,
                      const std::vector<std::size_t>& rows,
                      data::Table& part) const {
    const std::string& response = fit.specification.formula.left;
    if (!part.has(response)) return;
    require_numbers(table_, {response});
    const auto measured = part.numbers(response);
    std::vector<double> values(measured.begin(), measured.end());
    for (const std::string& column : fit.specification.predictors()) {
      const auto filled = filled_.find(column);
      if (filled == filled_.end()) continue;
      for (std::size_t i = 0; i < rows.size(); ++i) {
        if (filled->second[rows[i]]) values[i] = data::kMissing;
      }
    }
    part.set(response, std::move(values));
  }

  void predict_rows(const fit::FittedModel& fit,
                    const std::vector<std::size_t>& rows,
                    PredictedResponse& result) {
    require_numbers(table_, fit.specification.predictors());
    data::Table part = table_.select(rows);
    if (const BaseModel* const model = base_model_of(fit, catalogue_)) {
      require_domain_of_covariates(*model, part);
      if (is_calibrated()) require_possible(model->response, part);
    } else if (is_calibrated()) {
      require_not_negative(fit.specification.formula.left, part);
    }
    const bool has_groups =
        settings_.level == fit::Level::kConditional || settings_.level == fit::Level::kCalibrated;
    const bool by_group = has_groups && fit.has_random_effects();
    if (is_calibrated() && by_group) hide_responses(fit, rows, part);
    if (by_group) {
      require_groups(fit.specification);
      unify_groups(fit, part);
    }
    unify_spelling(fit, part);
    flag_columns(fit, part, rows);
    flag_levels(fit, part, rows);
    fit::PredictionOptions how = prediction_options(settings_);
    how.standard_errors = settings_.wants_errors();
    how.uncertain = uncertain_columns(fit, rows);
    const fit::Prediction prediction = fit::predict(fit, part, settings_.level, how);
    marginal_difference_ = std::max(marginal_difference_, prediction.marginal_difference);
    store(fit, rows, prediction, result);
    flag_spread(fit, rows, prediction);
    if (by_group) flag_groups(fit, part, rows, prediction);
    if (is_calibrated() && by_group) flag_unused(fit, part, rows, prediction);
  }

  /// A plot whose label is in the fit is taken as the plot of the fit. Correlated residuals use its
  /// measured trees.
  void flag_unused(const fit::FittedModel& fit,
                   const data::Table& part,
                   const std::vector<std::size_t>& rows,
                   const fit::Prediction& prediction) {
    const std::string& response = fit.specification.formula.left;
    if (!part.has(response) || prediction.calibrated_from.empty()) return;
    if (fit.specification.correlation) return;
    const auto measured = part.numbers(response);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const bool is_fitted = static_cast<double>(prediction.calibrated_from[i]) == kFittedEffects;
      if (!is_fitted || std::isnan(measured[i])) continue;
      flag(rows[i],
           fmt::format("measured {} not used: {} is in the fit",
                       response,
                       fit.specification.random.back().group));
    }
  }

  void unify_groups(const fit::FittedModel& fit, data::Table& part) {
    const std::vector<fit::RandomEffects>& terms = fit.specification.random;
    if (fit::are_crossed(terms)) {
      for (std::size_t t = 0; t < terms.size(); ++t) {
        // Labels of several columns are not those of one.
        if (terms[t].within.empty()) unify_spelling(terms[t].group, fit.random[t].labels, part);
      }
      return;
    }
    if (terms.size() > 1) unify_spelling(terms.front().group, fit.random.front().labels, part);
    unify_spelling(terms.back().group, inner_labels(fit), part);
  }

  void store(const fit::FittedModel& fit,
             const std::vector<std::size_t>& rows,
             const fit::Prediction& prediction,
             PredictedResponse& result) {
    const bool is_mean = settings_.kind_of_errors() == fit::IntervalKind::kConfidence;
    const bool is_spread_unknown = settings_.level == fit::Level::kMarginal &&
                                   fit.has_random_effects() &&
                                   !fit.random.back().covariance.allFinite();
    Errors& errors = errors_.at(result.response);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      const std::size_t row = rows[i];
      const double value = prediction.value[at];
      if (std::isinf(value)) flag(row, fit.specification.formula.left + " not finite");
      const bool is_wanted =
          settings_.new_groups != fit::NewGroups::kMissing || prediction.unknown_terms[i] == 0;
      if (std::isnan(value) && is_spread_unknown) {
        flag(row,
             fmt::format("no marginal {}: the covariance matrix of the random effects is unknown",
                         fit.specification.formula.left));
      } else if (std::isnan(value) && is_wanted && flags_[row].empty()) {
        const std::string& gap = prediction.value_gap[i];
        const std::string& response = fit.specification.formula.left;
        flag(row,
             gap.empty() ? response + " is not defined here"
                         : fmt::format("no {}: {}", response, gap));
      }
      if (!std::isfinite(value)) continue;
      result.value[row] = value;
      if (settings_.wants_errors()) {
        errors.mean[row] = prediction.mean_error[at];
        errors.tree[row] = prediction.prediction_error[at];
        result.standard_error[row] = is_mean ? errors.mean[row] : errors.tree[row];
        if (std::isnan(result.standard_error[row]) && prediction.residual_gap[i].empty()) {
          flag_no_spread(fit, row, "variances unknown");
        }
      }
      if (settings_.interval > 0.0) {
        result.lower[row] = prediction.lower[at];
        result.upper[row] = prediction.upper[at];
      }
      if (is_calibrated()) {
        const bool is_known = !prediction.calibrated_from.empty();
        result.trees[row] = is_known ? static_cast<double>(prediction.calibrated_from[i]) : 0.0;
      }
    }
  }

  /// Why trees that have a prediction have no prediction interval.
  void flag_spread(const fit::FittedModel& fit,
                   const std::vector<std::size_t>& rows,
                   const fit::Prediction& prediction) {
    if (!settings_.wants_errors() || settings_.kind_of_errors() == fit::IntervalKind::kConfidence)
      return;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const bool has_value = std::isfinite(prediction.value[static_cast<Eigen::Index>(i)]);
      if (!has_value || prediction.residual_gap[i].empty()) continue;
      flag_no_spread(fit, rows[i], prediction.residual_gap[i]);
    }
  }

  void flag_no_spread(const fit::FittedModel& fit, std::size_t row, const std::string& reason) {
    flag(row,
         fmt::format("no {} {}: {}",
                     fit.specification.formula.left,
                     settings_.interval > 0.0 ? "interval" : "standard error",
                     reason));
  }

  void flag_groups(const fit::FittedModel& fit,
                   const data::Table& part,
                   const std::vector<std::size_t>& rows,
                   const fit::Prediction& prediction) {
    const std::vector<fit::RandomEffects>& terms = fit.specification.random;
    std::vector<data::TextColumn> labels;
    for (const fit::RandomEffects& term : terms) labels.push_back(part.labels(term.group));
    for (std::size_t i = 0; i < rows.size(); ++i) {
      for (std::size_t t = 0; t < terms.size(); ++t) {
        if ((prediction.unknown_terms[i] >> t & 1U) == 0) continue;
        const std::string& group = terms[t].group;
        // Nested groups are missing with those that they are in.
        const bool is_missing =
            std::any_of(labels.begin() + static_cast<std::ptrdiff_t>(terms[t].is_crossed ? t : 0),
                        labels.begin() + static_cast<std::ptrdiff_t>(t + 1),
                        [i](const data::TextColumn& of) { return of.is_missing(i); });
        if (is_missing) {
          flag(rows[i], "missing " + group);
        } else if (is_calibrated()) {
          flag(rows[i], fmt::format("no measured {} in {}", fit.specification.formula.left, group));
        } else {
          flag(rows[i], "unknown " + group);
        }
      }
    }
  }

  /// The labels of the finer grouping without the labels of the coarser one.
  static Names inner_labels(const fit::FittedModel& fit) {
    Names labels = fit.random.back().labels;
    if (fit.random.size() < 2) return labels;
    for (std::string& label : labels) {
      // The coarser label does not contain a slash there.
      label.erase(0, label.find('/') + 1);
    }
    return labels;
  }

  void require_groups(const fit::ModelSpecification& specification) const {
    for (const fit::RandomEffects& term : specification.random) {
      Names columns = term.within;
      columns.push_back(term.group);
      for (const std::string& column : columns) {
        if (table_.has(column)) continue;
        throw InputError(fmt::format("the column '{}' is missing; {} predictions need it",
                                     column,
                                     is_calibrated() ? "calibrated" : "conditional"),
                         {.file = table_.file()});
      }
    }
  }

  void flag_columns(const fit::FittedModel& fit,
                    const data::Table& part,
                    const std::vector<std::size_t>& rows) {
    for (const std::string& variable : fit.specification.predictors()) {
      const std::string column = data::column_of(variable);
      const std::vector<double> values = data::variable_values(variable, part);
      const auto range = std::ranges::find(fit.ranges, column, &fit::ColumnRange::column);
      const auto filled = filled_.find(column);
      for (std::size_t i = 0; i < rows.size(); ++i) {
        if (std::isnan(values[i])) {
          flag(rows[i], "missing " + column);
        } else if (range != fit.ranges.end() &&
                   (values[i] < range->low || values[i] > range->high)) {
          flag(rows[i], column + " outside fitted range");
        }
        if (filled != filled_.end() && filled->second[rows[i]]) {
          flag(rows[i], column + " predicted");
        }
      }
    }
  }

  /// A label that is not in the fit is treated as one that differs from all labels in the model.
  void flag_levels(const fit::FittedModel& fit,
                   const data::Table& part,
                   const std::vector<std::size_t>& rows) {
    for (const fit::ColumnLevels& levels : fit.levels) {
      const std::vector<bool> is_unknown = has_unknown_label(levels, part);
      for (std::size_t i = 0; i < rows.size(); ++i) {
        if (is_unknown[i]) flag(rows[i], "unknown " + levels.column);
      }
    }
  }

  data::Table table_;
  const PredictionSettings& settings_;
  const Catalogue* catalogue_;
  data::TextColumn species_;
  std::map<std::string, std::vector<bool>> filled_;
  std::map<std::string, Errors> errors_;  ///< by response
  std::vector<Names> flags_;
  double marginal_difference_ = 0.0;
};

}  // namespace

fit::PredictionOptions prediction_options(const PredictionSettings& settings) {
  fit::PredictionOptions options{.new_groups = settings.new_groups,
                                 .seen_groups = settings.seen_groups,
                                 .interval_kind = settings.kind_of_errors(),
                                 .standard_errors = settings.standard_errors,
                                 .threads = settings.threads};
  if (settings.interval != 0.0) options.interval = settings.interval;
  return options;
}

Names text_columns(const ModelLibrary& library) {
  Names columns{"species"};
  for (const LibraryModel& model : library.models) {
    for (const std::string& name : model.fit.specification.label_columns()) {
      if (!contains(columns, name)) columns.push_back(name);
    }
  }
  return columns;
}

Names columns_read(const fit::ModelSpecification& specification) {
  Names columns = specification.label_columns();
  const auto add = [&columns](const std::string& name) {
    if (!name.empty() && !contains(columns, name)) columns.push_back(name);
  };
  std::ranges::for_each(specification.predictors(), add);
  for (const fit::VarianceFactor& factor : specification.variance.factors) add(factor.column);
  if (const auto& correlation = specification.correlation) {
    std::ranges::for_each(correlation->columns, add);
  }
  return columns;
}

Names columns_read(const ModelLibrary& library) {
  Names columns = text_columns(library);
  const auto add = [&columns](const std::string& name) {
    if (!contains(columns, name)) columns.push_back(name);
  };
  for (const LibraryModel& model : library.models) {
    std::ranges::for_each(fit::response_columns(model.response), add);
    std::ranges::for_each(columns_read(model.fit.specification), add);
  }
  return columns;
}

std::string note_on_marginal_means(double marginal_difference) {
  constexpr double kWorthSaying = 1e-5;
  if (marginal_difference <= kWorthSaying) return {};
  return fmt::format("marginal means have a relative error of up to {:.2g} %",
                     100.0 * std::min(marginal_difference, 1.0));
}

PredictedResponses predict_responses(const ModelLibrary& library,
                                     const data::Table& table,
                                     const PredictionSettings& settings,
                                     const Catalogue* catalogue) {
  PredictedResponses result;
  ChosenModels chosen = choose_models(library, table, settings.role);
  result.notes = std::move(chosen.notes);
  result.unused = std::move(chosen.unused);
  const std::vector<ResponseModels>& models = chosen.responses;
  Predictor predictor(table, settings, catalogue);
  result.responses.resize(models.size());
  for (const std::size_t i : order_of(models)) {
    const std::string& response = models[i].response;
    result.responses[i] = predictor.predict(models[i]);
    const bool is_needed = std::ranges::any_of(
        models, [&response](const ResponseModels& other) { return other.needs(response); });
    if (is_needed) predictor.fill(response, result.responses[i].value);
  }
  result.marginal_difference = predictor.marginal_difference();
  result.flags = predictor.joined_flags();
  return result;
}

}  // namespace silvafit::study
