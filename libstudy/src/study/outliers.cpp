// SPDX-License-Identifier: MIT
#include "study/outliers.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <boost/math/special_functions/beta.hpp>
#include <cmath>
#include <functional>

#include "silvafit/base/median.hpp"

namespace silvafit::study {
namespace {

constexpr double kOutlierSignificance = 0.05;
/// Eigenvalues of a correlation matrix, or of a fraction of it, below this are treated as zero.
constexpr double kZero = 1e-6;

/// (r x q) maps random effects to r uncorrelated ones of unit variance; r < q if Psi is
/// singular.
Eigen::MatrixXd whitening(const Eigen::MatrixXd& psi) {
  const Eigen::VectorXd sd = psi.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd scale = (sd.array() > 0.0).select(sd.cwiseInverse(), 0.0);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scale.asDiagonal() * psi *
                                                              scale.asDiagonal());
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < sd.size(); ++k) {
    if (solver.eigenvalues()[k] > kZero) kept.push_back(k);
  }
  const Eigen::MatrixXd vectors = solver.eigenvectors()(Eigen::all, kept);
  const Eigen::VectorXd roots = solver.eigenvalues()(kept).cwiseSqrt();
  return roots.cwiseInverse().asDiagonal() * vectors.transpose() * scale.asDiagonal();
}

/// The symmetric inverse root; directions without information from the data are zero.
Eigen::MatrixXd inverse_root(const Eigen::MatrixXd& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance);
  const Eigen::VectorXd& values = solver.eigenvalues();
  const Eigen::VectorXd roots =
      (values.array() > kZero).select(values.cwiseMax(kZero).cwiseSqrt().cwiseInverse(), 0.0);
  return solver.eigenvectors() * roots.asDiagonal() * solver.eigenvectors().transpose();
}

/// (r x G) EBLUPs with unit covariance under the model.
Eigen::MatrixXd standardized_effects(const fit::EstimatedEffects& term) {
  const Eigen::MatrixXd whiten = whitening(term.covariance);
  Eigen::MatrixXd effects = whiten * term.effects;
  if (!term.uncertainty.is_known()) return effects;
  const Eigen::Index q = term.effects.rows();
  for (Eigen::Index plot = 0; plot < effects.cols(); ++plot) {
    const Eigen::MatrixXd conditional =
        whiten * term.uncertainty.covariance(plot, q) * whiten.transpose();
    const Eigen::MatrixXd own =
        Eigen::MatrixXd::Identity(effects.rows(), effects.rows()) - conditional;
    effects.col(plot) = inverse_root(own) * effects.col(plot);
  }
  return effects;
}

}  // namespace

std::vector<PlotDistance> plot_distances(const fit::FittedModel& fit) {
  std::vector<PlotDistance> result;
  for (const std::string& plot : fit.random.front().labels) result.push_back({.plot = plot});
  const Eigen::MatrixXd effects = standardized_effects(fit.random.front());
  const auto r = static_cast<double>(effects.rows());
  const auto plots = static_cast<double>(effects.cols());
  const double freedom = plots - r - 1.0;
  if (r < 1.0 || freedom < 1.0) return result;
  const Eigen::MatrixXd centered = effects.colwise() - effects.rowwise().mean();
  const Eigen::LDLT<Eigen::MatrixXd> scatter(centered * centered.transpose());
  for (Eigen::Index k = 0; k < effects.cols(); ++k) {
    const double share = centered.col(k).dot(scatter.solve(centered.col(k)));
    // The determinant of the scatter matrix without the plot, divided by that of all plots.
    const double ratio = std::clamp(1.0 - plots / (plots - 1.0) * share, 0.0, 1.0);
    PlotDistance& plot = result[static_cast<std::size_t>(k)];
    plot.distance = std::sqrt(freedom * (1.0 - ratio) / ratio);
    plot.p = std::min(1.0, plots * boost::math::ibeta(freedom / 2.0, r / 2.0, ratio));
  }
  return result;
}

std::vector<PlotDistance> outlying_plots(const fit::FittedModel& fit) {
  std::vector<PlotDistance> plots = plot_distances(fit);
  std::erase_if(plots, [](const PlotDistance& plot) { return !(plot.p < kOutlierSignificance); });
  std::ranges::stable_sort(plots, {}, &PlotDistance::p);
  return plots;
}

std::string outlying_sentence(const std::vector<PlotDistance>& plots, const std::string& group) {
  if (plots.empty()) return "";
  std::vector<std::string> names;
  for (const PlotDistance& plot : plots) {
    constexpr double kSmallestP = 0.001;
    names.push_back(fmt::format("{} (distance {:.1f}, p {})",
                                plot.plot,
                                plot.distance,
                                plot.p < kSmallestP ? "< 0.001" : fmt::format("= {:.3f}", plot.p)));
  }
  return fmt::format(
      "Outlying {}{}: {}. The random effects lie farther from those of the other {}s than chance "
      "explains. Check the measurements there.",
      group,
      plots.size() > 1 ? "s" : "",
      fmt::join(names, ", "),
      group);
}

using Eigen::Index;
using Eigen::VectorXd;

OutlyingTrees outlying_trees(const VectorXd& standardized) {
  OutlyingTrees result;
  if (standardized.size() == 0 || !standardized.allFinite()) return result;
  constexpr double kFar = 8.0;
  // The upper quartile of the standard normal distribution.
  constexpr double kQuartile = 0.674489750196082;
  const VectorXd sizes = standardized.cwiseAbs();
  const double scale = median({sizes.begin(), sizes.end()}) / kQuartile;
  if (!(scale > 0.0)) return result;
  for (Index i = 0; i < sizes.size(); ++i) {
    if (sizes[i] > kFar * scale) result.observations.push_back(i);
  }
  std::ranges::stable_sort(
      result.observations, std::greater<>(), [&](Index i) { return sizes[i]; });
  double sum = 0.0;
  for (const Index i : result.observations) {
    result.distances.push_back(sizes[i] / scale);
    sum += sizes[i] * sizes[i];
  }
  result.share = sum / sizes.squaredNorm();
  return result;
}

}  // namespace silvafit::study
