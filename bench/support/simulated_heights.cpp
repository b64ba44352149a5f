// SPDX-License-Identifier: MIT
#include "simulated_heights.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "silvafit/base/random.hpp"

namespace silvafit::bench {
namespace {

Eigen::Matrix3d covariance(const Eigen::Vector3d& sd, double ab, double ac, double bc) {
  Eigen::Matrix3d correlation;
  correlation << 1.0, ab, ac, ab, 1.0, bc, ac, bc, 1.0;
  // Printed correlations may contradict each other in their last digit.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(correlation);
  const Eigen::Matrix3d lifted = eigen.eigenvectors() *
                                 eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
                                 eigen.eigenvectors().transpose();
  const Eigen::Vector3d scale = sd.cwiseQuotient(lifted.diagonal().cwiseSqrt());
  return scale.asDiagonal() * lifted * scale.asDiagonal();
}

/// A square root of a covariance that may be singular.
Eigen::Matrix3d root(const Eigen::Matrix3d& psi) {
  // Scaled to correlations first: the variances differ by five orders of magnitude.
  const Eigen::Vector3d sd = psi.diagonal().cwiseSqrt();
  const Eigen::Vector3d inverse = (sd.array() > 0.0).select(sd.cwiseInverse(), 0.0);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(inverse.asDiagonal() * psi *
                                                             inverse.asDiagonal());
  return sd.asDiagonal() * eigen.eigenvectors() *
         eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

/// The coefficients of a plot.
Eigen::Vector3d draw_coefficients(const HeightTruth& truth,
                                  const Eigen::Matrix3d& factor,
                                  Random& random) {
  for (;;) {
    Eigen::Vector3d z;
    for (double& value : z) value = random.normal();
    const Eigen::Vector3d drawn = truth.fixed + factor * z;
    if (std::min(drawn[1], drawn[1] + drawn[2]) >= truth.least_rate) return drawn;
  }
}

}  // namespace

HeightTruth HeightTruth::ordinary(bool has_power) {
  HeightTruth truth;
  truth.psi = covariance({2.0, 0.004, 0.0}, -0.5, 0.0, 0.0);
  if (has_power) {
    truth.sigma = 0.25;
    truth.delta = 0.6;
  }
  return truth;
}

HeightTruth HeightTruth::near_singular() {
  HeightTruth truth;
  truth.fixed = {36.7543, 0.0236, 0.0045};
  truth.psi =
      covariance({std::sqrt(4.99), std::sqrt(7.51e-5), std::sqrt(2.90e-5)}, -0.986, -0.883, 0.947);
  truth.sigma = 2.2;
  truth.mean_dbh = 24.86;
  truth.sd_dbh = 8.91;
  return truth;
}

data::Table simulated_heights(const HeightTruth& truth,
                              std::size_t plots,
                              std::size_t smallest,
                              std::size_t largest,
                              std::uint64_t seed,
                              std::uint64_t stream) {
  Random random(seed, stream);
  const Eigen::Matrix3d factor = root(truth.psi);
  const double scale = truth.sd_dbh * truth.sd_dbh / (truth.mean_dbh - 5.0);
  const double shape = (truth.mean_dbh - 5.0) / scale;
  data::TextColumn plot;
  std::vector<double> crowding;
  std::vector<double> dbh;
  std::vector<double> height;
  for (std::size_t p = 0; p < plots; ++p) {
    const Eigen::Vector3d coefficients = draw_coefficients(truth, factor, random);
    const std::size_t trees = smallest + random.below(largest - smallest + 1);
    for (std::size_t i = 0; i < trees; ++i) {
      const double c = 0.25 * static_cast<double>(random.below(5));
      const double d = std::round(10.0 * (5.0 + random.gamma(shape, scale))) / 10.0;
      const double rate = coefficients[1] + coefficients[2] * c;
      const double mean = 1.3 + coefficients[0] * (1.0 - std::exp(-rate * d));
      plot.append("P" + std::to_string(p + 1));
      crowding.push_back(c);
      dbh.push_back(d);
      height.push_back(random.normal(mean, truth.sigma * std::pow(std::abs(mean), truth.delta)));
    }
  }
  data::Table table;
  table.set("plot", plot);
  table.set("C", crowding);
  table.set("D", dbh);
  table.set("H", height);
  return table;
}

fit::ModelSpecification height_model(const std::string& random,
                                     const std::string& variance,
                                     const data::Table& table) {
  fit::ModelSpecification model =
      fit::specify_model("H ~ 1.3 + a*(1 - exp(-b*D))", {"b ~ 1 + C"}, table);
  fit::add_random_effects(model, random, table);
  model.variance = fit::parse_variance_function(variance);
  return model;
}

}  // namespace silvafit::bench
