// SPDX-License-Identifier: MIT
// Cross products of groups whose residuals are correlated: of the rows L^-1 G^-1 [X w].
#include <algorithm>
#include <cmath>

#include "likelihood/linearization.hpp"
#include "silvafit/base/parallel.hpp"

namespace silvafit::fit {

void Linearizer::keep_rows(const Pass& pass,
                           const Segment& segment,
                           Index offset,
                           const Scratch& scratch) const {
  const Index rows = segment.end - segment.begin;
  for (std::size_t j = 0; j < scratch.columns.size(); ++j) {
    auto target = kept_rows_.col(static_cast<Index>(j)).segment(segment.begin, rows);
    target = Eigen::Map<const VectorXd>(scratch.columns[j], rows);
    if (pass.result.weight.size() > 0) {
      target.array() *= pass.result.weight.segment(segment.begin, rows).sqrt();
    }
  }
  if (!pass.expand || kept_slopes_.cols() == 0) return;
  for (std::size_t k = 0; k < variance_.quantities().size(); ++k) {
    kept_slopes_.col(static_cast<Index>(k)).segment(segment.begin, rows) =
        log_scale_slope(k, offset, rows, scratch);
  }
}

MatrixXd Linearizer::scale_slopes(const std::vector<Index>& rows) const {
  MatrixXd result =
      MatrixXd::Zero(std::ssize(rows), variance_.parameter_count() - variance_.correlation_count());
  const auto& quantities = variance_.quantities();
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    const NonlinearModel::Strata* const strata = strata_of(k);
    for (Index i = 0; i < result.rows(); ++i) {
      const Index row = rows[static_cast<std::size_t>(i)];
      const Index stratum = strata == nullptr ? 0
                                              : strata->of_rows[static_cast<std::size_t>(row)] -
                                                    (quantities[k].has_reference ? 1 : 0);
      if (stratum < 0) continue;
      result(i, quantities[k].first + stratum) = kept_slopes_(row, static_cast<Index>(k));
    }
  }
  return result;
}

void Linearizer::add_correlated_group(const Pass& pass, Index group, VectorXd& sum_log) const {
  const CorrelatedRows& correlated = *variance_.correlated();
  GroupMoments& moments = pass.result.model.moments;
  const Index w = moments.width();
  const Index scale_count = variance_.parameter_count() - variance_.correlation_count();
  const auto add = [&](Index term, const MatrixXd& a, const MatrixXd& b) {
    Eigen::Map<MatrixXd> target(moments.term(group, term), w, w);
    const MatrixXd product = a.transpose() * b;
    target += product + product.transpose();
  };
  for (std::size_t k = correlated.first_block(group); k < correlated.first_block(group + 1); ++k) {
    const std::vector<Index>& rows = correlated.blocks()[k].rows;
    const MatrixXd scaled = kept_rows_(rows, Eigen::all);
    const CorrelationFactor& factor = *factors_[factors_now_].factors[k];
    MatrixXd whitened = scaled;
    factor.whiten(whitened);
    Eigen::Map<MatrixXd>(moments.term(group, 0), w, w) += whitened.transpose() * whitened;
    sum_log[0] += factor.log_determinant();
    if (pass.before != nullptr) {
      MatrixXd residual = scaled.col(w - 1);
      if (pass.before->weight.size() > 0) {
        for (std::size_t i = 0; i < rows.size(); ++i) {
          residual(static_cast<Index>(i), 0) *=
              std::sqrt(pass.before->weight[rows[i]] / pass.result.weight[rows[i]]);
        }
      }
      factors_[factors_before_].factors[k]->whiten(residual);
      pass.result.squares_before[group] += residual.squaredNorm();
    }
    if (!pass.expand) continue;
    const MatrixXd slopes = scale_slopes(rows);
    for (Index j = 0; j < scale_count; ++j) {
      MatrixXd moved = -(slopes.col(j).asDiagonal() * scaled);
      factor.whiten(moved);
      add(1 + j, whitened, moved);
      sum_log[1 + j] += slopes.col(j).sum();
    }
    for (Index j = 0; j < variance_.correlation_count(); ++j) {
      add(1 + scale_count + j, whitened, factor.slope(j, whitened));
      sum_log[1 + scale_count + j] += factor.log_slopes()[j];
    }
  }
}

std::size_t Linearizer::kept_factors(const VectorXd& parameters, std::size_t free) {
  for (std::size_t k = 0; k < factors_.size(); ++k) {
    if (!factors_[k].factors.empty() && factors_[k].parameters == parameters) return k;
  }
  factors_[free] = {.parameters = parameters,
                    .factors = variance_.correlated()->factors(parameters, model_.threads())};
  return free;
}

bool Linearizer::add_correlated(const Pass& pass) {
  const VectorXd parameters = variance_.correlation_part(pass.point.variance);
  const VectorXd earlier =
      pass.before == nullptr ? parameters : variance_.correlation_part(pass.before->variance);
  if (!parameters.allFinite()) return false;
  factors_before_ = kept_factors(earlier, 0);
  factors_now_ = kept_factors(parameters, 1 - factors_before_);
  if (factors_[factors_before_].factors.empty() || factors_[factors_now_].factors.empty()) {
    return false;
  }
  constexpr Index kPartGroups = 64;
  const Index groups =
      std::min(model_.group_count(), pass.point.last_group) - pass.point.first_group;
  const auto parts = static_cast<std::size_t>((groups + kPartGroups - 1) / kPartGroups);
  std::vector<VectorXd> sums(parts, VectorXd::Zero(pass.result.model.moments.terms()));
  parallel_for(parts, model_.threads(), [&](std::size_t part) {
    const Index begin = pass.point.first_group + static_cast<Index>(part) * kPartGroups;
    const Index end = std::min(begin + kPartGroups, pass.point.first_group + groups);
    for (Index group = begin; group < end; ++group) {
      add_correlated_group(pass, group, sums[part]);
      finish_group(pass, group, pass.result.model.moments.term(group, 0));
    }
  });
  for (const VectorXd& sum : sums) pass.result.model.moments.sum_log() += sum;
  pass.result.longest_change = VectorXd::Constant(pass.result.model.moments.parameters(), 1.0);
  return pass.result.squares.allFinite() && pass.result.model.moments.all_finite();
}

}  // namespace silvafit::fit
