// SPDX-License-Identifier: MIT
#include "conditional_modes/correlated_sums.hpp"

#include <numeric>

#include "conditional_modes/arrow_factor.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;

std::vector<Expression> joined(std::vector<Expression> first,
                               const std::vector<Expression>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

/// Adds the lower triangle of a symmetric matrix by columns.
template <typename Target>
void add_triangle(const MatrixXd& matrix, Target&& target) {
  const Index size = matrix.rows();
  for (Index column = 0, at = 0; column < size; at += size - column, ++column) {
    target.segment(at, size - column) += matrix.col(column).tail(size - column);
  }
}

}  // namespace

CorrelatedSums::CorrelatedSums(const NonlinearModel& model,
                               const VarianceModel& variance,
                               Curvature curvature,
                               const ObservationTerms& terms,
                               const std::vector<Index>& random,
                               bool with_slopes)
    : GroupSums(model, random),
      variance_(variance),
      is_full_(curvature == Curvature::kFull),
      scale_count_(variance.parameter_count() - variance.correlation_count() + 1),
      rows_(model, variance, this->random()),
      tasks_(terms, with_slopes, rows_),
      states_(rows_.task_of(joined(terms.states, terms.held))),
      wide_states_(rows_.task_of(joined(terms.states, terms.wide_states))) {
  has_approximation_ = !terms.approximation.empty();
  holds_weights_ = !terms.held.empty();
  others_ = terms.others;
}

void CorrelatedSums::set_point(const ObservationPoint& point) {
  rows_.set_point(point);
  factors_ =
      variance_.correlated()->factors(variance_.correlation_part(point.variance), model_.threads());
}

/// Calls a function with each block's group, counted from the first, its factor, and its rows,
/// counted from those of the first group.
template <typename Use>
void CorrelatedSums::for_blocks(Index first, Index last, const Use& use) const {
  const CorrelatedRows& correlated = *variance_.correlated();
  for (Index g = first; g < last; ++g) {
    for (std::size_t k = correlated.first_block(g); k < correlated.first_block(g + 1); ++k) {
      std::vector<Index> rows = correlated.blocks()[k].rows;
      for (Index& row : rows) row -= model_.group_begin(first);
      use(g - first, *factors_[k], rows);
    }
  }
}

/// Stores a = R^-1 e.
void CorrelatedSums::hold_residuals(Index first, Index last, Workspace& workspace) const {
  workspace.adjoints.resize(workspace.states.rows(), 2 + 2 * random_count());
  for_blocks(first, last, [&](Index, const CorrelationFactor& factor, const auto& rows) {
    MatrixXd residual = workspace.states(rows, 0);
    factor.whiten(residual);
    factor.whiten_transposed(residual);
    workspace.adjoints(rows, 0) = residual;
  });
}

/// Stores u, G and H.
/// \param weights  (triangle x groups) the matrices M
void CorrelatedSums::hold_penalties(const MatrixXd& weights,
                                    Index first,
                                    Index last,
                                    Workspace& workspace) const {
  const Index r = random_count();
  for_blocks(first, last, [&](Index g, const CorrelationFactor& factor, const auto& rows) {
    const MatrixXd states = workspace.states(rows, Eigen::all);
    const MatrixXd weight = unpacked(weights.col(g).data(), r);
    MatrixXd held(states.rows(), 1 + r);
    held.col(0) = states.rightCols(1);  // m, if K is the second derivative
    held.rightCols(r) = states.middleCols(is_full_ ? 1 : means(), r) * weight;
    factor.whiten(held);
    factor.whiten_transposed(held);
    workspace.adjoints(rows, Eigen::seqN(1, 1 + r)) = held;
    if (is_full_) return;
    const MatrixXd turn = states.middleCols(scales(), r) * weight;
    workspace.adjoints(rows, Eigen::lastN(r)) = turn + factor.times_expected(turn);
  });
}

void CorrelatedSums::density(Index first,
                             Index last,
                             const MatrixXd& effects,
                             MatrixXd& sums,
                             Workspace& workspace,
                             HeldWeights* weights) const {
  if (factors_.empty()) {
    sums.setConstant(density_count(), last - first, kNaN);
    return;
  }
  ObservationRows::GroupValues values{.effects = effects, .first = first, .held = weights};
  rows_.fill(states_, values, last, workspace.states, workspace);
  hold_residuals(first, last, workspace);
  values.adjoints = &workspace.adjoints;
  rows_.sum(tasks_.density, values, last, sums, workspace);
  const Index r = random_count();
  const Index triangle = r * (r + 1) / 2;
  for_blocks(first, last, [&](Index g, const CorrelationFactor& factor, const auto& rows) {
    MatrixXd states = workspace.states(rows, Eigen::all);
    const MatrixXd slopes = has_approximation_ ? states.middleCols(scales(), r) : MatrixXd();
    factor.whiten(states);
    auto of = sums.col(g);
    const double own = 0.5 * states.col(0).squaredNorm();
    of[0] +=
        holds_weights_ ? 0.5 * states.rightCols(1).squaredNorm() : own + factor.log_determinant();
    if (holds_weights_) of[of.size() - 1] += own;
    const MatrixXd effect = states.middleCols(1, r);
    add_triangle(effect.transpose() * effect, of.segment(1 + r, triangle));
    if (!has_approximation_) return;
    const MatrixXd mean = states.middleCols(means(), r);
    const MatrixXd expected =
        mean.transpose() * mean + slopes.transpose() * (slopes + factor.times_expected(slopes));
    add_triangle(expected, of.segment(1 + r + triangle, triangle));
  });
}

void CorrelatedSums::mixed(
    Index first, Index last, const MatrixXd& effects, MatrixXd& sums, Workspace& workspace) const {
  sums.setZero(0, last - first);
  if (tasks_.mixed.outputs == 0) return;
  ObservationRows::GroupValues values{.effects = effects, .first = first};
  rows_.fill(wide_states_, values, last, workspace.states, workspace);
  hold_residuals(first, last, workspace);
  values.adjoints = &workspace.adjoints;
  rows_.sum(tasks_.mixed, values, last, sums, workspace);
  for_blocks(first, last, [&](Index g, const CorrelationFactor& factor, const auto& rows) {
    MatrixXd states = workspace.states(rows, Eigen::all);
    factor.whiten(states);
    sums.col(g) += (states.middleCols(1, random_count()).transpose() *
                    states.middleCols(others_at(), std::ssize(others_)))
                       .reshaped();
  });
}

/// Copies sums by parameters of the scale and log sigma, of which some numbers belong to each, with
/// zeros for those of the correlation between.
void CorrelatedSums::spread(
    const MatrixXd& from, Index source, Index numbers, MatrixXd& to, Index target) const {
  const Index before = (scale_count_ - 1) * numbers;
  const Index between = variance_.correlation_count() * numbers;
  to.middleRows(target, before) = from.middleRows(source, before);
  to.middleRows(target + before, between).setZero();
  to.middleRows(target + before + between, numbers) = from.middleRows(source + before, numbers);
}

void CorrelatedSums::slopes(
    Index first, Index last, const MatrixXd& effects, MatrixXd& sums, Workspace& workspace) const {
  ObservationRows::GroupValues values{.effects = effects, .first = first};
  rows_.fill(states_, values, last, workspace.states, workspace);
  hold_residuals(first, last, workspace);
  values.adjoints = &workspace.adjoints;
  MatrixXd& of_rows = workspace.of_rows;
  rows_.sum(tasks_.slopes, values, last, of_rows, workspace);
  const Index p = model_.column_count();
  sums.resize(2 + p + variance_.parameter_count(), last - first);
  sums.topRows(1 + p) = of_rows.topRows(1 + p);
  spread(of_rows, 1 + p, 1, sums, 1 + p);
  for_blocks(first, last, [&](Index g, const CorrelationFactor& factor, const auto& rows) {
    MatrixXd residual = workspace.states(rows, 0);
    factor.whiten(residual);
    sums(0, g) += 0.5 * residual.squaredNorm() + factor.log_determinant();
    for (Index k = 0; k < variance_.correlation_count(); ++k) {
      sums(p + scale_count_ + k, g) +=
          factor.log_slopes()[k] + residual.cwiseProduct(factor.slope(k, residual)).sum();
    }
  });
}

void CorrelatedSums::total(Index first,
                           Index last,
                           const MatrixXd& effects,
                           const MatrixXd& weights,
                           MatrixXd& sums,
                           Workspace& workspace) const {
  ObservationRows::GroupValues values{.effects = effects, .weights = &weights, .first = first};
  rows_.fill(wide_states_, values, last, workspace.states, workspace);
  hold_residuals(first, last, workspace);
  hold_penalties(weights, first, last, workspace);
  values.adjoints = &workspace.adjoints;
  MatrixXd& of_rows = workspace.of_rows;
  rows_.sum(tasks_.total, values, last, of_rows, workspace);
  const Index r = random_count();
  const Index others = std::ssize(others_);
  const Index m = variance_.parameter_count() + 1;
  const Index mixed_at = r + others + m;
  sums.resize(mixed_at + (others + m) * r, last - first);
  sums.topRows(r + others) = of_rows.topRows(r + others);
  spread(of_rows, r + others, 1, sums, r + others);
  sums.middleRows(mixed_at, others * r) = of_rows.middleRows(r + others + scale_count_, others * r);
  spread(of_rows, of_rows.rows() - scale_count_ * r, r, sums, mixed_at + others * r);
  for_blocks(first, last, [&](Index g, const CorrelationFactor& factor, const auto& rows) {
    add_between(factor,
                workspace.states(rows, Eigen::all),
                unpacked(weights.col(g).data(), r),
                sums.col(g));
  });
}

/// Adds to the sums of total() what is between the rows of a block, and the derivatives by the
/// parameters of the correlation.
void CorrelatedSums::add_between(const CorrelationFactor& factor,
                                 const MatrixXd& states,
                                 const MatrixXd& weight,
                                 Eigen::Ref<VectorXd> sums) const {
  const Index r = random_count();
  const Index others = std::ssize(others_);
  const Index m = variance_.parameter_count() + 1;
  auto by_correlation = sums.segment(r + others + scale_count_ - 1, variance_.correlation_count());
  auto other_random = sums.segment(r + others + m, others * r);
  auto variance_random = sums.tail(m * r).reshaped(r, m);
  MatrixXd white = states;
  factor.whiten(white);
  const MatrixXd effect = white.middleCols(1, r);
  other_random += (effect.transpose() * white.middleCols(others_at(), others)).reshaped();
  const MatrixXd scale = effect.transpose() * white.middleCols(variance_at(), scale_count_);
  variance_random.leftCols(scale_count_ - 1) += scale.leftCols(scale_count_ - 1);
  variance_random.rightCols(1) += scale.rightCols(1);
  for (Index k = 0; k < by_correlation.size(); ++k) {
    const MatrixXd slope = factor.slope(k, white);
    by_correlation[k] += factor.log_slopes()[k] + white.col(0).dot(slope.col(0)) +
                         penalty_slope(factor, k, states, white, slope, weight);
    variance_random.col(scale_count_ - 1 + k) +=
        effect.transpose() * slope.col(0) + slope.middleCols(1, r).transpose() * white.col(0);
  }
}

/// dc by a parameter of the correlation.
/// \param white  L^-1 times the states
/// \param slope  its factor.slope()
double CorrelatedSums::penalty_slope(const CorrelationFactor& factor,
                                     Index k,
                                     const MatrixXd& states,
                                     const MatrixXd& white,
                                     const MatrixXd& slope,
                                     const MatrixXd& weight) const {
  const Index r = random_count();
  const Index at = is_full_ ? 1 : means();
  const double of_means =
      (white.middleCols(at, r) * weight).cwiseProduct(slope.middleCols(at, r)).sum();
  if (is_full_) {
    const Index bend = white.cols() - 1;
    return of_means + 0.5 * (white.col(0).dot(slope.col(bend)) + slope.col(0).dot(white.col(bend)));
  }
  const MatrixXd scale = states.middleCols(scales(), r);
  return of_means + 0.5 * factor.expected_slope(k, scale * weight, scale);
}

}  // namespace silvafit::fit
