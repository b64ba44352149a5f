// SPDX-License-Identifier: MIT
#include "mixed_effects/strata_start.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "mixed_effects/medians.hpp"
#include "silvafit/fit/least_squares.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

using Rows = std::vector<Index>;

// Sufficient for a median; more would only cost time.
constexpr Index kMostStrata = 9;
constexpr Index kFewestStrata = 3;
// A stratum needs some observations more than coefficients, and not more than a curve needs.
constexpr Index kMostObservations = 400;

/// (G) the residuals of each group from the pooled fit, relative to its fitted values.
VectorXd levels_of_groups(const NonlinearModel& model, const VectorXd& pooled) {
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  model.evaluate(pooled, mean, nullptr, workspace);
  VectorXd levels(model.group_count());
  for (Index g = 0; g < levels.size(); ++g) {
    const Index begin = model.group_begin(g);
    const Index count = model.group_begin(g + 1) - begin;
    const double fitted = mean.segment(begin, count).cwiseAbs().sum();
    const double residual = (model.response() - mean).segment(begin, count).sum();
    levels[g] = fitted > 0.0 ? residual / fitted : 0.0;
  }
  return levels;
}

/// Groups from the lowest to the highest, divided into strata with about equal numbers of
/// observations.
std::vector<Rows> strata_of(const NonlinearModel& model, const VectorXd& pooled, Index count) {
  const VectorXd levels = levels_of_groups(model, pooled);
  Rows order(static_cast<std::size_t>(levels.size()));
  std::iota(order.begin(), order.end(), Index{0});
  std::ranges::stable_sort(order, {}, [&](Index g) { return levels[g]; });
  std::vector<Rows> strata(static_cast<std::size_t>(count));
  Index before = 0;
  for (const Index g : order) {
    Rows& rows = strata[static_cast<std::size_t>(before * count / model.observations())];
    for (Index i = model.group_begin(g); i < model.group_begin(g + 1); ++i) rows.push_back(i);
    before += model.group_begin(g + 1) - model.group_begin(g);
  }
  for (Rows& rows : strata) std::ranges::sort(rows);
  std::erase_if(strata, [](const Rows& rows) { return rows.empty(); });
  return strata;
}

/// At most kMostObservations of them, evenly spread.
Rows thinned(const Rows& rows) {
  const auto count = static_cast<Index>(rows.size());
  if (count <= kMostObservations) return rows;
  Rows result;
  for (Index k = 0; k < kMostObservations; ++k) {
    result.push_back(rows[static_cast<std::size_t>(k * count / kMostObservations)]);
  }
  return result;
}

}  // namespace

bool is_doubtful_start(const NonlinearModel& model, const VectorXd& pooled) {
  if (model.is_linear()) return false;
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  Eigen::MatrixXd jacobian;
  model.evaluate(pooled, mean, &jacobian, workspace);
  const Index freedom = model.observations() - pooled.size();
  if (!jacobian.allFinite() || freedom <= 0) return true;
  const double variance = (model.response() - mean).squaredNorm() / static_cast<double>(freedom);
  const VectorXd sizes = jacobian.colwise().norm();
  if (!(sizes.minCoeff() > 0.0)) return true;
  const Eigen::MatrixXd scaled = jacobian * sizes.cwiseInverse().asDiagonal();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver(scaled);
  if (solver.rank() < pooled.size()) return true;
  const Eigen::LLT<Eigen::MatrixXd> information(scaled.transpose() * scaled);
  if (information.info() != Eigen::Success) return true;
  const Eigen::MatrixXd inverse =
      information.solve(Eigen::MatrixXd::Identity(pooled.size(), pooled.size()));
  const VectorXd errors = (variance * inverse.diagonal()).cwiseSqrt().cwiseQuotient(sizes);
  // Coefficients of covariates are often near zero, which is harmless.
  constexpr double kFewErrors = 2.0;
  for (Index j = 0; j < pooled.size(); ++j) {
    const bool is_far = std::abs(pooled[j]) >= kFewErrors * errors[j];
    if (model.multiplier_values(j) == nullptr && !is_far) return true;
  }
  return false;
}

std::optional<VectorXd> start_of_strata(const NonlinearModel& model, const VectorXd& pooled) {
  const Index p = model.coefficient_count();
  const Index each = std::max<Index>(8, 2 * p + 2);
  const Index count = std::min({kMostStrata, model.group_count(), model.observations() / each});
  if (count < kFewestStrata) return std::nullopt;
  const std::vector<Rows> strata = strata_of(model, pooled, count);
  std::vector<std::vector<double>> values(static_cast<std::size_t>(p));
  for (const Rows& rows : strata) {
    const LeastSquaresFit fit = fit_least_squares(model.subset(thinned(rows)));
    if (!fit.convergence.converged() || !fit.estimate.allFinite()) continue;
    for (Index j = 0; j < p; ++j) values[static_cast<std::size_t>(j)].push_back(fit.estimate[j]);
  }
  if (2 * values.front().size() < strata.size()) return std::nullopt;
  return medians(std::move(values));
}

}  // namespace silvafit::fit
