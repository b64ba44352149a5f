// SPDX-License-Identifier: MIT
// Quantiles of mixtures of normal distributions.
#pragma once

#include <vector>

#include "silvafit/base/constants.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// A mixture of normal distributions with means m_k, standard deviations s_k > 0 and weights w_k >=
/// 0. Components that are not finite are left out.
class NormalMixture {
 public:
  using Values = Eigen::Ref<const VectorXd>;
  /// \param least_tail  the smallest probability on one side that quantiles are asked for
  NormalMixture(const Values& means,
                const Values& deviations,
                const Values& weights,
                double least_tail);
  /// A mixture of no components, for assign().
  NormalMixture() = default;
  /// Replaces the mixture, using the same memory.
  void assign(const Values& means,
              const Values& deviations,
              const Values& weights,
              double least_tail);
  /// The value below which the mixture has the given probability; NaN if no component is left.
  double quantile(double probability) const;

 private:
  struct Distribution;
  Distribution at(double y) const;

  std::vector<double> means_{};
  std::vector<double> inverses_{};  ///< of standard deviations
  std::vector<double> weights_{};   ///< their sum is 1
  double low_ = kInfinity;          ///< all quantiles are between these
  double high_ = -kInfinity;
  double center_ = 0.0;
  double deviation_ = 0.0;
  double skewness_ = 0.0;         ///< at most 1 in size
  double narrowest_ = kInfinity;  ///< smallest standard deviation
};

}  // namespace silvafit::fit
