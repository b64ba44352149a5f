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
      (seen == SeenGroups::kFitted && are_crossed(fit.specification.random));
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

  /// \param coarser  number of the group's coarser group
  /// \returns -1 if the label is missing
  Index add(const std::string& label, Index coarser) {
    if (label.empty()) return -1;
    const auto [place, is_new] = numbers_.emplace(label, static_cast<Index>(term_.labels.size()));
    if (is_new) {
      const auto known = fitted_.find(label);
      term_.labels.push_back(label);
      term_.coarser_group.push_back(coarser);
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
  const bool is_crossed = are_crossed(fit.specification.random);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    Index group = -1;
    for (std::size_t t = 0; t < numbers.size(); ++t) {
      group = numbers[t].add(labels.of(t, row), is_crossed ? -1 : group);
      result.random[t].group_of_row[row] = group;
    }
  }
  for (std::size_t t = 0; t < numbers.size(); ++t) {
    if (is_crossed && seen != SeenGroups::kNew) {
      for (const std::string& label : fit.random[t].labels) numbers[t].add(label, -1);
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
      : fit_(fit),
        seen_(seen),
        terms_(result.random),
        cells_(result.cells),
        is_crossed_(are_crossed(fit.specification.random)),
        p_(fit.estimate.size()) {
    for (const EstimatedEffects& term : fit.random) {
      roots_.push_back(covariance_factor(term.covariance));
    }
  }

  /// Before any tree of the table.
  void set_priors() {
    Index before = 0;
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      const Index groups = std::ssize(terms_[t].labels);
      terms_[t].effects.setZero(q(t), groups);
      terms_[t].uncertainty = {.covariances = MatrixXd::Zero(q(t) * q(t), groups),
                               .sensitivities = MatrixXd::Zero(q(t) * p_, groups),
                               .cross_covariances = MatrixXd::Zero(q(t) * before, groups)};
      for (Index k = 0; k < groups; ++k) set_prior(t, k);
      if (!is_crossed_) before += q(t);
    }
    if (is_crossed_) set_cells();
  }

  /// The posteriors given the trees.
  void update(const NonlinearModel& model, unsigned threads) {
    number_groups(model);
    if (is_crossed_) {
      update_crossed(model);
      return;
    }
    EffectPriors priors = priors_of_new_groups(model.groups(), fit_);
    if (seen_ != SeenGroups::kNew) fill_priors(model, priors);
    take_over(find_effects(model, fit_, priors, threads).terms);
  }

 private:
  Index q(std::size_t term) const { return std::ssize(fit_.random[term].names); }

  /// Whether the prior of a group is the fit's posterior.
  bool counts_fitted(const CalibratedEffects& term, Index group) const {
    return seen_ != SeenGroups::kNew && term.fitted_group[static_cast<std::size_t>(group)] >= 0;
  }

  void set_prior(std::size_t t, Index k) {
    const EstimatedEffects& fitted = fit_.random[t];
    if (!counts_fitted(terms_[t], k)) {
      terms_[t].uncertainty.covariances.col(k) = fitted.covariance.reshaped();
      return;
    }
    const Index of = terms_[t].fitted_group[static_cast<std::size_t>(k)];
    terms_[t].effects.col(k) = fitted.effects.col(of);
    copy(fitted.uncertainty, of, terms_[t].uncertainty, k);
  }

  static void copy(const EffectUncertainty& from, Index k, EffectUncertainty& to, Index at) {
    if (!from.is_known()) {
      to.covariances.col(at).setConstant(kNaN);
      to.sensitivities.col(at).setConstant(kNaN);
      to.cross_covariances.col(at).setConstant(kNaN);
      return;
    }
    to.covariances.col(at) = from.covariances.col(k);
    to.sensitivities.col(at) = from.sensitivities.col(k);
    if (from.cross_covariances.size() > 0) {
      to.cross_covariances.col(at) = from.cross_covariances.col(k);
    }
  }

  /// The cells of the fit, if its groups count.
  void set_cells() {
    cells_.groups.resize(terms_.size());
    if (seen_ == SeenGroups::kNew) return;
    cells_.curvatures = fit_.cells.curvatures;
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      const LabelNumbers numbers = numbered(terms_[t].labels);
      for (const Index group : fit_.cells.groups[t]) {
        const std::string& label = fit_.random[t].labels[static_cast<std::size_t>(group)];
        cells_.groups[t].push_back(numbers.at(label));
      }
    }
  }

  /// The effects of all groups together.
  void update_crossed(const NonlinearModel& model) {
    std::vector<std::vector<std::string>> labels;
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      labels.push_back(terms_[t].labels);
      for (Index cell = 0; cell < model.group_count(); ++cell) {
        const auto group = static_cast<std::size_t>(model.group_of(t, cell));
        cells_.groups[t].push_back(numbers_[t][group]);
      }
    }
    const ModelGroups groups = ModelGroups::one_cluster(std::move(labels), cells_.groups);
    EffectPriors priors = priors_of_new_groups(groups, fit_);
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      priors.means[t] = terms_[t].effects;
      priors.slopes.push_back(terms_[t].uncertainty.sensitivities);
    }
    EffectPosteriors found = find_crossed_effects(model, fit_, groups, cells_.curvatures, priors);
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      for (const Index group : cells_.groups[t]) {  // others have no trees
        terms_[t].effects.col(group) = found.terms[t].effects.col(group);
        copy(found.terms[t].uncertainty, group, terms_[t].uncertainty, group);
      }
    }
    cells_.curvatures = std::move(found.curvatures);
  }

  /// The numbers of the model's groups among those of the table.
  void number_groups(const NonlinearModel& model) {
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      const LabelNumbers known = numbered(terms_[t].labels);
      std::vector<Index>& numbers = numbers_.emplace_back();
      for (const std::string& label : model.group_labels(t)) numbers.push_back(known.at(label));
    }
  }

  /// The root of the joint prior covariance of the effects of all terms that act on a group, each
  /// given those of the terms before it.
  /// \param groups  of each term
  MatrixXd root_of(const std::vector<Index>& groups) const {
    Index size = 0;
    for (std::size_t t = 0; t < terms_.size(); ++t) size += q(t);
    MatrixXd root = MatrixXd::Zero(size, size);
    MatrixXd covariance = root;
    Index row = 0;
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      const Index count = q(t);
      auto own = root.block(row, row, count, count);
      own = roots_[t];
      covariance.block(row, row, count, count) = terms_[t].uncertainty.covariance(groups[t], count);
      if (counts_fitted(terms_[t], groups[t])) {
        require_covariances(t);
        const MatrixXd cross = terms_[t].uncertainty.cross_covariance(groups[t], count, row);
        const MatrixXd slopes = regression_on(cross, covariance.topLeftCorner(row, row));
        root.block(row, 0, count, row) = slopes * root.topLeftCorner(row, row);
        own = covariance_factor(covariance.block(row, row, count, count) -
                                slopes * cross.transpose());
        covariance.block(row, 0, count, row) = cross;
        covariance.block(0, row, row, count) = cross.transpose();
      }
      row += count;
    }
    return root;
  }

  void require_covariances(std::size_t term) const {
    if (fit_.random[term].uncertainty.is_known()) return;
    throw UsageError(fmt::format(
        "the fit does not store the covariances of the random effects by {}, which new groups "
        "within them need; an older version of silvafit wrote it; fit the model again",
        fit_.specification.random[term].group));
  }

  void fill_priors(const NonlinearModel& model, EffectPriors& priors) {
    bool any = false;
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      MatrixXd& slopes = priors.slopes.emplace_back();
      slopes.setZero(q(t) * p_, model.group_count(t));
      for (Index k = 0; k < slopes.cols(); ++k) {
        const Index number = numbers_[t][static_cast<std::size_t>(k)];
        if (!counts_fitted(terms_[t], number)) continue;
        any = true;
        priors.means[t].col(k) = terms_[t].effects.col(number);
        slopes.col(k) = terms_[t].uncertainty.sensitivities.col(number);
      }
    }
    if (!any) {
      priors.slopes.clear();
      return;
    }
    std::vector<Index> groups(terms_.size());
    for (Index g = 0; g < model.group_count(); ++g) {
      bool is_fitted = false;
      for (std::size_t t = 0; t < terms_.size(); ++t) {
        groups[t] = numbers_[t][static_cast<std::size_t>(model.group_of(t, g))];
        is_fitted = is_fitted || counts_fitted(terms_[t], groups[t]);
      }
      if (!is_fitted) continue;
      priors.roots_of[static_cast<std::size_t>(g)] = std::ssize(priors.roots);
      priors.roots.push_back(root_of(groups));
    }
  }

  void take_over(const std::vector<EffectPosterior>& found) {
    // Groups without trees follow the one that they are in, so that earlier values are needed.
    const std::vector<CalibratedEffects> before = terms_;
    std::vector<Index> found_before;  // groups of the term before among those found, or -1
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      std::vector<Index> found_group(terms_[t].labels.size(), -1);
      for (std::size_t k = 0; k < numbers_[t].size(); ++k) {
        const Index number = numbers_[t][k];
        const auto at = static_cast<Index>(k);
        found_group[static_cast<std::size_t>(number)] = at;
        terms_[t].effects.col(number) = found[t].effects.col(at);
        copy(found[t].uncertainty, at, terms_[t].uncertainty, number);
      }
      for (std::size_t g = 0; t > 0 && g < found_group.size(); ++g) {
        const Index coarser = terms_[t].coarser_group[g];
        if (found_group[g] >= 0 || found_before[static_cast<std::size_t>(coarser)] < 0) continue;
        follow(before, t, static_cast<Index>(g));
      }
      found_before = std::move(found_group);
    }
  }

  /// A group without trees in a group of the term before that has some.
  void follow(const std::vector<CalibratedEffects>& before, std::size_t t, Index g) {
    if (!counts_fitted(terms_[t], g)) return;
    const CalibratedEffects& coarser = terms_[t - 1];
    const Index c = terms_[t].coarser_group[static_cast<std::size_t>(g)];
    const Index s = q(t - 1);
    const EffectUncertainty& old = before[t].uncertainty;
    const MatrixXd cross = old.cross_covariance(g, q(t), s);
    const MatrixXd old_coarser = before[t - 1].uncertainty.covariance(c, s);
    const MatrixXd new_coarser = coarser.uncertainty.covariance(c, s);
    const MatrixXd slopes = regression_on(cross, old_coarser);
    terms_[t].effects.col(g) += slopes * (coarser.effects.col(c) - before[t - 1].effects.col(c));
    EffectUncertainty& own = terms_[t].uncertainty;
    own.covariances.col(g) =
        (old.covariance(g, q(t)) + slopes * (new_coarser - old_coarser) * slopes.transpose())
            .reshaped();
    own.cross_covariances.col(g) = (slopes * new_coarser).reshaped();
    own.sensitivities.col(g) += (slopes * (coarser.uncertainty.sensitivity(c, s, p_) -
                                           before[t - 1].uncertainty.sensitivity(c, s, p_)))
                                    .reshaped();
  }

  const FittedModel& fit_;
  SeenGroups seen_;
  std::vector<CalibratedEffects>& terms_;
  EffectCells& cells_;
  bool is_crossed_;
  Index p_;
  std::vector<MatrixXd> roots_;              ///< (q x q) of Psi of each term
  std::vector<std::vector<Index>> numbers_;  ///< of the model's groups among those of the table
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
