// SPDX-License-Identifier: MIT
#include "prediction/coefficient_sets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "model/group_labels.hpp"
#include "model/nested_terms.hpp"
#include "result/nested_effects.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Open = CoefficientSets::Open;

[[noreturn]] void refuse_group(const data::Table& table,
                               std::size_t row,
                               const std::string& column,
                               std::string_view label,
                               bool is_calibrated) {
  Place place{.file = table.file(), .column = column};
  if (table.line(row) > 0) place.line = table.line(row);
  if (label.empty()) throw InputError("the group is missing", place);
  throw InputError(fmt::format("unknown group '{}': it is not in the fit{}",
                               label,
                               is_calibrated ? " and has no measured tree" : ""),
                   place);
}

/// (p x names) the coefficients to which effects are added.
MatrixXd placement(const FittedModel& fit, const std::vector<std::string>& names) {
  MatrixXd result = MatrixXd::Zero(fit.estimate.size(), static_cast<Index>(names.size()));
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto found = std::ranges::find(fit.coefficient_names, names[k]);
    result(found - fit.coefficient_names.begin(), static_cast<Index>(k)) = 1.0;
  }
  return result;
}

/// Builds sets from estimated effects.
class SetBuilder {
 public:
  SetBuilder(const FittedModel& fit, Index sets, bool with_covariances, CoefficientSets& result)
      : fit_(fit),
        with_covariances_(with_covariances),
        result_(result),
        inner_(placement(fit, finer(fit).names)),
        outer_(placement(fit, coarser(fit).names)),
        fixed_(fixed_covariance(fit)) {
    const Index p = fit.estimate.size();
    result.coefficients = fit.estimate.replicate(1, sets);
    if (with_covariances) result.covariances = fixed_.reshaped().replicate(1, sets);
    result.open.assign(static_cast<std::size_t>(sets), Open::kAll);
    result.is_marginal.assign(static_cast<std::size_t>(sets), false);
    identity_ = MatrixXd::Identity(p, p);
  }

  /// A set with the effects of a coarser group.
  void set_outer(Index set, const VectorXd& effects, const EffectUncertainty& of, Index k) {
    result_.coefficients.col(set) += outer_ * effects;
    result_.open[static_cast<std::size_t>(set)] = Open::kInner;
    if (!with_covariances_) return;
    const Index s = effects.size();
    add(set, outer_ * of.sensitivity(k, s, p()), outer_ * of.covariance(k, s) * outer_.transpose());
  }

  /// A set with the effects of a group, and of its coarser group, if any.
  void set_inner(Index set,
                 const VectorXd& effects,
                 const EffectUncertainty& of,
                 Index g,
                 const VectorXd& outer_effects,
                 const EffectUncertainty& outer_of,
                 Index c) {
    result_.coefficients.col(set) += inner_ * effects;
    const Index s = outer_effects.size();
    if (s > 0) result_.coefficients.col(set) += outer_ * outer_effects;
    result_.open[static_cast<std::size_t>(set)] = Open::kNothing;
    if (!with_covariances_) return;
    const Index q = effects.size();
    MatrixXd slope = inner_ * of.sensitivity(g, q, p());
    MatrixXd covariance = inner_ * of.covariance(g, q) * inner_.transpose();
    if (s > 0) {
      slope += outer_ * outer_of.sensitivity(c, s, p());
      const MatrixXd cross = inner_ * of.cross_covariance(g, q, s) * outer_.transpose();
      covariance +=
          cross + cross.transpose() + outer_ * outer_of.covariance(c, s) * outer_.transpose();
    }
    add(set, slope, covariance);
  }

 private:
  Index p() const { return fit_.estimate.size(); }
  void add(Index set, const MatrixXd& slope, const MatrixXd& covariance) {
    const MatrixXd follow = identity_ + slope;
    result_.covariances.col(set) = (follow * fixed_ * follow.transpose() + covariance).reshaped();
  }

  const FittedModel& fit_;
  bool with_covariances_;
  CoefficientSets& result_;
  MatrixXd inner_;
  MatrixXd outer_;
  MatrixXd fixed_;
  MatrixXd identity_;
};

void require_uncertainty(const FittedModel& fit) {
  if (finer(fit).uncertainty.is_known()) return;
  throw UsageError(
      "the fit does not store the covariances of its random effects, which conditional intervals "
      "need; an older version of silvafit wrote it; fit the model again");
}

/// The set for rows of unknown groups.
class NewGroupRows {
 public:
  NewGroupRows(const FittedModel& fit,
               const data::Table& table,
               NewGroups choice,
               bool is_calibrated,
               CoefficientSets& result)
      : fit_(fit), table_(table), choice_(choice), is_calibrated_(is_calibrated), result_(result) {}

  void mark(std::size_t row, std::string_view label, Index set) {
    if (choice_ == NewGroups::kError) {
      refuse_group(table_, row, finer_term(fit_.specification)->group, label, is_calibrated_);
    }
    result_.is_new_group[row] = true;
    result_.is_missing[row] = choice_ == NewGroups::kMissing;
    result_.set_of_row[row] = set;
    result_.is_marginal[static_cast<std::size_t>(set)] = choice_ == NewGroups::kMarginal;
  }

 private:
  const FittedModel& fit_;
  const data::Table& table_;
  NewGroups choice_;
  bool is_calibrated_;
  CoefficientSets& result_;
};

/// Number of each group's coarser group in the fit, -1 without.
std::vector<Index> outer_numbers(const FittedModel& fit) {
  std::vector<Index> result(finer(fit).labels.size(), -1);
  const LabelNumbers outer = numbered(outer_parts(coarser(fit).labels));
  for (std::size_t g = 0; g < result.size() && !outer.empty(); ++g) {
    const auto found = outer.find(std::string(nested_parts(finer(fit).labels[g]).outer));
    if (found != outer.end()) result[g] = found->second;
  }
  return result;
}

/// Sets: groups of the fit, its coarser groups, the population.
void add_conditional(const FittedModel& fit,
                     const data::Table& table,
                     const PredictionOptions& options,
                     bool with_covariances,
                     CoefficientSets& result) {
  if (with_covariances) require_uncertainty(fit);
  const auto groups = static_cast<Index>(finer(fit).labels.size());
  const auto clusters = static_cast<Index>(coarser(fit).labels.size());
  SetBuilder builder(fit, groups + clusters + 1, with_covariances, result);
  const std::vector<Index> outer_of = outer_numbers(fit);
  for (Index g = 0; g < groups; ++g) {
    const Index c = outer_of[static_cast<std::size_t>(g)];
    builder.set_inner(g,
                      finer(fit).effects.col(g),
                      finer(fit).uncertainty,
                      g,
                      c < 0 ? VectorXd() : VectorXd(coarser(fit).effects.col(c)),
                      coarser(fit).uncertainty,
                      c);
  }
  for (Index c = 0; c < clusters; ++c) {
    builder.set_outer(groups + c, coarser(fit).effects.col(c), coarser(fit).uncertainty, c);
  }
  const LabelNumbers inner = numbered(finer(fit).labels);
  const LabelNumbers outer = numbered(coarser(fit).labels);
  const GroupLabels labels(fit.specification, table);
  NewGroupRows new_rows(fit, table, options.new_groups, false, result);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string label = labels.inner(row);
    const auto found = inner.find(label);
    if (!label.empty() && found != inner.end()) {
      result.set_of_row[row] = found->second;
      continue;
    }
    const auto coarser = outer.find(labels.outer(row));
    new_rows.mark(row, label, groups + (coarser == outer.end() ? clusters : coarser->second));
  }
}

/// Sets: groups of the table, its coarser groups, the population.
class CalibratedSets {
 public:
  CalibratedSets(const FittedModel& fit,
                 const data::Table& table,
                 const PredictionOptions& options,
                 bool with_covariances,
                 CoefficientSets& result)
      : fit_(fit),
        seen_(options.seen_groups),
        result_(result),
        calibration_(calibrate(
            fit, table, {.seen_groups = options.seen_groups, .threads = options.threads})),
        inner_(calibration_.random.back()),
        outer_(calibration_.random.size() > 1 ? calibration_.random.front() : none_),
        groups_(static_cast<Index>(inner_.labels.size())),
        clusters_(static_cast<Index>(outer_.labels.size())),
        builder_(fit, groups_ + clusters_ + 1, with_covariances, result),
        new_rows_(fit, table, options.new_groups, true, result) {}

  void add() {
    find_known();
    for (Index g = 0; g < groups_; ++g) {
      if (is_known_[static_cast<std::size_t>(g)]) set_group(g);
    }
    for (Index c = 0; c < clusters_; ++c) {
      if (!is_outer_known_[static_cast<std::size_t>(c)]) continue;
      builder_.set_outer(groups_ + c, outer_.effects.col(c), outer_.uncertainty, c);
    }
    result_.calibrated_from.assign(inner_.group_of_row.size(), 0);
    for (std::size_t row = 0; row < inner_.group_of_row.size(); ++row) set_row(row);
  }

 private:
  /// The groups with trees in the table or, if these are used, in the fit.
  void find_known() {
    const bool counts_fitted = seen_ != SeenGroups::kNew;
    is_outer_known_.assign(outer_.labels.size(), false);
    for (std::size_t c = 0; c < is_outer_known_.size(); ++c) {
      is_outer_known_[c] = counts_fitted && outer_.fitted_group[c] >= 0;
    }
    is_known_.assign(inner_.labels.size(), false);
    for (std::size_t g = 0; g < is_known_.size(); ++g) {
      is_known_[g] = calibration_.measured[g] > 0 || (counts_fitted && inner_.fitted_group[g] >= 0);
      const Index c = inner_.coarser_group[g];
      if (c >= 0 && calibration_.measured[g] > 0) {
        is_outer_known_[static_cast<std::size_t>(c)] = true;
      }
    }
  }

  /// Whether a group keeps the effects of the fit, without those of its further trees.
  bool keeps_fitted(Index g) const {
    return seen_ == SeenGroups::kFitted && inner_.fitted_group[static_cast<std::size_t>(g)] >= 0;
  }

  void set_group(Index g) {
    const Index c = inner_.coarser_group[static_cast<std::size_t>(g)];
    if (!keeps_fitted(g)) {
      builder_.set_inner(g,
                         inner_.effects.col(g),
                         inner_.uncertainty,
                         g,
                         c < 0 ? VectorXd() : VectorXd(outer_.effects.col(c)),
                         outer_.uncertainty,
                         c);
      return;
    }
    // A known group without further trees keeps the fit's effects of its coarser group, too.
    const Index k = inner_.fitted_group[static_cast<std::size_t>(g)];
    const Index fitted_c = c < 0 ? -1 : outer_.fitted_group[static_cast<std::size_t>(c)];
    builder_.set_inner(g,
                       finer(fit_).effects.col(k),
                       finer(fit_).uncertainty,
                       k,
                       c < 0 ? VectorXd() : VectorXd(coarser(fit_).effects.col(fitted_c)),
                       coarser(fit_).uncertainty,
                       fitted_c);
  }

  void set_row(std::size_t row) {
    const Index g = inner_.group_of_row[row];
    if (g >= 0 && is_known_[static_cast<std::size_t>(g)]) {
      result_.set_of_row[row] = g;
      result_.calibrated_from[row] =
          keeps_fitted(g) ? -1 : calibration_.measured[static_cast<std::size_t>(g)];
      return;
    }
    const Index c = outer_.group_of_row.empty() ? -1 : outer_.group_of_row[row];
    const bool has_outer = c >= 0 && is_outer_known_[static_cast<std::size_t>(c)];
    const std::string label = g < 0 ? std::string() : inner_.labels[static_cast<std::size_t>(g)];
    new_rows_.mark(row, label, groups_ + (has_outer ? c : clusters_));
  }

  const FittedModel& fit_;
  SeenGroups seen_;
  CoefficientSets& result_;
  Calibration calibration_;
  CalibratedEffects none_{};  ///< of the coarser grouping, where there is none
  const CalibratedEffects& inner_;
  const CalibratedEffects& outer_;
  Index groups_;
  Index clusters_;
  SetBuilder builder_;
  NewGroupRows new_rows_;
  std::vector<bool> is_known_;
  std::vector<bool> is_outer_known_;  ///< by coarser group
};

void add_calibrated(const FittedModel& fit,
                    const data::Table& table,
                    const PredictionOptions& options,
                    bool with_covariances,
                    CoefficientSets& result) {
  if (with_covariances && options.seen_groups != SeenGroups::kNew) require_uncertainty(fit);
  CalibratedSets(fit, table, options, with_covariances, result).add();
}

}  // namespace

MatrixXd fixed_covariance(const FittedModel& fit) {
  const Index p = fit.estimate.size();
  MatrixXd result = fit.covariance.rows() == p ? fit.covariance : MatrixXd::Zero(p, p);
  for (Index j = 0; j < p; ++j) {
    const bool is_estimated =
        j < fit.degrees_of_freedom.size() && std::isfinite(fit.degrees_of_freedom[j]);
    if (is_estimated || !std::isnan(result(j, j))) continue;
    result.row(j).setZero();
    result.col(j).setZero();
  }
  return result;
}

MatrixXd among_coefficients(const FittedModel& fit,
                            const std::vector<std::string>& names,
                            const MatrixXd& covariance) {
  const MatrixXd places = placement(fit, names);
  return places * covariance * places.transpose();
}

MatrixXd open_covariance(const FittedModel& fit, CoefficientSets::Open open) {
  const Index p = fit.estimate.size();
  MatrixXd result = MatrixXd::Zero(p, p);
  if (open == Open::kNothing || !fit.has_random_effects()) return result;
  result += among_coefficients(fit, finer(fit).names, finer(fit).covariance);
  if (open == Open::kAll && !coarser(fit).names.empty()) {
    result += among_coefficients(fit, coarser(fit).names, coarser(fit).covariance);
  }
  return result;
}

CoefficientSets coefficient_sets(const FittedModel& fit,
                                 const data::Table& table,
                                 Level level,
                                 const PredictionOptions& options,
                                 bool with_covariances) {
  CoefficientSets result;
  result.set_of_row.assign(table.rows(), 0);
  result.is_new_group.assign(table.rows(), false);
  result.is_missing.assign(table.rows(), false);
  if (!fit.has_random_effects() || level == Level::kPopulation || level == Level::kMarginal) {
    const SetBuilder builder(fit, 1, with_covariances, result);
    result.is_marginal[0] = level == Level::kMarginal && fit.has_random_effects();
  } else if (level == Level::kConditional) {
    add_conditional(fit, table, options, with_covariances, result);
  } else {
    add_calibrated(fit, table, options, with_covariances, result);
  }
  return result;
}

}  // namespace silvafit::fit
