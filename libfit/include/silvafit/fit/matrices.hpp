// SPDX-License-Identifier: MIT
// The matrices and vectors of the library.
#pragma once

#include <Eigen/Core>

namespace silvafit::fit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

}  // namespace silvafit::fit
