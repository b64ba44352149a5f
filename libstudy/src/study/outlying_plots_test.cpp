// SPDX-License-Identifier: MIT
// Distances of plots against formulas for a left-out plot in another form.
#include <Eigen/LU>
#include <boost/math/distributions/fisher_f.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "study/outliers.hpp"

using namespace silvafit;
using namespace silvafit::study;

namespace {

/// A mixed model with given effects that the plots' trees determine exactly.
fit::FittedModel mixed_model(const Eigen::MatrixXd& psi, const Eigen::MatrixXd& effects) {
  fit::FittedModel model({.formula = data::parse_formula("h ~ 1.3 + a*dbh^b")});
  model.random.resize(1);
  for (Eigen::Index k = 0; k < effects.rows(); ++k) {
    model.random.back().names.push_back(std::string(1, static_cast<char>('a' + k)));
  }
  for (Eigen::Index plot = 0; plot < effects.cols(); ++plot) {
    model.random.back().labels.push_back(std::to_string(plot + 1));
  }
  model.random.back().covariance = psi;
  model.random.back().effects = effects;
  return model;
}

/// Hotelling's statistic of a plot against the others, by their mean and covariance.
double hotelling(const Eigen::MatrixXd& effects, Eigen::Index plot) {
  Eigen::MatrixXd others(effects.rows(), effects.cols() - 1);
  others << effects.leftCols(plot), effects.rightCols(effects.cols() - 1 - plot);
  const Eigen::VectorXd mean = others.rowwise().mean();
  const Eigen::MatrixXd centered = others.colwise() - mean;
  const auto n = static_cast<double>(others.cols());
  const Eigen::MatrixXd covariance = centered * centered.transpose() / (n - 1.0);
  const Eigen::VectorXd difference = effects.col(plot) - mean;
  return difference.dot(covariance.inverse() * difference) / (1.0 + 1.0 / n);
}

}  // namespace

TEST_CASE("with one random effect the distance is the studentized deviation of the plot") {
  Eigen::MatrixXd effects(1, 6);
  effects << 0.3, 5.0, -0.4, 0.1, -0.2, 0.5;
  const auto plots = plot_distances(mixed_model(Eigen::MatrixXd::Constant(1, 1, 4.0), effects));
  REQUIRE(plots.size() == 6);
  const boost::math::fisher_f_distribution<double> f(1.0, 4.0);
  for (Eigen::Index plot = 0; plot < 6; ++plot) {
    const double expected = hotelling(effects, plot);
    const PlotDistance& found = plots[static_cast<std::size_t>(plot)];
    // The same numbers computed in another way: rounding only.
    CHECK(found.distance == Approx(std::sqrt(expected)).epsilon(1e-10));
    CHECK(found.p ==
          Approx(std::min(1.0, 6.0 * boost::math::cdf(boost::math::complement(f, expected))))
              .epsilon(1e-8));
  }
  const auto outlying = outlying_plots(mixed_model(Eigen::MatrixXd::Constant(1, 1, 4.0), effects));
  REQUIRE(outlying.size() == 1);
  CHECK(outlying.front().plot == "2");
}

TEST_CASE("with two effects it is Hotelling's statistic, in any units of the effects") {
  Eigen::MatrixXd effects(2, 9);
  effects << 1.0, -0.5, 0.3, -1.2, 0.8, 0.1, -0.6, 0.4, -0.3,  //
      0.4, -0.1, 0.5, -0.9, 0.2, -0.3, 2.5, 0.3, -0.4;
  Eigen::MatrixXd psi(2, 2);
  psi << 0.7, 0.2, 0.2, 0.9;
  const auto plots = plot_distances(mixed_model(psi, effects));
  const boost::math::fisher_f_distribution<double> f(2.0, 6.0);
  for (Eigen::Index plot = 0; plot < 9; ++plot) {
    // T^2 (n - 1 - r) / (n - 2) = r F with n = 9 plots.
    const double expected = hotelling(effects, plot) * 6.0 / 7.0;
    const PlotDistance& found = plots[static_cast<std::size_t>(plot)];
    CHECK(found.distance == Approx(std::sqrt(expected)).epsilon(1e-10));
    const double p = boost::math::cdf(boost::math::complement(f, expected / 2.0));
    CHECK(found.p == Approx(std::min(1.0, 9.0 * p)).epsilon(1e-8));
  }
  const Eigen::Vector2d unit(1.0, 1e-4);
  const auto scaled = plot_distances(
      mixed_model(unit.asDiagonal() * psi * unit.asDiagonal(), unit.asDiagonal() * effects));
  for (std::size_t k = 0; k < plots.size(); ++k) {
    CHECK(scaled[k].distance == Approx(plots[k].distance).epsilon(1e-8));
  }
}

TEST_CASE("effects with a correlation of one count as one effect") {
  Eigen::MatrixXd effects(2, 6);
  effects << 0.3, 5.0, -0.4, 0.1, -0.2, 0.5, 0.6, 10.0, -0.8, 0.2, -0.4, 1.0;
  Eigen::MatrixXd psi(2, 2);
  psi << 1.0, 2.0, 2.0, 4.0;
  const auto both = plot_distances(mixed_model(psi, effects));
  const auto one =
      plot_distances(mixed_model(Eigen::MatrixXd::Constant(1, 1, 1.0), effects.topRows(1)));
  for (std::size_t k = 0; k < one.size(); ++k) {
    CHECK(both[k].distance == Approx(one[k].distance).epsilon(1e-8));
  }
}

TEST_CASE("standardization removes the shrinkage of a plot with few trees") {
  Eigen::MatrixXd effects(1, 6);
  effects << 1.0, -1.0, 0.8, -0.9, 0.7, 0.6;
  fit::FittedModel model = mixed_model(Eigen::MatrixXd::Constant(1, 1, 1.0), effects);
  const double before = plot_distances(model).back().distance;
  // The last plot has 0.91 of the variance left: its standardized effect is 0.6 / 0.3.
  model.random.back().uncertainty.covariances = Eigen::MatrixXd::Zero(1, 6);
  model.random.back().uncertainty.covariances(0, 5) = 0.91;
  const double after = plot_distances(model).back().distance;
  effects(0, 5) = 2.0;
  CHECK(after == Approx(std::sqrt(hotelling(effects, 5))).epsilon(1e-8));
  CHECK(after > before);
}

TEST_CASE("few plots give no distance, and the sentence has the plots with distance and p") {
  Eigen::MatrixXd effects(1, 2);
  effects << 1.0, -1.0;
  const fit::FittedModel model = mixed_model(Eigen::MatrixXd::Constant(1, 1, 1.0), effects);
  CHECK(std::isnan(plot_distances(model).front().distance));
  CHECK(outlying_plots(model).empty());
  CHECK(outlying_sentence({}, "plot").empty());
  CHECK(outlying_sentence({{.plot = "2", .distance = 7.123, .p = 0.0004}}, "plot") ==
        "Outlying plot: 2 (distance 7.1, p < 0.001). The random effects lie farther from those of "
        "the other plots than chance explains. Check the measurements there.");
}
