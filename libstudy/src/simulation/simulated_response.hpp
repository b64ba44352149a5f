// SPDX-License-Identifier: MIT
// The responses of one species' trees: conditional means and residual standard deviations.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "silvafit/base/random.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/study/simulate.hpp"

namespace silvafit::study {

/// Data columns by name, all of the same length, one value a tree.
using Columns = std::map<std::string, std::vector<double>>;

/// One response of one species, with its random effects drawn.
class SimulatedResponse {
 public:
  /// \param plot_of_tree  (n) index of the plot of each of the species' trees
  SimulatedResponse(const ResponseDesign& design,
                    std::size_t plots,
                    const std::vector<std::size_t>& plot_of_tree,
                    Random& random);

  /// The conditional mean of each tree.
  /// \throws DomainError if one is not finite
  std::vector<double> means(const Columns& columns) const;

  /// Residual standard deviation over sigma of each tree, g(v).
  std::vector<double> relative_spread(const std::vector<double>& means,
                                      const Columns& columns) const;

  /// Sigma of the design, or the value that gives the requested root mean square of sigma g(v).
  double sigma(const std::vector<double>& relative_spread) const;

  const Eigen::MatrixXd& random_effects() const { return random_effects_; }

 private:
  const ResponseDesign* design_;
  Eigen::MatrixXd random_effects_;                 ///< (plots x q)
  std::vector<std::vector<double>> coefficients_;  ///< (p) lists of n
  std::vector<std::string> variables_;             ///< data columns of the mean
  data::Program program_;
};

}  // namespace silvafit::study
