// SPDX-License-Identifier: MIT
#include "prediction/coefficient_sets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "model/group_labels.hpp"
#include "prediction/joint_posterior.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/checked_columns.hpp"

namespace silvafit::fit {
namespace {

[[noreturn]] void refuse_group(const data::Table& table,
                               std::size_t row,
                               const std::string& column,
                               std::string_view label,
                               bool is_calibrated) {
  const Place place = data::place_of(table, row, column);
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

/// The estimated effects of a group of a term.
struct KnownEffects {
  std::size_t term = 0;
  const MatrixXd& effects;
  const EffectUncertainty& uncertainty;
  Index group = 0;
};

/// Builds sets from estimated effects.
class SetBuilder {
 public:
  SetBuilder(const FittedModel& fit, Index sets, bool with_covariances, CoefficientSets& result)
      : fit_(fit),
        with_covariances_(with_covariances),
        result_(result),
        fixed_(fixed_covariance(fit)) {
    for (const EstimatedEffects& term : fit.random) places_.push_back(placement(fit, term.names));
    const Index p = fit.estimate.size();
    result.coefficients = fit.estimate.replicate(1, sets);
    if (with_covariances) result.covariances = fixed_.reshaped().replicate(1, sets);
    result.known.assign(static_cast<std::size_t>(sets), std::vector<bool>(fit.random.size()));
    result.is_marginal.assign(static_cast<std::size_t>(sets), false);
    identity_ = MatrixXd::Identity(p, p);
  }

  /// A set with the effects of groups.
  /// \param between  (Q x Q) covariances between the terms, or null with a single one
  void set(Index set, const std::vector<KnownEffects>& groups, const MatrixXd* between) {
    const Index p = fit_.estimate.size();
    MatrixXd follow = identity_;
    MatrixXd covariance = MatrixXd::Zero(p, p);
    for (const KnownEffects& of : groups) {
      const MatrixXd& place = places_[of.term];
      result_.known[static_cast<std::size_t>(set)][of.term] = true;
      result_.coefficients.col(set) += place * of.effects.col(of.group);
      if (!with_covariances_) continue;
      const Index q = of.effects.rows();
      follow += place * of.uncertainty.sensitivity(of.group, q, p);
      covariance += place * of.uncertainty.covariance(of.group, q) * place.transpose();
    }
    if (!with_covariances_) return;
    if (between != nullptr) {
      const MatrixXd places = joined_columns();
      covariance += places * *between * places.transpose();
    }
    result_.covariances.col(set) = (follow * fixed_ * follow.transpose() + covariance).reshaped();
  }

 private:
  /// (p x Q)
  MatrixXd joined_columns() const {
    MatrixXd result(fit_.estimate.size(), 0);
    for (const MatrixXd& place : places_) {
      result.conservativeResize(Eigen::NoChange, result.cols() + place.cols());
      result.rightCols(place.cols()) = place;
    }
    return result;
  }

  const FittedModel& fit_;
  bool with_covariances_;
  CoefficientSets& result_;
  std::vector<MatrixXd> places_;  ///< (p x q) of each term
  MatrixXd fixed_;
  MatrixXd identity_;
};

void require_uncertainty(const FittedModel& fit) {
  if (fit.knows_uncertainty()) return;
  throw UsageError(
      "the fit does not store the covariances of its random effects, which conditional intervals "
      "need; an older version of silvafit wrote it; fit the model again");
}

/// The groups whose effects are estimated.
class KnownGroups {
 public:
  explicit KnownGroups(const FittedModel& fit) : fit_(fit) {}
  virtual ~KnownGroups() = default;
  KnownGroups(const KnownGroups&) = delete;
  KnownGroups& operator=(const KnownGroups&) = delete;

  /// Sets the group of a row in each term, -1 where it is unknown.
  virtual void of_row(std::size_t row, std::vector<Index>& groups) const = 0;
  /// The effects of groups by term, those of the last term first.
  virtual std::vector<KnownEffects> effects(const std::vector<Index>& groups) const {
    std::vector<KnownEffects> result;
    for (std::size_t t = groups.size(); t-- > 0;) {
      if (groups[t] < 0) continue;
      const EstimatedEffects& of = fit_.random[t];
      result.push_back({t, of.effects, of.uncertainty, groups[t]});
    }
    return result;
  }
  /// See JointPosterior.
  virtual std::vector<MatrixXd> between_terms(const std::vector<std::vector<Index>>& sets) const {
    std::vector<std::vector<std::string>> labels;
    for (const EstimatedEffects& term : fit_.random) labels.push_back(term.labels);
    return JointPosterior(fit_, fit_.cells, std::move(labels)).between_terms(sets);
  }

 protected:
  const FittedModel& fit() const { return fit_; }

 private:
  const FittedModel& fit_;
};

/// Those of the fit.
class FittedGroups : public KnownGroups {
 public:
  FittedGroups(const FittedModel& fit, const GroupLabels& labels)
      : KnownGroups(fit), labels_(labels) {
    for (const EstimatedEffects& term : fit.random) numbers_.push_back(numbered(term.labels));
  }

  void of_row(std::size_t row, std::vector<Index>& groups) const override {
    groups.clear();
    for (std::size_t t = 0; t < numbers_.size(); ++t) {
      const auto found = numbers_[t].find(labels_.of(t, row));
      groups.push_back(found == numbers_[t].end() ? -1 : found->second);
    }
  }

 private:
  const GroupLabels& labels_;
  std::vector<LabelNumbers> numbers_;
};

/// Those with trees in the table or, if these are used, in the fit.
class CalibratedGroups : public KnownGroups {
 public:
  CalibratedGroups(const FittedModel& fit, const Calibration& calibration, SeenGroups seen)
      : KnownGroups(fit), calibration_(calibration), terms_(calibration.random), seen_(seen) {}

  void of_row(std::size_t row, std::vector<Index>& groups) const override {
    groups.clear();
    for (const CalibratedEffects& term : terms_) {
      const Index own = term.group_of_row[row];
      const bool is_known = own >= 0 && (counts_fitted(term, own) || measured(term, own) > 0);
      groups.push_back(is_known ? own : -1);
    }
  }

  std::vector<KnownEffects> effects(const std::vector<Index>& groups) const override {
    if (keeps_fitted(groups)) return KnownGroups::effects(fitted(groups));
    std::vector<KnownEffects> result;
    for (std::size_t t = groups.size(); t-- > 0;) {
      const CalibratedEffects& of = terms_[t];
      if (groups[t] >= 0) result.push_back({t, of.effects, of.uncertainty, groups[t]});
    }
    return result;
  }

  std::vector<MatrixXd> between_terms(const std::vector<std::vector<Index>>& sets) const override {
    // Those of the fit, and those with the trees of the table.
    std::vector<std::vector<Index>> kept;
    std::vector<std::vector<Index>> updated;
    for (const std::vector<Index>& groups : sets) {
      if (keeps_fitted(groups)) {
        kept.push_back(fitted(groups));
      } else {
        updated.push_back(groups);
      }
    }
    std::vector<MatrixXd> of_kept;
    std::vector<MatrixXd> of_updated;
    if (!kept.empty()) of_kept = KnownGroups::between_terms(kept);
    if (!updated.empty()) {
      std::vector<std::vector<std::string>> labels;
      for (const CalibratedEffects& term : terms_) labels.push_back(term.labels);
      of_updated =
          JointPosterior(fit(), calibration_.cells, std::move(labels)).between_terms(updated);
    }
    std::vector<MatrixXd> result;
    auto next_kept = of_kept.begin();
    auto next_updated = of_updated.begin();
    for (const std::vector<Index>& groups : sets) {
      result.push_back(std::move(keeps_fitted(groups) ? *next_kept++ : *next_updated++));
    }
    return result;
  }

  /// As Prediction::calibrated_from.
  Index calibrated_from(const std::vector<Index>& groups) const {
    if (keeps_fitted(groups)) return -1;
    if (std::ranges::count(groups, -1) > 0) return 0;
    std::vector<Index> of_new;
    std::vector<Index> of_all;
    for (std::size_t t = 0; t < groups.size(); ++t) {
      of_all.push_back(measured(terms_[t], groups[t]));
      if (!counts_fitted(terms_[t], groups[t])) of_new.push_back(of_all.back());
    }
    return std::ranges::min(of_new.empty() ? of_all : of_new);
  }

 private:
  static Index measured(const CalibratedEffects& term, Index group) {
    return term.measured[static_cast<std::size_t>(group)];
  }
  bool counts_fitted(const CalibratedEffects& term, Index group) const {
    return seen_ != SeenGroups::kNew && term.fitted_group[static_cast<std::size_t>(group)] >= 0;
  }
  std::vector<Index> fitted(const std::vector<Index>& groups) const {
    std::vector<Index> result;
    for (std::size_t t = 0; t < groups.size(); ++t) {
      result.push_back(terms_[t].fitted_group[static_cast<std::size_t>(groups[t])]);
    }
    return result;
  }
  /// Whether groups keep the effects of the fit in all terms, without those of further trees.
  bool keeps_fitted(const std::vector<Index>& groups) const {
    return seen_ == SeenGroups::kFitted && std::ranges::count(groups, -1) == 0 &&
           std::ranges::count(fitted(groups), -1) == 0;
  }

  const Calibration& calibration_;
  const std::vector<CalibratedEffects>& terms_;
  SeenGroups seen_;
};

/// The crossed terms, or the last of nested ones, in which the group is unknown: bits of their
/// numbers.
unsigned unknown_terms(const FittedModel& fit, const std::vector<Index>& groups) {
  const std::size_t first = are_crossed(fit.specification.random) ? 0 : groups.size() - 1;
  unsigned result = 0;
  for (std::size_t t = first; t < groups.size(); ++t) {
    if (groups[t] < 0) result |= 1U << t;
  }
  return result;
}

/// Sets of the combinations of groups in the rows of a table.
/// \returns (sets) the groups of each
std::vector<std::vector<Index>> add_sets(const FittedModel& fit,
                                         const KnownGroups& known,
                                         std::size_t rows,
                                         bool with_covariances,
                                         CoefficientSets& result) {
  std::map<std::vector<Index>, Index> sets;
  std::vector<std::vector<Index>> groups_of_set;
  std::vector<Index> groups;
  Index set = -1;
  for (std::size_t row = 0; row < rows; ++row) {
    known.of_row(row, groups);
    // Rows of a group mostly stand together.
    if (set < 0 || groups != groups_of_set[static_cast<std::size_t>(set)]) {
      const auto [place, is_new] = sets.emplace(groups, std::ssize(groups_of_set));
      if (is_new) groups_of_set.push_back(groups);
      set = place->second;
    }
    result.set_of_row[row] = set;
  }
  SetBuilder builder(fit, std::ssize(groups_of_set), with_covariances, result);
  std::vector<MatrixXd> between;
  if (with_covariances && fit.random.size() > 1) {
    between = known.between_terms(groups_of_set);
  }
  for (std::size_t k = 0; k < groups_of_set.size(); ++k) {
    const std::vector<KnownEffects> effects = known.effects(groups_of_set[k]);
    if (effects.empty()) continue;
    builder.set(static_cast<Index>(k), effects, between.empty() ? nullptr : &between[k]);
  }
  return groups_of_set;
}

/// Marks the rows with unknown groups.
void mark_new(const FittedModel& fit,
              const data::Table& table,
              const GroupLabels& labels,
              const std::vector<std::vector<Index>>& groups_of_set,
              NewGroups choice,
              bool is_calibrated,
              CoefficientSets& result) {
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const auto set = static_cast<std::size_t>(result.set_of_row[row]);
    const std::vector<Index>& groups = groups_of_set[set];
    result.unknown_terms[row] = unknown_terms(fit, groups);
    if (result.unknown_terms[row] == 0) continue;
    if (choice == NewGroups::kError) {
      const auto term = static_cast<std::size_t>(std::countr_zero(result.unknown_terms[row]));
      const std::string& column = fit.specification.random[term].group;
      refuse_group(table, row, column, labels.of(term, row), is_calibrated);
    }
    result.is_missing[row] = choice == NewGroups::kMissing;
    result.is_marginal[set] = choice == NewGroups::kMarginal;
  }
}

/// Sets of the groups of the fit, or of the table.
void add_groups(const FittedModel& fit,
                const data::Table& table,
                bool is_calibrated,
                const PredictionOptions& options,
                bool with_covariances,
                CoefficientSets& result) {
  const bool uses_fit = !is_calibrated || options.seen_groups != SeenGroups::kNew;
  if (with_covariances && uses_fit) require_uncertainty(fit);
  const GroupLabels labels(fit.specification, table);
  std::vector<std::vector<Index>> groups_of_set;
  if (is_calibrated) {
    const Calibration calibration =
        calibrate(fit, table, {.seen_groups = options.seen_groups, .threads = options.threads});
    const CalibratedGroups known(fit, calibration, options.seen_groups);
    groups_of_set = add_sets(fit, known, table.rows(), with_covariances, result);
    for (const Index set : result.set_of_row) {
      result.calibrated_from.push_back(
          known.calibrated_from(groups_of_set[static_cast<std::size_t>(set)]));
    }
  } else {
    const FittedGroups known(fit, labels);
    groups_of_set = add_sets(fit, known, table.rows(), with_covariances, result);
  }
  mark_new(fit, table, labels, groups_of_set, options.new_groups, is_calibrated, result);
}

}  // namespace

MatrixXd among_coefficients(const FittedModel& fit,
                            const std::vector<std::string>& names,
                            const MatrixXd& covariance) {
  const MatrixXd places = placement(fit, names);
  return places * covariance * places.transpose();
}

MatrixXd open_covariance(const FittedModel& fit, const std::vector<bool>& known) {
  const Index p = fit.estimate.size();
  MatrixXd result = MatrixXd::Zero(p, p);
  for (std::size_t t = fit.random.size(); t-- > 0;) {
    if (known[t]) continue;
    result += among_coefficients(fit, fit.random[t].names, fit.random[t].covariance);
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
  result.unknown_terms.assign(table.rows(), 0);
  result.is_missing.assign(table.rows(), false);
  if (!fit.has_random_effects() || level == Level::kPopulation || level == Level::kMarginal) {
    const SetBuilder builder(fit, 1, with_covariances, result);
    result.is_marginal[0] = level == Level::kMarginal && fit.has_random_effects();
  } else {
    const bool is_calibrated = level == Level::kCalibrated;
    add_groups(fit, table, is_calibrated, options, with_covariances, result);
  }
  return result;
}

}  // namespace silvafit::fit
