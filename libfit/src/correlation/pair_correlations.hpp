// SPDX-License-Identifier: MIT
// The correlations of the structures, and the transformations of their parameters.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "correlation/correlation_structure.hpp"

namespace silvafit::fit {

std::unique_ptr<PairCorrelation> first_order(double phi, double by_parameter);
/// exp(-d/range) and the other functions of d/range, with a nugget between 0 and 1, NaN for none.
/// The parameters are the logarithm of the range and the logit of the nugget.
/// \param is_free  whether the range moves with its parameter
std::unique_ptr<PairCorrelation> by_distance(Correlation::Kind kind,
                                             double range,
                                             double nugget,
                                             bool is_free);
/// \param low  the lower limit of rho
std::unique_ptr<PairCorrelation> compound_symmetry(double rho, double low);
/// \param parameters  (p + q) Fisher's z, doubled, of partial autocorrelations
/// \param longest     lag that is needed
/// Source: Monahan 1984, Biometrika 71:403-404.
std::unique_ptr<PairCorrelation> moving_average(const Correlation& correlation,
                                                const Eigen::VectorXd& parameters,
                                                Eigen::Index longest);
/// \param parameters  logits of the angles of the rows of L, as shares of pi
/// Source: Pinheiro and Bates 1996, Statistics and Computing 6:289-296, spherical parametrization.
std::unique_ptr<PairCorrelation> symmetric(Eigen::Index times, const Eigen::VectorXd& parameters);

/// The coefficients phi and theta of an ARMA process from its parameters, and back.
Eigen::VectorXd arma_coefficients(const Correlation& correlation,
                                  const Eigen::VectorXd& parameters);
Eigen::VectorXd arma_parameters(const Correlation& correlation,
                                const Eigen::VectorXd& coefficients);
/// The correlations of a symmetric structure by rows of the upper triangle, and back.
Eigen::VectorXd symmetric_correlations(Eigen::Index times, const Eigen::VectorXd& parameters);
Eigen::VectorXd symmetric_parameters(Eigen::Index times, const Eigen::VectorXd& correlations);

}  // namespace silvafit::fit
