// SPDX-License-Identifier: MIT
// Quantiles of mixtures of normal distributions.
#pragma once

#include <Eigen/Core>

namespace silvafit::fit {

/// The value below which a mixture has the given probability: of normal distributions with means
/// m_k, standard deviations s_k > 0 and weights w_k >= 0. Components that are not finite are left
/// out. NaN if none is left.
double mixture_quantile(const Eigen::Ref<const Eigen::VectorXd>& means,
                        const Eigen::Ref<const Eigen::VectorXd>& deviations,
                        const Eigen::Ref<const Eigen::VectorXd>& weights,
                        double probability);

}  // namespace silvafit::fit
