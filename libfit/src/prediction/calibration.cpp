// SPDX-License-Identifier: MIT
#include "silvafit/fit/calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "conditional_modes/calibration_search.hpp"
#include "model/covariance_factor.hpp"
#include "model/group_labels.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/program.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Index number_in(const LabelNumbers& numbers, const std::string& label) {
  const auto found = numbers.find(label);
  return found == numbers.end() ? -1 : found->second;
}

void check(const FittedModel& fit, SeenGroups seen) {
  if (!fit.has_random_effects()) {
    throw UsageError("the fit has no random effects to calibrate");
  }
  const bool has_variances = fit.random_covariance.allFinite() && std::isfinite(fit.sigma);
  if (fit.estimate.allFinite() && fit.convergence.converged() && !has_variances) {
    throw UsageError(
        "calibration needs the covariance matrix of the random effects and the residual standard "
        "deviation, which the publication does not give; choose another --level, or fit the model");
  }
  if (!fit.estimate.allFinite() || !has_variances) {
    throw UsageError("the fit has not converged, so it cannot be calibrated");
  }
  if (seen == SeenGroups::kCombined && !fit.uncertainty.is_known()) {
    throw UsageError(
        "the fit does not store the covariances of its random effects, which are needed to combine "
        "old and new trees; an older version of silvafit wrote it; fit the model again");
  }
}

/// Numbers the groups of a table in the order of their first appearance.
void number_groups(const FittedModel& fit, const data::Table& table, Calibration& result) {
  const GroupLabels labels(fit.specification, table);
  const bool is_nested = fit.specification.outer_random.has_value();
  LabelNumbers inner;
  LabelNumbers outer;
  const LabelNumbers fitted = numbered(fit.group_labels);
  const LabelNumbers fitted_outer = numbered(fit.outer.labels);
  result.group_of_row.assign(table.rows(), -1);
  result.outer_of_row.assign(table.rows(), -1);
  result.is_used.assign(table.rows(), false);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    Index& outer_number = result.outer_of_row[row];
    if (is_nested) {
      const std::string label = labels.outer(row);
      if (!label.empty()) {
        const auto [place, is_new] =
            outer.emplace(label, static_cast<Index>(result.outer_labels.size()));
        if (is_new) {
          result.outer_labels.push_back(label);
          result.fitted_outer.push_back(number_in(fitted_outer, label));
        }
        outer_number = place->second;
      }
    }
    const std::string label = labels.inner(row);
    if (label.empty()) continue;
    const auto [place, is_new] =
        inner.emplace(label, static_cast<Index>(result.group_labels.size()));
    if (is_new) {
      result.group_labels.push_back(label);
      result.outer_of.push_back(outer_number);
      result.fitted_group.push_back(number_in(fitted, label));
    }
    result.group_of_row[row] = place->second;
  }
  result.measured.assign(result.group_labels.size(), 0);
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
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const Index group = result.group_of_row[row];
    if (group < 0 || !known[row] || !std::isfinite(responses[row])) continue;
    const auto is_there = [row](const auto& column) { return std::isfinite(column[row]); };
    if (!std::ranges::all_of(columns, is_there)) continue;
    if (seen == SeenGroups::kFitted && result.fitted_group[static_cast<std::size_t>(group)] >= 0) {
      continue;
    }
    result.is_used[row] = true;
    ++result.measured[static_cast<std::size_t>(group)];
  }
}

/// Priors and posteriors of groups, as what the fit and the table say of them.
class Calibrator {
 public:
  Calibrator(const FittedModel& fit, SeenGroups seen, Calibration& result)
      : fit_(fit),
        seen_(seen),
        result_(result),
        q_(static_cast<Index>(fit.random_names.size())),
        s_(static_cast<Index>(fit.outer.names.size())),
        p_(fit.estimate.size()),
        inner_root_(covariance_factor(fit.random_covariance)),
        outer_root_(covariance_factor(fit.outer.covariance)) {}

  /// Before any tree of the table.
  void set_priors() {
    const auto groups = static_cast<Index>(result_.group_labels.size());
    const auto clusters = static_cast<Index>(result_.outer_labels.size());
    result_.effects.setZero(q_, groups);
    result_.uncertainty = {.covariances = MatrixXd::Zero(q_ * q_, groups),
                           .sensitivities = MatrixXd::Zero(q_ * p_, groups),
                           .cross_covariances = MatrixXd::Zero(q_ * s_, groups)};
    result_.outer_effects.setZero(s_, clusters);
    result_.outer_uncertainty = {.covariances = MatrixXd::Zero(s_ * s_, clusters),
                                 .sensitivities = MatrixXd::Zero(s_ * p_, clusters)};
    for (Index c = 0; c < clusters; ++c) set_outer_prior(c);
    for (Index g = 0; g < groups; ++g) set_inner_prior(g);
  }

  /// What the trees add.
  void update(const NonlinearModel& model, unsigned threads) {
    EffectPriors priors = unseen_priors(model, fit_);
    if (seen_ != SeenGroups::kNew) fill_priors(model, priors);
    const EffectPosteriors found = find_effects(model, fit_, priors, threads);
    take_over(model, found);
  }

 private:
  /// Whether the fit's own values stand for a group before its trees.
  bool counts_fitted(Index fitted) const { return seen_ != SeenGroups::kNew && fitted >= 0; }

  void set_outer_prior(Index c) {
    const Index of = result_.fitted_outer[static_cast<std::size_t>(c)];
    if (!counts_fitted(of)) {
      result_.outer_uncertainty.covariances.col(c) = fit_.outer.covariance.reshaped();
      return;
    }
    result_.outer_effects.col(c) = fit_.outer.effects.col(of);
    copy(fit_.outer_uncertainty, of, result_.outer_uncertainty, c);
  }

  void set_inner_prior(Index g) {
    const Index of = result_.fitted_group[static_cast<std::size_t>(g)];
    if (!counts_fitted(of)) {
      result_.uncertainty.covariances.col(g) = fit_.random_covariance.reshaped();
      return;
    }
    result_.effects.col(g) = fit_.random_effects.col(of);
    copy(fit_.uncertainty, of, result_.uncertainty, g);
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

  /// The roots of what is known of a group, given those of its coarser group.
  EffectRoots roots_of(Index g, const MatrixXd& outer_root) const {
    EffectRoots roots{
        .outer = outer_root, .coupling = MatrixXd::Zero(q_, s_), .inner = inner_root_};
    if (!counts_fitted(result_.fitted_group[static_cast<std::size_t>(g)])) return roots;
    const MatrixXd covariance = result_.uncertainty.covariance(g, q_);
    if (s_ == 0) {
      roots.inner = covariance_factor(covariance);
      return roots;
    }
    const Index c = result_.outer_of[static_cast<std::size_t>(g)];
    const MatrixXd cross = result_.uncertainty.cross_covariance(g, q_, s_);
    const MatrixXd slopes = regression_on(cross, result_.outer_uncertainty.covariance(c, s_));
    roots.coupling = slopes * outer_root;
    roots.inner = covariance_factor(covariance - slopes * cross.transpose());
    return roots;
  }

  MatrixXd outer_root_of(Index c) const {
    if (s_ == 0) return MatrixXd(0, 0);
    if (!counts_fitted(result_.fitted_outer[static_cast<std::size_t>(c)])) return outer_root_;
    require_outer_covariances();
    return covariance_factor(result_.outer_uncertainty.covariance(c, s_));
  }

  void require_outer_covariances() const {
    if (fit_.outer_uncertainty.is_known()) return;
    throw UsageError(fmt::format(
        "the fit does not store the covariances of the random effects by {}, which new groups "
        "within them need; an older version of silvafit wrote it; fit the model again",
        fit_.specification.outer_random->group));
  }

  void fill_priors(const NonlinearModel& model, EffectPriors& priors) {
    const LabelNumbers inner = numbered(result_.group_labels);
    const LabelNumbers outer = numbered(result_.outer_labels);
    priors.inner_slope.setZero(q_ * p_, model.group_count());
    if (s_ > 0) priors.outer_slope.setZero(s_ * p_, model.cluster_count());
    bool any = false;
    for (Index k = 0; k < model.cluster_count(); ++k) {
      const Index c = s_ > 0 ? outer.at(model.outer_labels()[static_cast<std::size_t>(k)]) : -1;
      const bool is_outer_fitted =
          s_ > 0 && counts_fitted(result_.fitted_outer[static_cast<std::size_t>(c)]);
      const MatrixXd outer_root = outer_root_of(c);
      if (is_outer_fitted) {
        priors.outer_mean.col(k) = result_.outer_effects.col(c);
        priors.outer_slope.col(k) = result_.outer_uncertainty.sensitivities.col(c);
      }
      for (Index m = model.cluster_begin(k); m < model.cluster_begin(k + 1); ++m) {
        const Index g = inner.at(model.group_labels()[static_cast<std::size_t>(m)]);
        const bool is_fitted = counts_fitted(result_.fitted_group[static_cast<std::size_t>(g)]);
        if (!is_fitted && !is_outer_fitted) continue;
        any = true;
        priors.roots_of[static_cast<std::size_t>(m)] = static_cast<Index>(priors.roots.size());
        priors.roots.push_back(roots_of(g, outer_root));
        if (!is_fitted) continue;
        priors.inner_mean.col(m) = result_.effects.col(g);
        priors.inner_slope.col(m) = result_.uncertainty.sensitivities.col(g);
      }
    }
    if (any) return;
    priors.inner_slope.resize(0, 0);
    priors.outer_slope.resize(0, 0);
  }

  void take_over(const NonlinearModel& model, const EffectPosteriors& found) {
    const LabelNumbers inner = numbered(result_.group_labels);
    const LabelNumbers outer = numbered(result_.outer_labels);
    std::vector<Index> found_cluster(result_.outer_labels.size(), -1);
    std::vector<bool> is_found(result_.group_labels.size(), false);
    // Groups without trees follow their coarser group, so that its earlier values are needed.
    const Calibration before = s_ > 0 ? result_ : Calibration{};
    for (Index k = 0; k < model.cluster_count(); ++k) {
      if (s_ > 0) {
        const Index c = outer.at(model.outer_labels()[static_cast<std::size_t>(k)]);
        found_cluster[static_cast<std::size_t>(c)] = k;
        result_.outer_effects.col(c) = found.outer.col(k);
        copy(found.outer_uncertainty, k, result_.outer_uncertainty, c);
      }
      for (Index m = model.cluster_begin(k); m < model.cluster_begin(k + 1); ++m) {
        const Index g = inner.at(model.group_labels()[static_cast<std::size_t>(m)]);
        is_found[static_cast<std::size_t>(g)] = true;
        result_.effects.col(g) = found.inner.col(m);
        copy(found.inner_uncertainty, m, result_.uncertainty, g);
      }
    }
    if (s_ == 0) return;
    for (Index g = 0; g < static_cast<Index>(is_found.size()); ++g) {
      const Index c = result_.outer_of[static_cast<std::size_t>(g)];
      const Index k = found_cluster[static_cast<std::size_t>(c)];
      if (!is_found[static_cast<std::size_t>(g)] && k >= 0) follow(before, found, g, c, k);
    }
  }

  /// A group without trees in a coarser group that has some.
  void follow(const Calibration& before, const EffectPosteriors& found, Index g, Index c, Index k) {
    const bool is_fitted = counts_fitted(before.fitted_group[static_cast<std::size_t>(g)]);
    if (!is_fitted) return;
    const MatrixXd cross = before.uncertainty.cross_covariance(g, q_, s_);
    const MatrixXd old_outer = before.outer_uncertainty.covariance(c, s_);
    const MatrixXd slopes = regression_on(cross, old_outer);
    result_.effects.col(g) += slopes * (found.outer.col(k) - before.outer_effects.col(c));
    const MatrixXd outer = found.outer_uncertainty.covariance(k, s_);
    result_.uncertainty.covariances.col(g) =
        (before.uncertainty.covariance(g, q_) + slopes * (outer - old_outer) * slopes.transpose())
            .reshaped();
    result_.uncertainty.cross_covariances.col(g) = (slopes * outer).reshaped();
    result_.uncertainty.sensitivities.col(g) +=
        (slopes * (found.outer_uncertainty.sensitivity(k, s_, p_) -
                   before.outer_uncertainty.sensitivity(c, s_, p_)))
            .reshaped();
  }

  const FittedModel& fit_;
  SeenGroups seen_;
  Calibration& result_;
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
  calibrator.update(NonlinearModel(fit.specification, table.select(rows)), options.threads);
  return result;
}

}  // namespace silvafit::fit
