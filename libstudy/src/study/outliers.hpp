// SPDX-License-Identifier: MIT
// Trees and plots that are far from the others.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::study {

/// The outliers among the residuals of a model.
struct OutlyingTrees {
  std::vector<Eigen::Index> observations{};  ///< the farthest first
  std::vector<double> distances{};  ///< of each, in robust standard deviations of all residuals
  /// Their part of the sum of the squared standardized residuals.
  double share = 0.0;
};

/// The trees more than 8 robust standard deviations from zero. The scale is the median absolute
/// residual divided by 0.6745, which equals the standard deviation of a normal distribution and
/// which up to half of the residuals cannot inflate. Of normal residuals none in 1e14 is so far
/// away, of t-distributed ones with 5 degrees of freedom one in 3,000.
/// Source of the scale: Hampel 1974, J. Am. Stat. Assoc. 69, 383-393 (median deviation).
/// \param standardized  (N) residuals divided by their standard deviation
OutlyingTrees outlying_trees(const Eigen::VectorXd& standardized);

/// The distance of a plot's random effects from those of all other plots.
struct PlotDistance {
  std::string plot{};
  /// Standardized effects against the mean and covariance of those of the other plots; with one
  /// effect its studentized deviation. NaN if there are too few plots.
  double distance = std::numeric_limits<double>::quiet_NaN();
  /// The p-value of so large a distance in any of the plots (Bonferroni).
  double p = std::numeric_limits<double>::quiet_NaN();
};

/// The distances of all plots, in the order of the fit's groups, the coarser of two groupings.
///
/// The EBLUPs of a plot are standardized by their covariance Psi - V, V the conditional covariance
/// given the plot's trees. Directions without variance in Psi are left out. Each plot is left out
/// in turn and compared with the others, so that a variance which it inflates does not mask it.
/// Sources: Waternaux, Laird and Ware 1989, J. Am. Stat. Assoc. 84, 33-41 (standardized EBLUPs);
/// Wilks 1963, Sankhya A 25, 407-426 (a multivariate outlier left out).
/// \param fit  with random effects
std::vector<PlotDistance> plot_distances(const fit::FittedModel& fit);

/// The plots with p below 0.05, the farthest first.
std::vector<PlotDistance> outlying_plots(const fit::FittedModel& fit);

/// "Plot 2 is outlying: ...", for one plot or several; empty for none.
std::string outlying_sentence(const std::vector<PlotDistance>& plots, const std::string& group);

}  // namespace silvafit::study
