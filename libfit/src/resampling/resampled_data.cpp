// SPDX-License-Identifier: MIT
#include "resampling/resampled_data.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "model/symmetric_eigen.hpp"
#include "result/group_coefficients.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/checked_columns.hpp"

namespace silvafit::fit {
namespace {

MatrixXd drawn_effects(const MatrixXd& root, Index groups, Random& random) {
  MatrixXd normal(root.rows(), groups);
  for (double& value : normal.reshaped()) value = random.normal();
  return root * normal;
}

/// Columns of the groups of a replicate; names of columns in files do not begin with a blank.
std::string drawn_name(const std::string& group) { return " drawn " + group; }

std::vector<std::size_t> numbers(Index begin, Index end) {
  std::vector<std::size_t> result;
  for (Index i = begin; i < end; ++i) result.push_back(static_cast<std::size_t>(i));
  return result;
}

}  // namespace

FitModelOptions refit_options(const FittedModel& fit, FitModelOptions options) {
  options.method = fit.method;
  options.reml = fit.reml;
  if (fit.quadrature_points > 0) options.quadrature_points = fit.quadrature_points;
  options.effort = SearchEffort::kQuick;
  options.threads = 1;
  options.trace = nullptr;
  return options;
}

ParametricDraw::ParametricDraw(const FittedModel& fit, const data::Table& table)
    : fit_(fit), model_(fit.specification, table), table_(table.select(model_.rows())) {
  for (const EstimatedEffects& term : fit.random) {
    roots_.push_back(symmetric_root(term.covariance));
  }
  if (!fit.variance.correlation) return;
  correlated_ = CorrelatedRows::of(model_, &*fit.variance.correlation);
  factors_ = correlated_->factors(*fit.variance.correlation);
}

Resampled ParametricDraw::draw(Random& random) const {
  Resampled result{.table = table_, .specification = fit_.specification, .start = fit_};
  MatrixXd coefficients = fit_.estimate;
  if (fit_.has_random_effects()) {
    name_terms(model_, result.start);
    std::vector<MatrixXd> effects;
    for (std::size_t t = 0; t < roots_.size(); ++t) {
      effects.push_back(drawn_effects(roots_[t], model_.group_count(t), random));
      result.start.random[t].effects = effects.back();
    }
    coefficients = fit_.estimate.replicate(1, model_.group_count());
    add_group_effects(model_.groups(), model_.random_coefficients(), effects, coefficients);
  }
  const VectorXd mean = model_.mean_at(coefficients);
  const VectorXd deviation = fit_.residual_sd(mean, table_);
  VectorXd errors(mean.size());
  for (double& error : errors) error = random.normal();
  if (correlated_) {
    correlated_->change(factors_, errors, [](const CorrelationFactor& factor, MatrixXd& part) {
      factor.color(part);
    });
  }
  std::vector<double> response;
  for (Index i = 0; i < mean.size(); ++i) {
    response.push_back(mean[i] + deviation[i] * errors[i]);
    if (std::isfinite(response.back())) continue;
    throw NumericalError(
        "the mean is not finite with the random effects that were drawn for a group");
  }
  result.table.set(fit_.specification.formula.left, std::move(response));
  return result;
}

CaseDraw::CaseDraw(const FittedModel& fit, const data::Table& table, const std::string& group)
    : fit_(fit) {
  const NonlinearModel model(fit.specification, table);
  table_ = table.select(model.rows());
  if (fit.specification.correlation && !fit.has_random_effects()) {
    throw UsageError(
        "cases of correlated residuals without random effects cannot be drawn; use "
        "`resample=parametric`");
  }
  if (fit.has_random_effects()) {
    add_groups(model);
  } else {
    for (std::size_t row = 0; row < table_.rows(); ++row) members_.push_back({row});
  }
  if (!group.empty()) {
    join(group);
  } else {
    for (std::size_t k = 0; k < members_.size(); ++k) units_.push_back({k});
  }
  if (units_.size() < 2) throw UsageError("drawing cases needs at least two of them");
}

void CaseDraw::add_groups(const NonlinearModel& model) {
  if (model.crossed() != nullptr) {
    throw UsageError(
        "cases are drawn by independent groups, which crossed random effects do not have; use "
        "`resample=parametric`");
  }
  if (fit_.random.back().labels != model.group_labels()) {
    throw UsageError("the groups of the table differ from those of the fit");
  }
  for (Index c = 0; c < model.cluster_count(); ++c) {
    const Index first = model.cluster_begin(c);
    const Index last = model.cluster_begin(c + 1);
    members_.push_back(numbers(model.group_begin(first), model.group_begin(last)));
    model_groups_.push_back(numbers(first, last));
  }
}

/// Groups with the same label of a column are drawn together.
void CaseDraw::join(const std::string& group) {
  const data::TextColumn labels = table_.labels(group);
  units_.resize(labels.levels().size());
  for (std::size_t k = 0; k < members_.size(); ++k) {
    const std::size_t first = members_[k].front();
    for (const std::size_t row : members_[k]) {
      if (labels.is_missing(row)) {
        throw InputError("the group is missing", data::place_of(table_, row, group));
      }
      if (labels.code(row) == labels.code(first)) continue;
      throw UsageError(fmt::format("groups of random effects are drawn whole, and this group is in "
                                   "both '{}' and '{}'; name a coarser grouping",
                                   labels[first],
                                   labels[row]),
                       data::place_of(table_, row, group));
    }
    units_[labels.code(first)].push_back(k);
  }
}

Resampled CaseDraw::draw(Random& random) const {
  std::vector<std::size_t> drawn;
  std::vector<std::size_t> rows;
  for (std::size_t k = 0; k < units_.size(); ++k) {
    for (const std::size_t member : units_[random.below(units_.size())]) {
      drawn.push_back(member);
      rows.insert(rows.end(), members_[member].begin(), members_[member].end());
    }
  }
  Resampled result{
      .table = table_.select(rows), .specification = fit_.specification, .start = fit_};
  if (fit_.has_random_effects()) relabel(drawn, result);
  return result;
}

/// A group that was drawn twice is two groups, which both start from its effects.
void CaseDraw::relabel(const std::vector<std::size_t>& drawn, Resampled& result) const {
  std::string& group = result.specification.random.front().group;
  group = drawn_name(group);
  const bool is_nested = result.specification.random.size() > 1;
  FittedModel& start = result.start;
  start.specification = result.specification;
  for (EstimatedEffects& term : start.random) term.labels.clear();
  data::TextColumn column;
  std::vector<Index> groups;
  std::vector<Index> clusters;
  for (std::size_t k = 0; k < drawn.size(); ++k) {
    const std::string label = std::to_string(k + 1);
    for (std::size_t i = 0; i < members_[drawn[k]].size(); ++i) column.append(label);
    for (const std::size_t g : model_groups_[drawn[k]]) {
      groups.push_back(static_cast<Index>(g));
      const NestedParts known = nested_parts(fit_.random.back().labels[g]);
      start.random.back().labels.push_back(is_nested ? nested_label(label, known.inner) : label);
    }
    if (!is_nested) continue;
    clusters.push_back(static_cast<Index>(drawn[k]));
    start.random.front().labels.push_back(label);
  }
  start.random.back().effects = fit_.random.back().effects(Eigen::all, groups);
  if (is_nested) start.random.front().effects = fit_.random.front().effects(Eigen::all, clusters);
  result.table.set(group, std::move(column));
  result.drawn_group = group;
}

}  // namespace silvafit::fit
