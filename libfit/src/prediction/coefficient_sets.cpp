// SPDX-License-Identifier: MIT
#include "prediction/coefficient_sets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "model/group_labels.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::fit {
namespace {

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
    result.known.assign(static_cast<std::size_t>(sets), 0);
    result.is_marginal.assign(static_cast<std::size_t>(sets), false);
    identity_ = MatrixXd::Identity(p, p);
  }

  /// A set with the effects of groups.
  /// \param groups  of the last estimated term and those that it is in, in this order
  void set(Index set, const std::vector<KnownEffects>& groups) {
    result_.known[static_cast<std::size_t>(set)] = groups.front().term + 1;
    const Index p = fit_.estimate.size();
    MatrixXd follow = identity_;
    MatrixXd covariance = MatrixXd::Zero(p, p);
    for (const KnownEffects& of : groups) {
      const MatrixXd& place = places_[of.term];
      result_.coefficients.col(set) += place * of.effects.col(of.group);
      if (!with_covariances_) continue;
      const Index q = of.effects.rows();
      follow += place * of.uncertainty.sensitivity(of.group, q, p);
      covariance += place * of.uncertainty.covariance(of.group, q) * place.transpose();
      if (of.term == 0 || groups.size() < 2) continue;
      const MatrixXd& before = places_[of.term - 1];
      const MatrixXd cross =
          place * of.uncertainty.cross_covariance(of.group, q, before.cols()) * before.transpose();
      covariance += cross + cross.transpose();
    }
    if (!with_covariances_) return;
    result_.covariances.col(set) = (follow * fixed_ * follow.transpose() + covariance).reshaped();
  }

 private:
  const FittedModel& fit_;
  bool with_covariances_;
  CoefficientSets& result_;
  std::vector<MatrixXd> places_;  ///< (p x q) of each term
  MatrixXd fixed_;
  MatrixXd identity_;
};

void require_uncertainty(const FittedModel& fit) {
  if (fit.random.back().uncertainty.is_known()) return;
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
      : KnownGroups(fit), calibration_(calibration), terms_(calibration.random), seen_(seen) {
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      for (const Index fitted : terms_[t].fitted_group) {
        is_known_[t].push_back(seen != SeenGroups::kNew && fitted >= 0);
      }
    }
    const CalibratedEffects& last = terms_.back();
    for (std::size_t g = 0; g < last.labels.size(); ++g) {
      if (calibration.measured[g] == 0) continue;
      is_known_.back()[g] = true;
      const Index before = last.coarser_group[g];
      if (before >= 0) is_known_[terms_.size() - 2][static_cast<std::size_t>(before)] = true;
    }
  }

  void of_row(std::size_t row, std::vector<Index>& groups) const override {
    groups.assign(terms_.size(), -1);
    std::size_t t = terms_.size();
    Index group = -1;
    while (group < 0 && t-- > 0) {
      const Index own = terms_[t].group_of_row[row];
      if (own >= 0 && is_known_[t][static_cast<std::size_t>(own)]) group = own;
    }
    for (; group >= 0; --t) {
      groups[t] = group;
      group = terms_[t].coarser_group[static_cast<std::size_t>(group)];
    }
  }

  std::vector<KnownEffects> effects(const std::vector<Index>& groups) const override {
    // A known group without further trees keeps the fit's effects of all terms.
    const bool is_kept = groups.back() >= 0 && keeps_fitted(groups.back());
    std::vector<Index> fitted;
    std::vector<KnownEffects> result;
    for (std::size_t t = groups.size(); t-- > 0;) {
      const CalibratedEffects& of = terms_[t];
      if (groups[t] >= 0) result.push_back({t, of.effects, of.uncertainty, groups[t]});
      fitted.insert(fitted.begin(),
                    groups[t] < 0 ? -1 : of.fitted_group[static_cast<std::size_t>(groups[t])]);
    }
    return is_kept ? KnownGroups::effects(fitted) : result;
  }

  /// As Prediction::calibrated_from.
  Index measured(Index group) const {
    if (group < 0) return 0;
    return keeps_fitted(group) ? -1 : calibration_.measured[static_cast<std::size_t>(group)];
  }

 private:
  /// Whether a group keeps the effects of the fit, without those of its further trees.
  bool keeps_fitted(Index group) const {
    return seen_ == SeenGroups::kFitted &&
           terms_.back().fitted_group[static_cast<std::size_t>(group)] >= 0;
  }

  const Calibration& calibration_;
  const std::vector<CalibratedEffects>& terms_;
  SeenGroups seen_;
  std::vector<std::vector<bool>> is_known_{terms_.size()};  ///< by group of each term
};

/// The first crossed term, or the last of nested ones, in which the group is unknown; none if the
/// effects of all terms are known.
std::optional<std::size_t> unknown_term(const FittedModel& fit, const std::vector<Index>& groups) {
  const std::size_t last = groups.size() - 1;
  if (!are_crossed(fit.specification.random)) {
    return groups.back() < 0 ? std::optional(last) : std::nullopt;
  }
  const auto unknown = static_cast<std::size_t>(std::ranges::find(groups, -1) - groups.begin());
  return unknown <= last ? std::optional(unknown) : std::nullopt;
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
  for (std::size_t k = 0; k < groups_of_set.size(); ++k) {
    const std::vector<KnownEffects> effects = known.effects(groups_of_set[k]);
    if (!effects.empty()) builder.set(static_cast<Index>(k), effects);
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
    const std::optional<std::size_t> term = unknown_term(fit, groups);
    if (!term) continue;
    if (choice == NewGroups::kMarginal && are_crossed(fit.specification.random) &&
        std::ranges::count(groups, -1) < std::ssize(groups)) {
      throw UsageError(
          "the mean over new groups is not available where the fit has groups of other crossed "
          "terms; choose `new_groups` population, missing or error");
    }
    if (choice == NewGroups::kError) {
      const std::string& column = fit.specification.random[*term].group;
      refuse_group(table, row, column, labels.of(*term, row), is_calibrated);
    }
    result.is_new_group[row] = true;
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
  if (with_covariances && !is_calibrated && are_crossed(fit.specification.random)) {
    throw UsageError(
        "standard errors and intervals of predictions with crossed random effects, or with more "
        "than two levels of groups, are available with `level` population only");
  }
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
          known.measured(groups_of_set[static_cast<std::size_t>(set)].back()));
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

MatrixXd open_covariance(const FittedModel& fit, std::size_t known) {
  const Index p = fit.estimate.size();
  MatrixXd result = MatrixXd::Zero(p, p);
  for (std::size_t t = fit.random.size(); t-- > known;) {
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
  result.is_new_group.assign(table.rows(), false);
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
