// SPDX-License-Identifier: MIT
#include "mixed_effects/expected_information.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <memory>

#include "conditional_modes/effect_layout.hpp"
#include "conditional_modes/random_places.hpp"
#include "likelihood/crossed_profile.hpp"
#include "model/correlated_rows.hpp"
#include "model/model_groups.hpp"
#include "model/symmetric_eigen.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

/// (columns x columns) upper triangle with the cross products of the rows.
MatrixXd triangle_of(const MatrixXd& rows) {
  const Index columns = rows.cols();
  MatrixXd result = MatrixXd::Zero(columns, columns);
  const Eigen::HouseholderQR<MatrixXd> qr(rows);
  const Index filled = std::min(columns, rows.rows());
  result.topRows(filled) = qr.matrixQR().topRows(filled).triangularView<Eigen::Upper>();
  return result;
}

/// Rows whose cross products are those of the other columns after standard normal effects of the
/// first columns are integrated out.
MatrixXd without_effects(const MatrixXd& rows, Index effects) {
  MatrixXd augmented(rows.rows() + effects, rows.cols());
  augmented.topRows(rows.rows()) = rows;
  augmented.bottomRows(effects) = MatrixXd::Identity(effects, rows.cols());
  const Index rest = rows.cols() - effects;
  return triangle_of(augmented).bottomRightCorner(rest, rest);
}

MatrixXd stacked(const MatrixXd& above, const MatrixXd& below) {
  MatrixXd result(above.rows() + below.rows(), below.cols());
  result << above, below;
  return result;
}

/// (N x (q + s + p)) columns of the q effects of the last term, of the s ones of the term before,
/// and of the coefficients in a frame, in residual standard deviations.
MatrixXd standardized_columns(const NonlinearModel& model,
                              const Estimates& fit,
                              const Eigen::Ref<const MatrixXd>& coefficients,
                              const VectorXd& residual_sd,
                              const MatrixXd& frame) {
  MatrixXd jacobian = model.curve_at(coefficients).jacobian;
  jacobian = residual_sd.cwiseInverse().asDiagonal() * jacobian;
  const Index p = model.coefficient_count();
  Index effects = 0;
  for (const EstimatedEffects& term : fit.random) effects += term.covariance.rows();
  MatrixXd result(jacobian.rows(), effects + p);
  Index begin = 0;
  for (std::size_t t = fit.random.size(); t-- > 0;) {
    const std::vector<Index> places = model.coefficients_of(model.specification().random[t]);
    const auto q = static_cast<Index>(places.size());
    result.middleCols(begin, q) =
        jacobian(Eigen::all, places) * covariance_factor(fit.random[t].covariance);
    begin += q;
  }
  result.rightCols(p) = jacobian.leftCols(p) * frame;
  whiten(model, fit.variance, result);
  return result;
}

/// The same with crossed terms.
/// \param columns  (N x (effects + p)) as standardized_columns() has them, the last term's first
MatrixXd crossed_covariance(const NonlinearModel& model,
                            const Estimates& fit,
                            const MatrixXd& columns,
                            const MatrixXd& frame) {
  const Index p = model.coefficient_count();
  RandomColumns random{.crossed = std::make_shared<const EffectLayout>(model),
                       .of_groups = model.crossed()->of_cells};
  RelativeFactors factors;
  Index end = columns.cols() - p;
  for (const EstimatedEffects& term : fit.random) {
    const Index q = term.covariance.rows();
    std::vector<Index>& own = random.terms.emplace_back();
    for (Index k = end - q; k < end; ++k) own.push_back(k);
    factors.emplace_back(MatrixXd::Identity(q, q));
    end -= q;
  }
  for (Index c = 0; c <= model.cluster_count(); ++c) {
    random.cluster_begin.push_back(model.cluster_begin(c));
  }
  GroupMoments moments(columns.cols(), model.group_count(), 0, {}, RandomPlaces(random.terms).all);
  for (Index cell = 0; cell < model.group_count(); ++cell) {
    const Index begin = model.group_begin(cell);
    const MatrixXd rows = columns.middleRows(begin, model.group_begin(cell + 1) - begin);
    const MatrixXd products = rows.transpose() * rows;
    moments.keep(cell, products.data());
    moments.add_totals(products.reshaped());
  }
  const MatrixXd sum = without_crossed_effects(random, factors, moments);
  const MatrixXd inverse = sum.bottomRightCorner(p, p).llt().solve(MatrixXd(frame.transpose()));
  return frame * inverse;
}

}  // namespace

MatrixXd expected_covariance(const NonlinearModel& model,
                             const Estimates& fit,
                             const Eigen::Ref<const MatrixXd>& coefficients,
                             const VectorXd& residual_sd,
                             const MatrixXd& frame) {
  const Index p = model.coefficient_count();
  const MatrixXd columns = standardized_columns(model, fit, coefficients, residual_sd, frame);
  if (!columns.allFinite()) return MatrixXd::Constant(p, p, kNaN);
  if (model.crossed() != nullptr) return crossed_covariance(model, fit, columns, frame);
  const Index q = fit.random.empty() ? 0 : fit.random.back().covariance.rows();
  const Index s = columns.cols() - q - p;
  MatrixXd information(0, p);
  for (Index c = 0; c < model.cluster_count(); ++c) {
    MatrixXd cluster(0, s + p);
    for (Index g = model.cluster_begin(c); g < model.cluster_begin(c + 1); ++g) {
      const Index begin = model.group_begin(g);
      const MatrixXd rows = columns.middleRows(begin, model.group_begin(g + 1) - begin);
      cluster = triangle_of(stacked(cluster, without_effects(rows, q)));
    }
    information = triangle_of(stacked(information, without_effects(cluster, s)));
  }
  const MatrixXd root =
      information.triangularView<Eigen::Upper>().transpose().solve(MatrixXd(frame.transpose()));
  return root.transpose() * root;
}

double likelihood_factor(const NonlinearModel& model) {
  const auto n = static_cast<double>(model.observations());
  return n / (n - static_cast<double>(model.coefficient_count()));
}

}  // namespace silvafit::fit
