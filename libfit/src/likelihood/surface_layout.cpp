// SPDX-License-Identifier: MIT
#include "likelihood/surface_layout.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <utility>
#include <vector>

#include "model/nested_terms.hpp"

namespace silvafit::fit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

SurfaceLayout::SurfaceLayout(const NonlinearModel& model,
                             const VarianceModel& variance,
                             CoefficientFrame frame,
                             Index beta_count)
    : frame_(std::move(frame)),
      beta_(beta_count),
      variance_(variance.parameter_count()),
      outer_(or_none(coarser_term(model.specification())), frame_.outer.diagonal()),
      inner_(or_none(finer_term(model.specification())), frame_.inner.diagonal()) {}

MatrixXd SurfaceLayout::own_factor(const VectorXd& x, bool is_outer) const {
  return frame_.effects(is_outer) * factor(is_outer).factor(factor_part(x, is_outer));
}

void SurfaceLayout::set_own_factor(bool is_outer, const MatrixXd& own, VectorXd& x) const {
  const RelativeFactor& of = factor(is_outer);
  const MatrixXd scaled = frame_.effects(is_outer).triangularView<Eigen::Lower>().solve(own);
  x.segment(factor_at(is_outer), of.parameter_count()) = of.from_factor(scaled);
}

VectorXd SurfaceLayout::factor_gradient(bool is_outer, const MatrixXd& by_own) const {
  const MatrixXd lower = by_own.triangularView<Eigen::Lower>();
  return factor(is_outer).gradient(frame_.effects(is_outer).transpose() * lower);
}

MatrixXd SurfaceLayout::own_factor_gradient(bool is_outer, const VectorXd& gradient) const {
  const MatrixXd scaled = factor(is_outer).factor(factor_part(gradient, is_outer));
  const MatrixXd own =
      frame_.effects(is_outer).triangularView<Eigen::Lower>().transpose().solve(scaled);
  return own.triangularView<Eigen::Lower>();
}

std::string SurfaceLayout::name(const NonlinearModel& model, Index at) const {
  if (at < beta_) return model.coefficient_names()[static_cast<std::size_t>(at)];
  if (at == sigma_at()) return "sigma";
  if (at >= variance_at()) return "the variance function";
  const bool is_outer = at < inner_at();
  const RelativeFactor& form = factor(is_outer);
  // The row and column of an element in the factor determine its effects.
  const VectorXd only = VectorXd::Unit(form.parameter_count(), at - factor_at(is_outer));
  Index row = 0;
  Index column = 0;
  form.factor(only).cwiseAbs().maxCoeff(&row, &column);
  const ModelSpecification& specification = model.specification();
  const std::vector<std::string>& effects =
      (is_outer ? coarser_term(specification) : finer_term(specification))->coefficients;
  const std::string& of_row = effects[static_cast<std::size_t>(row)];
  if (row == column) return fmt::format("sd({})", of_row);
  return fmt::format("cor({}, {})", effects[static_cast<std::size_t>(column)], of_row);
}

VectorXd SurfaceLayout::coordinates(const VectorXd& beta,
                                    const MatrixXd& outer,
                                    const MatrixXd& inner,
                                    const VectorXd& variance,
                                    double log_sigma) const {
  VectorXd x(size());
  if (beta_ > 0) x.head(beta_) = frame_.beta.partialPivLu().solve(beta);
  for (const bool is_outer : {true, false}) {
    const auto frame = frame_.effects(is_outer).triangularView<Eigen::Lower>();
    if (frame.rows() == 0) continue;
    const MatrixXd half = frame.solve(is_outer ? outer : inner);
    const RelativeFactor& form = factor(is_outer);
    x.segment(factor_at(is_outer), form.parameter_count()) =
        form.from_covariance(frame.solve(half.transpose()));
  }
  x.segment(variance_at(), variance_) = variance;
  x[sigma_at()] = log_sigma;
  return x;
}

}  // namespace silvafit::fit
