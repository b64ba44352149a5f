// SPDX-License-Identifier: MIT
#include "silvafit/fit/calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "likelihood/effect_posteriors.hpp"
#include "model/group_labels.hpp"
#include "model/model_groups.hpp"
#include "model/symmetric_eigen.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "silvafit/data/program.hpp"

namespace silvafit::fit {
namespace {

void check(const FittedModel& fit, SeenGroups seen) {
  if (!fit.has_random_effects()) {
    throw UsageError("the fit has no random effects to calibrate");
  }
  const bool has_variances = fit.random.back().covariance.allFinite() && std::isfinite(fit.sigma);
  if (fit.estimate.allFinite() && fit.convergence.converged() && !has_variances) {
    throw UsageError(
        "calibration needs the covariance matrix of the random effects and the residual standard "
        "deviation, which the publication does not give; choose another `level`, or fit the model");
  }
  if (!fit.estimate.allFinite() || !has_variances) {
    throw UsageError("the fit has not converged, so it cannot be calibrated");
  }
  if (seen == SeenGroups::kCombined && fit.variance.correlation) {
    throw UsageError(
        "with correlated residuals, further trees of a group depend on its trees in the fit, which "
        "the fit does not store; give all trees of the group, with `seen_groups` new");
  }
  const bool needs_uncertainty =
      seen == SeenGroups::kCombined ||
      (seen == SeenGroups::kFitted && fit.random.size() > 1 && !fit.random.front().labels.empty());
  if (needs_uncertainty && !fit.knows_uncertainty()) {
    throw UsageError(
        "the fit does not store the covariances of its random effects, which are needed to combine "
        "old and new trees; an older version of silvafit wrote it; fit the model again");
  }
}

/// Numbers the groups of one term in the order of their first appearance.
class GroupNumbers {
 public:
  GroupNumbers(const std::vector<std::string>& fitted, CalibratedEffects& term)
      : fitted_(numbered(fitted)), term_(term) {}

  /// \returns -1 if the label is missing
  Index add(const std::string& label) {
    if (label.empty()) return -1;
    const auto [place, is_new] = numbers_.emplace(label, static_cast<Index>(term_.labels.size()));
    if (is_new) {
      const auto known = fitted_.find(label);
      term_.labels.push_back(label);
      term_.fitted_group.push_back(known == fitted_.end() ? -1 : known->second);
    }
    return place->second;
  }

 private:
  LabelNumbers fitted_;
  LabelNumbers numbers_;
  CalibratedEffects& term_;
};

void number_groups(const FittedModel& fit,
                   const data::Table& table,
                   SeenGroups seen,
                   Calibration& result) {
  const GroupLabels labels(fit.specification, table);
  result.random.resize(fit.random.size());
  for (CalibratedEffects& term : result.random) term.group_of_row.assign(table.rows(), -1);
  result.is_used.assign(table.rows(), false);
  std::vector<GroupNumbers> numbers;
  for (std::size_t t = 0; t < fit.random.size(); ++t) {
    numbers.emplace_back(fit.random[t].labels, result.random[t]);
  }
  for (std::size_t t = 0; t < numbers.size(); ++t) {
    for (std::size_t row = 0; row < table.rows(); ++row) {
      result.random[t].group_of_row[row] = numbers[t].add(labels.of(t, row));
    }
    // The trees of all groups are connected by those of another term.
    if (numbers.size() > 1 && seen != SeenGroups::kNew) {
      for (const std::string& label : fit.random[t].labels) numbers[t].add(label);
    }
    result.random[t].measured.assign(result.random[t].labels.size(), 0);
  }
}

/// (N) whether the variance function knows a row's stratum.
std::vector<bool> has_known_strata(const FittedModel& fit, const data::Table& table) {
  const VectorXd ones = VectorXd::Ones(static_cast<Index>(table.rows()));
  const VectorXd scale = relative_sd(fit.variance, ones, table);
  std::vector<bool> result(table.rows());
  for (std::size_t row = 0; row < result.size(); ++row) {
    result[row] = !std::isnan(scale[static_cast<Index>(row)]);
  }
  return result;
}

/// The groups of a row in all terms; empty if one is missing.
std::vector<std::size_t> groups_of(const Calibration& calibration, std::size_t row) {
  std::vector<std::size_t> result;
  for (const CalibratedEffects& term : calibration.random) {
    if (term.group_of_row[row] < 0) return {};
    result.push_back(static_cast<std::size_t>(term.group_of_row[row]));
  }
  return result;
}

void check_responses(std::span<const double> values,
                     const std::string& name,
                     const data::Table& table) {
  const auto found = std::ranges::find_if(values, [](double value) { return std::isinf(value); });
  if (found == values.end()) return;
  const auto row = static_cast<std::size_t>(found - values.begin());
  throw InputError("a value is infinite; a missing value marks where the response was not measured",
                   data::place_of(table, row, name));
}

/// Marks the rows to calibrate from: those with a response, all predictors and groups.
void choose_rows(const FittedModel& fit,
                 const data::Table& table,
                 SeenGroups seen,
                 Calibration& result) {
  const std::string& response = fit.specification.formula.left;
  if (!table.has(response) || !table.is_numeric(response)) return;
  const std::vector<bool> known = has_known_strata(fit, table);
  std::vector<std::vector<double>> columns;
  for (const std::string& name : fit.specification.predictors()) {
    columns.push_back(data::variable_values(name, table));
  }
  const auto responses = table.numbers(response);
  check_responses(responses, response, table);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::vector<std::size_t> groups = groups_of(result, row);
    if (groups.empty() || !known[row] || !std::isfinite(responses[row])) continue;
    const auto is_there = [row](const auto& column) { return std::isfinite(column[row]); };
    if (!std::ranges::all_of(columns, is_there)) continue;
    bool are_fitted = true;
    for (std::size_t t = 0; t < groups.size(); ++t) {
      are_fitted = are_fitted && result.random[t].fitted_group[groups[t]] >= 0;
    }
    if (seen == SeenGroups::kFitted && are_fitted) continue;
    result.is_used[row] = true;
    for (std::size_t t = 0; t < groups.size(); ++t) ++result.random[t].measured[groups[t]];
  }
}

/// Priors and posteriors of the effects of groups, from the fit and the table.
class Calibrator {
 public:
  Calibrator(const FittedModel& fit, SeenGroups seen, Calibration& result)
      : fit_(fit), seen_(seen), terms_(result.random), cells_(result.cells) {}

  /// Before any tree of the table.
  void set_priors() {
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      const EstimatedEffects& fitted = fit_.random[t];
      const Index q = std::ssize(fitted.names);
      const Index groups = std::ssize(terms_[t].labels);
      terms_[t].effects.setZero(q, groups);
      terms_[t].uncertainty = {.covariances = fitted.covariance.reshaped().replicate(1, groups),
                               .sensitivities = MatrixXd::Zero(q * fit_.estimate.size(), groups)};
      for (Index k = 0; k < groups; ++k) {
        const Index of = terms_[t].fitted_group[static_cast<std::size_t>(k)];
        if (seen_ == SeenGroups::kNew || of < 0) continue;
        terms_[t].effects.col(k) = fitted.effects.col(of);
        copy(fitted.uncertainty, of, terms_[t].uncertainty, k);
      }
    }
    if (terms_.size() > 1) set_cells();
  }

  /// The posteriors given the trees.
  void update(const NonlinearModel& model, unsigned threads) {
    const std::vector<std::vector<Index>> numbers = numbers_of(model);
    if (terms_.size() > 1) {
      update_joint(model, numbers);
      return;
    }
    const std::vector<Index>& own = numbers.front();
    EffectPosteriors found = find_effects(model, fit_, priors_of(model, own), threads);
    for (std::size_t k = 0; k < own.size(); ++k) {
      take(found.terms.front(), static_cast<Index>(k), terms_.front(), own[k]);
    }
  }

 private:
  static void copy(const EffectUncertainty& from, Index k, EffectUncertainty& to, Index at) {
    if (!from.is_known()) {
      to.covariances.col(at).setConstant(kNaN);
      to.sensitivities.col(at).setConstant(kNaN);
      return;
    }
    to.covariances.col(at) = from.covariances.col(k);
    to.sensitivities.col(at) = from.sensitivities.col(k);
  }
  static void take(const EffectPosterior& from, Index k, CalibratedEffects& to, Index at) {
    to.effects.col(at) = from.effects.col(k);
    copy(from.uncertainty, k, to.uncertainty, at);
  }

  /// The cells of the fit, if its groups count.
  void set_cells() {
    cells_.groups.resize(terms_.size());
    if (seen_ == SeenGroups::kNew) return;
    cells_.curvatures = fit_.cells.curvatures;
    for (std::size_t t = 0; t < fit_.cells.groups.size(); ++t) {
      const LabelNumbers numbers = numbered(terms_[t].labels);
      for (const Index group : fit_.cells.groups[t]) {
        const std::string& label = fit_.random[t].labels[static_cast<std::size_t>(group)];
        cells_.groups[t].push_back(numbers.at(label));
      }
    }
  }

  /// The effects of all groups of several terms together.
  /// \param numbers  see numbers_of
  void update_joint(const NonlinearModel& model, const std::vector<std::vector<Index>>& numbers) {
    std::vector<std::vector<std::string>> labels;
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      labels.push_back(terms_[t].labels);
      for (Index cell = 0; cell < model.group_count(); ++cell) {
        const auto group = static_cast<std::size_t>(model.group_of(t, cell));
        cells_.groups[t].push_back(numbers[t][group]);
      }
    }
    const ModelGroups groups = ModelGroups::one_cluster(std::move(labels), cells_.groups);
    EffectPriors priors = priors_of_new_groups(groups, fit_);
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      priors.means[t] = terms_[t].effects;
      priors.slopes.push_back(terms_[t].uncertainty.sensitivities);
    }
    EffectPosteriors found = find_joint_effects(model, fit_, groups, cells_.curvatures, priors);
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      for (const Index group : cells_.groups[t]) {  // others have no trees
        take(found.terms[t], group, terms_[t], group);
      }
    }
    cells_.curvatures = std::move(found.curvatures);
  }

  /// The numbers of the model's groups of each term among those of the table.
  std::vector<std::vector<Index>> numbers_of(const NonlinearModel& model) const {
    std::vector<std::vector<Index>> result;
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      const LabelNumbers known = numbered(terms_[t].labels);
      std::vector<Index>& numbers = result.emplace_back();
      for (const std::string& label : model.group_labels(t)) numbers.push_back(known.at(label));
    }
    return result;
  }

  /// The posteriors of the fit are the priors of the groups of a single term, if they count.
  /// \param numbers  of the model's groups
  EffectPriors priors_of(const NonlinearModel& model, const std::vector<Index>& numbers) const {
    EffectPriors priors = priors_of_new_groups(model.groups(), fit_);
    if (seen_ == SeenGroups::kNew) return priors;
    const CalibratedEffects& term = terms_.front();
    priors.slopes.emplace_back(term.uncertainty.sensitivities(Eigen::all, numbers));
    priors.means.front() = term.effects(Eigen::all, numbers);
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      if (term.fitted_group[static_cast<std::size_t>(numbers[k])] < 0) continue;
      priors.roots_of[k] = std::ssize(priors.roots);
      priors.roots.push_back(
          covariance_factor(term.uncertainty.covariance(numbers[k], term.effects.rows())));
    }
    return priors;
  }

  const FittedModel& fit_;
  SeenGroups seen_;
  std::vector<CalibratedEffects>& terms_;
  EffectCells& cells_;
};

}  // namespace

Calibration calibrate(const FittedModel& fit,
                      const data::Table& table,
                      const CalibrationOptions& options) {
  check(fit, options.seen_groups);
  Calibration result;
  number_groups(fit, table, options.seen_groups, result);
  choose_rows(fit, table, options.seen_groups, result);
  Calibrator calibrator(fit, options.seen_groups, result);
  calibrator.set_priors();
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (result.is_used[row]) rows.push_back(row);
  }
  if (rows.empty()) return result;
  // The variance function of the estimate weights the trees.
  ModelSpecification specification = fit.specification;
  specification.variance = fit.variance.function();
  calibrator.update(NonlinearModel(specification, table.select(rows)), options.threads);
  return result;
}

}  // namespace silvafit::fit
