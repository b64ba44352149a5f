// SPDX-License-Identifier: MIT
#include "silvafit/fit/calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "conditional_modes/effect_posteriors.hpp"
#include "model/covariance_factor.hpp"
#include "model/group_labels.hpp"
#include "result/nested_effects.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/program.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void check(const FittedModel& fit, SeenGroups seen) {
  if (!fit.has_random_effects()) {
    throw UsageError("the fit has no random effects to calibrate");
  }
  const bool has_variances = finer(fit).covariance.allFinite() && std::isfinite(fit.sigma);
  if (fit.estimate.allFinite() && fit.convergence.converged() && !has_variances) {
    throw UsageError(
        "calibration needs the covariance matrix of the random effects and the residual standard "
        "deviation, which the publication does not give; choose another `level`, or fit the model");
  }
  if (!fit.estimate.allFinite() || !has_variances) {
    throw UsageError("the fit has not converged, so it cannot be calibrated");
  }
  if (seen == SeenGroups::kCombined && !finer(fit).uncertainty.is_known()) {
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

void number_groups(const FittedModel& fit, const data::Table& table, Calibration& result) {
  const GroupLabels labels(fit.specification, table);
  result.random.resize(fit.random.size());
  for (CalibratedEffects& term : result.random) term.group_of_row.assign(table.rows(), -1);
  result.is_used.assign(table.rows(), false);
  CalibratedEffects& inner = result.random.back();
  const bool is_nested = result.random.size() > 1;
  GroupNumbers inner_numbers(finer(fit).labels, inner);
  GroupNumbers outer_numbers(coarser(fit).labels, result.random.front());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const Index of = is_nested ? outer_numbers.add(labels.outer(row), -1) : -1;
    if (is_nested) result.random.front().group_of_row[row] = of;
    inner.group_of_row[row] = inner_numbers.add(labels.inner(row), of);
  }
  result.measured.assign(inner.labels.size(), 0);
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

/// Marks the rows to calibrate from: those with a response, all predictors and a group.
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
  const CalibratedEffects& term = result.random.back();
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const Index group = term.group_of_row[row];
    if (group < 0 || !known[row] || !std::isfinite(responses[row])) continue;
    const auto is_there = [row](const auto& column) { return std::isfinite(column[row]); };
    if (!std::ranges::all_of(columns, is_there)) continue;
    if (seen == SeenGroups::kFitted && term.fitted_group[static_cast<std::size_t>(group)] >= 0) {
      continue;
    }
    result.is_used[row] = true;
    ++result.measured[static_cast<std::size_t>(group)];
  }
}

/// Priors and posteriors of the effects of groups, from the fit and the table.
class Calibrator {
 public:
  Calibrator(const FittedModel& fit, SeenGroups seen, Calibration& result)
      : fit_(fit),
        seen_(seen),
        inner_(result.random.back()),
        outer_(result.random.size() > 1 ? result.random.front() : none_),
        q_(static_cast<Index>(finer(fit).names.size())),
        s_(static_cast<Index>(coarser(fit).names.size())),
        p_(fit.estimate.size()),
        inner_root_(covariance_factor(finer(fit).covariance)),
        outer_root_(covariance_factor(coarser(fit).covariance)) {}

  /// Before any tree of the table.
  void set_priors() {
    const auto groups = static_cast<Index>(inner_.labels.size());
    const auto clusters = static_cast<Index>(outer_.labels.size());
    inner_.effects.setZero(q_, groups);
    inner_.uncertainty = {.covariances = MatrixXd::Zero(q_ * q_, groups),
                          .sensitivities = MatrixXd::Zero(q_ * p_, groups),
                          .cross_covariances = MatrixXd::Zero(q_ * s_, groups)};
    outer_.effects.setZero(s_, clusters);
    outer_.uncertainty = {.covariances = MatrixXd::Zero(s_ * s_, clusters),
                          .sensitivities = MatrixXd::Zero(s_ * p_, clusters)};
    for (Index c = 0; c < clusters; ++c) set_outer_prior(c);
    for (Index g = 0; g < groups; ++g) set_inner_prior(g);
  }

  /// The posteriors given the trees.
  void update(const NonlinearModel& model, unsigned threads) {
    EffectPriors priors = priors_of_new_groups(model, fit_);
    if (seen_ != SeenGroups::kNew) fill_priors(model, priors);
    const EffectPosteriors found = find_effects(model, fit_, priors, threads);
    take_over(model, found);
  }

 private:
  /// Whether the prior of a group is the fit's posterior.
  bool counts_fitted(Index fitted) const { return seen_ != SeenGroups::kNew && fitted >= 0; }

  void set_outer_prior(Index c) {
    const Index of = outer_.fitted_group[static_cast<std::size_t>(c)];
    if (!counts_fitted(of)) {
      outer_.uncertainty.covariances.col(c) = coarser(fit_).covariance.reshaped();
      return;
    }
    outer_.effects.col(c) = coarser(fit_).effects.col(of);
    copy(coarser(fit_).uncertainty, of, outer_.uncertainty, c);
  }

  void set_inner_prior(Index g) {
    const Index of = inner_.fitted_group[static_cast<std::size_t>(g)];
    if (!counts_fitted(of)) {
      inner_.uncertainty.covariances.col(g) = finer(fit_).covariance.reshaped();
      return;
    }
    inner_.effects.col(g) = finer(fit_).effects.col(of);
    copy(finer(fit_).uncertainty, of, inner_.uncertainty, g);
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

  /// The roots of the conditional covariances of a group, given those of its coarser group.
  EffectRoots roots_of(Index g, const MatrixXd& outer_root) const {
    EffectRoots roots{
        .outer = outer_root, .coupling = MatrixXd::Zero(q_, s_), .inner = inner_root_};
    if (!counts_fitted(inner_.fitted_group[static_cast<std::size_t>(g)])) return roots;
    const MatrixXd covariance = inner_.uncertainty.covariance(g, q_);
    if (s_ == 0) {
      roots.inner = covariance_factor(covariance);
      return roots;
    }
    const Index c = inner_.coarser_group[static_cast<std::size_t>(g)];
    const MatrixXd cross = inner_.uncertainty.cross_covariance(g, q_, s_);
    const MatrixXd slopes = regression_on(cross, outer_.uncertainty.covariance(c, s_));
    roots.coupling = slopes * outer_root;
    roots.inner = covariance_factor(covariance - slopes * cross.transpose());
    return roots;
  }

  MatrixXd outer_root_of(Index c) const {
    if (s_ == 0) return MatrixXd(0, 0);
    if (!counts_fitted(outer_.fitted_group[static_cast<std::size_t>(c)])) return outer_root_;
    require_outer_covariances();
    return covariance_factor(outer_.uncertainty.covariance(c, s_));
  }

  void require_outer_covariances() const {
    if (coarser(fit_).uncertainty.is_known()) return;
    throw UsageError(fmt::format(
        "the fit does not store the covariances of the random effects by {}, which new groups "
        "within them need; an older version of silvafit wrote it; fit the model again",
        fit_.specification.random.front().group));
  }

  void fill_priors(const NonlinearModel& model, EffectPriors& priors) {
    const LabelNumbers inner = numbered(inner_.labels);
    const LabelNumbers outer = numbered(outer_.labels);
    priors.inner_slope.setZero(q_ * p_, model.group_count());
    if (s_ > 0) priors.outer_slope.setZero(s_ * p_, model.cluster_count());
    bool any = false;
    for (Index k = 0; k < model.cluster_count(); ++k) {
      const Index c = s_ > 0 ? outer.at(model.outer_labels()[static_cast<std::size_t>(k)]) : -1;
      const bool is_outer_fitted =
          s_ > 0 && counts_fitted(outer_.fitted_group[static_cast<std::size_t>(c)]);
      const MatrixXd outer_root = outer_root_of(c);
      if (is_outer_fitted) {
        priors.outer_mean.col(k) = outer_.effects.col(c);
        priors.outer_slope.col(k) = outer_.uncertainty.sensitivities.col(c);
      }
      for (Index m = model.cluster_begin(k); m < model.cluster_begin(k + 1); ++m) {
        const Index g = inner.at(model.group_labels()[static_cast<std::size_t>(m)]);
        const bool is_fitted = counts_fitted(inner_.fitted_group[static_cast<std::size_t>(g)]);
        if (!is_fitted && !is_outer_fitted) continue;
        any = true;
        priors.roots_of[static_cast<std::size_t>(m)] = static_cast<Index>(priors.roots.size());
        priors.roots.push_back(roots_of(g, outer_root));
        if (!is_fitted) continue;
        priors.inner_mean.col(m) = inner_.effects.col(g);
        priors.inner_slope.col(m) = inner_.uncertainty.sensitivities.col(g);
      }
    }
    if (any) return;
    priors.inner_slope.resize(0, 0);
    priors.outer_slope.resize(0, 0);
  }

  void take_over(const NonlinearModel& model, const EffectPosteriors& found) {
    const LabelNumbers inner = numbered(inner_.labels);
    const LabelNumbers outer = numbered(outer_.labels);
    std::vector<Index> found_cluster(outer_.labels.size(), -1);
    std::vector<bool> is_found(inner_.labels.size(), false);
    // Groups without trees follow their coarser group, so that its earlier values are needed.
    const CalibratedEffects inner_before = s_ > 0 ? inner_ : CalibratedEffects{};
    const CalibratedEffects outer_before = outer_;
    for (Index k = 0; k < model.cluster_count(); ++k) {
      if (s_ > 0) {
        const Index c = outer.at(model.outer_labels()[static_cast<std::size_t>(k)]);
        found_cluster[static_cast<std::size_t>(c)] = k;
        outer_.effects.col(c) = found.outer.col(k);
        copy(found.outer_uncertainty, k, outer_.uncertainty, c);
      }
      for (Index m = model.cluster_begin(k); m < model.cluster_begin(k + 1); ++m) {
        const Index g = inner.at(model.group_labels()[static_cast<std::size_t>(m)]);
        is_found[static_cast<std::size_t>(g)] = true;
        inner_.effects.col(g) = found.inner.col(m);
        copy(found.inner_uncertainty, m, inner_.uncertainty, g);
      }
    }
    if (s_ == 0) return;
    for (Index g = 0; g < static_cast<Index>(is_found.size()); ++g) {
      const Index c = inner_.coarser_group[static_cast<std::size_t>(g)];
      const Index k = found_cluster[static_cast<std::size_t>(c)];
      if (!is_found[static_cast<std::size_t>(g)] && k >= 0)
        follow(inner_before, outer_before, found, g, c, k);
    }
  }

  /// A group without trees in a coarser group that has some.
  void follow(const CalibratedEffects& inner_before,
              const CalibratedEffects& outer_before,
              const EffectPosteriors& found,
              Index g,
              Index c,
              Index k) {
    const bool is_fitted = counts_fitted(inner_before.fitted_group[static_cast<std::size_t>(g)]);
    if (!is_fitted) return;
    const MatrixXd cross = inner_before.uncertainty.cross_covariance(g, q_, s_);
    const MatrixXd old_outer = outer_before.uncertainty.covariance(c, s_);
    const MatrixXd slopes = regression_on(cross, old_outer);
    inner_.effects.col(g) += slopes * (found.outer.col(k) - outer_before.effects.col(c));
    const MatrixXd outer = found.outer_uncertainty.covariance(k, s_);
    inner_.uncertainty.covariances.col(g) = (inner_before.uncertainty.covariance(g, q_) +
                                             slopes * (outer - old_outer) * slopes.transpose())
                                                .reshaped();
    inner_.uncertainty.cross_covariances.col(g) = (slopes * outer).reshaped();
    inner_.uncertainty.sensitivities.col(g) +=
        (slopes * (found.outer_uncertainty.sensitivity(k, s_, p_) -
                   outer_before.uncertainty.sensitivity(c, s_, p_)))
            .reshaped();
  }

  const FittedModel& fit_;
  SeenGroups seen_;
  CalibratedEffects& inner_;
  CalibratedEffects none_{};  ///< of the coarser grouping, where there is none
  CalibratedEffects& outer_;
  Index q_;
  Index s_;
  Index p_;
  MatrixXd inner_root_;
  MatrixXd outer_root_;
};

}  // namespace

Calibration calibrate(const FittedModel& fit,
                      const data::Table& table,
                      const CalibrationOptions& options) {
  check(fit, options.seen_groups);
  Calibration result;
  number_groups(fit, table, result);
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
