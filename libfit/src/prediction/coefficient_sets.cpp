// SPDX-License-Identifier: MIT
#include "prediction/coefficient_sets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>
#include <string_view>

#include "model/group_labels.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

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

/// First set of each term, the last term's first; then that of the population.
class SetNumbers {
 public:
  /// \param counts  groups of each term
  explicit SetNumbers(const std::vector<Index>& counts) : begins_(counts.size()) {
    for (std::size_t t = counts.size(); t-- > 0;) {
      begins_[t] = population_;
      population_ += counts[t];
    }
  }
  Index of(std::size_t term, Index group) const { return begins_[term] + group; }
  Index population() const { return population_; }
  Index count() const { return population_ + 1; }

 private:
  std::vector<Index> begins_;
  Index population_ = 0;
};

void require_uncertainty(const FittedModel& fit) {
  if (fit.random.back().uncertainty.is_known()) return;
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
    mark(row, fit_.specification.random.back().group, label, set);
  }
  void mark(std::size_t row, const std::string& column, std::string_view label, Index set) {
    if (choice_ == NewGroups::kError) refuse_group(table_, row, column, label, is_calibrated_);
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

/// Numbers in the fit of the groups that a group is in, by the labels of nested groups.
class FittedGroups {
 public:
  explicit FittedGroups(const FittedModel& fit) : fit_(fit) {
    if (fit.random.size() == 2) clusters_ = numbered(outer_parts(fit.random.front().labels));
  }

  /// The group of a term, and the one of the term before that it is in, if the fit has it.
  std::vector<KnownEffects> with(std::size_t term, Index group) const {
    std::vector<KnownEffects> result{known(term, group)};
    if (term == 0) return result;
    const std::string& label = fit_.random[term].labels[static_cast<std::size_t>(group)];
    const auto found = clusters_.find(std::string(nested_parts(label).outer));
    if (found != clusters_.end()) result.push_back(known(term - 1, found->second));
    return result;
  }

  KnownEffects known(std::size_t term, Index group) const {
    const EstimatedEffects& of = fit_.random[term];
    return {.term = term, .effects = of.effects, .uncertainty = of.uncertainty, .group = group};
  }

 private:
  const FittedModel& fit_;
  LabelNumbers clusters_;
};

/// Sets of the groups of the fit.
void add_conditional(const FittedModel& fit,
                     const data::Table& table,
                     const PredictionOptions& options,
                     bool with_covariances,
                     CoefficientSets& result) {
  if (with_covariances) require_uncertainty(fit);
  std::vector<Index> counts;
  std::vector<LabelNumbers> numbers;
  for (const EstimatedEffects& term : fit.random) {
    counts.push_back(std::ssize(term.labels));
    numbers.push_back(numbered(term.labels));
  }
  const SetNumbers sets(counts);
  SetBuilder builder(fit, sets.count(), with_covariances, result);
  const FittedGroups groups(fit);
  for (std::size_t t = 0; t < counts.size(); ++t) {
    for (Index k = 0; k < counts[t]; ++k) builder.set(sets.of(t, k), groups.with(t, k));
  }
  const GroupLabels labels(fit.specification, table);
  NewGroupRows new_rows(fit, table, options.new_groups, false, result);
  const auto set_row = [&](std::size_t row) {
    const std::size_t last = counts.size() - 1;
    for (std::size_t t = counts.size(); t-- > 0;) {
      const std::string label = labels.of(t, row);
      const auto found = numbers[t].find(label);
      if (label.empty() || found == numbers[t].end()) continue;
      const Index set = sets.of(t, found->second);
      if (t < last) return new_rows.mark(row, labels.of(last, row), set);
      result.set_of_row[row] = set;
      return;
    }
    new_rows.mark(row, labels.of(last, row), sets.population());
  };
  for (std::size_t row = 0; row < table.rows(); ++row) set_row(row);
}

/// Sets of the combinations of the fit's groups in the rows of a table.
void add_crossed(const FittedModel& fit,
                 const data::Table& table,
                 const PredictionOptions& options,
                 bool with_covariances,
                 CoefficientSets& result) {
  if (with_covariances) {
    throw UsageError(
        "standard errors and intervals of predictions with crossed random effects, or with more "
        "than two levels of groups, are available at the population `level` only");
  }
  std::vector<LabelNumbers> numbers;
  for (const EstimatedEffects& term : fit.random) numbers.push_back(numbered(term.labels));
  const GroupLabels labels(fit.specification, table);
  std::map<std::vector<Index>, Index> sets;  // by group of each term, -1 for unknown ones
  std::vector<std::vector<Index>> groups_of_set;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    std::vector<Index> groups;
    for (std::size_t t = 0; t < numbers.size(); ++t) {
      const auto found = numbers[t].find(labels.of(t, row));
      groups.push_back(found == numbers[t].end() ? -1 : found->second);
    }
    const auto [place, is_new] = sets.emplace(groups, std::ssize(groups_of_set));
    if (is_new) groups_of_set.push_back(groups);
    result.set_of_row[row] = place->second;
  }
  SetBuilder builder(fit, std::ssize(groups_of_set), false, result);
  const FittedGroups known(fit);
  for (std::size_t set = 0; set < groups_of_set.size(); ++set) {
    std::vector<KnownEffects> effects;
    for (std::size_t t = numbers.size(); t-- > 0;) {
      const Index group = groups_of_set[set][t];
      if (group >= 0) effects.push_back(known.known(t, group));
    }
    if (!effects.empty()) builder.set(static_cast<Index>(set), effects);
  }
  NewGroupRows new_rows(fit, table, options.new_groups, false, result);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const Index set = result.set_of_row[row];
    const std::vector<Index>& groups = groups_of_set[static_cast<std::size_t>(set)];
    const auto unknown = std::ranges::find(groups, -1);
    if (unknown == groups.end()) continue;
    if (options.new_groups == NewGroups::kMarginal &&
        std::ranges::count(groups, -1) < std::ssize(groups)) {
      throw UsageError(
          "the mean over new groups is not available where the fit has groups of other crossed "
          "terms; choose `new_groups` population, missing or error");
    }
    const auto term = static_cast<std::size_t>(unknown - groups.begin());
    new_rows.mark(row, fit.specification.random[term].group, labels.of(term, row), set);
  }
}

/// Sets of the groups of the table.
class CalibratedSets {
 public:
  CalibratedSets(const FittedModel& fit,
                 const data::Table& table,
                 const PredictionOptions& options,
                 bool with_covariances,
                 CoefficientSets& result)
      : fitted_(fit),
        seen_(options.seen_groups),
        result_(result),
        calibration_(calibrate(
            fit, table, {.seen_groups = options.seen_groups, .threads = options.threads})),
        terms_(calibration_.random),
        sets_(group_counts(terms_)),
        builder_(fit, sets_.count(), with_covariances, result),
        new_rows_(fit, table, options.new_groups, true, result) {}

  void add() {
    find_known();
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      for (std::size_t k = 0; k < is_known_[t].size(); ++k) {
        if (is_known_[t][k]) builder_.set(sets_.of(t, static_cast<Index>(k)), effects_of(t, k));
      }
    }
    const std::size_t rows = terms_.back().group_of_row.size();
    result_.calibrated_from.assign(rows, 0);
    for (std::size_t row = 0; row < rows; ++row) set_row(row);
  }

 private:
  static std::vector<Index> group_counts(const std::vector<CalibratedEffects>& terms) {
    std::vector<Index> counts;
    for (const CalibratedEffects& term : terms) counts.push_back(std::ssize(term.labels));
    return counts;
  }

  bool is_last(std::size_t term) const { return term + 1 == terms_.size(); }

  /// The groups with trees in the table or, if these are used, in the fit.
  void find_known() {
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      for (const Index fitted : terms_[t].fitted_group) {
        is_known_[t].push_back(seen_ != SeenGroups::kNew && fitted >= 0);
      }
    }
    const CalibratedEffects& last = terms_.back();
    for (std::size_t g = 0; g < last.labels.size(); ++g) {
      if (calibration_.measured[g] == 0) continue;
      is_known_.back()[g] = true;
      const Index before = last.coarser_group[g];
      if (before >= 0) is_known_[terms_.size() - 2][static_cast<std::size_t>(before)] = true;
    }
  }

  /// Whether a group keeps the effects of the fit, without those of its further trees.
  bool keeps_fitted(std::size_t group) const {
    return seen_ == SeenGroups::kFitted && terms_.back().fitted_group[group] >= 0;
  }

  /// The effects of a group and of those that it is in.
  std::vector<KnownEffects> effects_of(std::size_t term, std::size_t group) const {
    // A known group without further trees keeps the fit's effects of all terms.
    if (is_last(term) && keeps_fitted(group)) {
      return fitted_.with(term, terms_[term].fitted_group[group]);
    }
    std::vector<KnownEffects> result;
    for (auto k = static_cast<Index>(group); k >= 0; --term) {
      const CalibratedEffects& of = terms_[term];
      result.push_back(
          {.term = term, .effects = of.effects, .uncertainty = of.uncertainty, .group = k});
      k = of.coarser_group[static_cast<std::size_t>(k)];
    }
    return result;
  }

  void set_row(std::size_t row) {
    const Index own = terms_.back().group_of_row[row];
    for (std::size_t t = terms_.size(); t-- > 0;) {
      const Index g = terms_[t].group_of_row[row];
      if (g < 0 || !is_known_[t][static_cast<std::size_t>(g)]) continue;
      if (!is_last(t)) return new_rows_.mark(row, label_of(own), sets_.of(t, g));
      result_.set_of_row[row] = sets_.of(t, g);
      const auto k = static_cast<std::size_t>(g);
      result_.calibrated_from[row] = keeps_fitted(k) ? -1 : calibration_.measured[k];
      return;
    }
    new_rows_.mark(row, label_of(own), sets_.population());
  }

  std::string label_of(Index group) const {
    return group < 0 ? std::string() : terms_.back().labels[static_cast<std::size_t>(group)];
  }

  FittedGroups fitted_;
  SeenGroups seen_;
  CoefficientSets& result_;
  Calibration calibration_;
  const std::vector<CalibratedEffects>& terms_;
  SetNumbers sets_;
  SetBuilder builder_;
  NewGroupRows new_rows_;
  std::vector<std::vector<bool>> is_known_{terms_.size()};  ///< by group of each term
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
  } else if (level == Level::kConditional) {
    const auto add = are_crossed(fit.specification.random) ? add_crossed : add_conditional;
    add(fit, table, options, with_covariances, result);
  } else {
    add_calibrated(fit, table, options, with_covariances, result);
  }
  return result;
}

}  // namespace silvafit::fit
