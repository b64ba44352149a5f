// SPDX-License-Identifier: MIT
#include "likelihood/surface_layout.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace silvafit::fit {

SurfaceLayout::SurfaceLayout(const NonlinearModel& model,
                             const VarianceModel& variance,
                             CoefficientFrame frame,
                             Index beta_count)
    : frame_(std::move(frame)),
      beta_(beta_count),
      variance_(variance.parameter_count()),
      begins_{beta_count} {
  for (std::size_t t = 0; t < model.term_count(); ++t) {
    factors_.emplace_back(model.specification().random[t], frame_.effects[t].diagonal());
    begins_.push_back(begins_.back() + factors_.back().parameter_count());
  }
}

MatrixXd SurfaceLayout::own_factor(const VectorXd& x, std::size_t term) const {
  return frame_.effects[term] * factor(term).factor(factor_part(x, term));
}

void SurfaceLayout::set_own_factor(std::size_t term, const MatrixXd& own, VectorXd& x) const {
  const RelativeFactor& of = factor(term);
  const MatrixXd scaled = frame_.effects[term].triangularView<Eigen::Lower>().solve(own);
  x.segment(factor_at(term), of.parameter_count()) = of.from_factor(scaled);
}

VectorXd SurfaceLayout::factor_gradient(const VectorXd& x,
                                        std::size_t term,
                                        const MatrixXd& by_own) const {
  const MatrixXd lower = by_own.triangularView<Eigen::Lower>();
  return factor(term).gradient(factor_part(x, term), frame_.effects[term].transpose() * lower);
}

MatrixXd SurfaceLayout::own_factor_gradient(std::size_t term, const VectorXd& gradient) const {
  const MatrixXd scaled = factor(term).factor(factor_part(gradient, term));
  const MatrixXd own =
      frame_.effects[term].triangularView<Eigen::Lower>().transpose().solve(scaled);
  return own.triangularView<Eigen::Lower>();
}

std::string SurfaceLayout::name(const NonlinearModel& model, Index at) const {
  if (at < beta_) return model.coefficient_names()[static_cast<std::size_t>(at)];
  if (at == sigma_at()) return "sigma";
  if (at >= variance_at()) return "the variance function";
  const auto next = std::ranges::upper_bound(begins_, at);
  const auto term = static_cast<std::size_t>(next - begins_.begin()) - 1;
  const RelativeFactor& form = factor(term);
  // The row and column of an element in the factor determine its effects.
  const VectorXd only = VectorXd::Unit(form.parameter_count(), at - factor_at(term));
  Index row = 0;
  Index column = 0;
  form.factor(only).cwiseAbs().maxCoeff(&row, &column);
  const std::vector<std::string>& effects = model.specification().random[term].coefficients;
  const std::string& of_row = effects[static_cast<std::size_t>(row)];
  if (row == column) return fmt::format("sd({})", of_row);
  return fmt::format("cor({}, {})", effects[static_cast<std::size_t>(column)], of_row);
}

VectorXd SurfaceLayout::lifted(VectorXd x) const {
  // In units of the residual standard deviation.
  constexpr double kNone = 1e-3;
  constexpr double kInside = 0.1;
  for (std::size_t term = 0; term < terms(); ++term) {
    const RelativeFactor& form = factor(term);
    for (Index k = 0; k < form.parameter_count(); ++k) {
      double& element = x[factor_at(term) + k];
      const MatrixXd only = form.factor(VectorXd::Unit(form.parameter_count(), k));
      if (!only.diagonal().isZero(0.0) && std::abs(element) < kNone) element = kInside;
    }
  }
  return x;
}

VectorXd SurfaceLayout::coordinates(const VectorXd& beta,
                                    const std::vector<MatrixXd>& covariances,
                                    const VectorXd& variance,
                                    double log_sigma) const {
  VectorXd x(size());
  if (beta_ > 0) x.head(beta_) = frame_.beta.partialPivLu().solve(beta);
  for (std::size_t term = 0; term < terms(); ++term) {
    const auto frame = frame_.effects[term].triangularView<Eigen::Lower>();
    const MatrixXd half = frame.solve(covariances[term]);
    const RelativeFactor& form = factor(term);
    x.segment(factor_at(term), form.parameter_count()) =
        form.from_covariance(frame.solve(half.transpose()));
  }
  x.segment(variance_at(), variance_) = variance;
  x[sigma_at()] = log_sigma;
  return x;
}

}  // namespace silvafit::fit
