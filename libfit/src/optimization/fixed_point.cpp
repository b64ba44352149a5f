// SPDX-License-Identifier: MIT
#include "optimization/fixed_point.hpp"

#include <Eigen/QR>

namespace silvafit::fit {

void AndersonMixing::restart() {
  image_changes_.clear();
  residual_changes_.clear();
  last_image_.resize(0);
  last_residual_.resize(0);
}

VectorXd AndersonMixing::next(const VectorXd& x, const VectorXd& image) {
  const VectorXd residual = image - x;
  if (last_residual_.size() > 0) {
    image_changes_.push_back(image - last_image_);
    residual_changes_.push_back(residual - last_residual_);
    if (image_changes_.size() > memory_) {
      image_changes_.pop_front();
      residual_changes_.pop_front();
    }
  }
  last_image_ = image;
  last_residual_ = residual;
  const auto count = static_cast<Index>(residual_changes_.size());
  if (count == 0) return image;
  MatrixXd changes(x.size(), count);
  MatrixXd images(x.size(), count);
  for (Index k = 0; k < count; ++k) {
    changes.col(k) = residual_changes_[static_cast<std::size_t>(k)];
    images.col(k) = image_changes_[static_cast<std::size_t>(k)];
  }
  Eigen::ColPivHouseholderQR<MatrixXd> solver(changes);
  solver.setThreshold(1e-8);
  return image - images * solver.solve(residual);
}

}  // namespace silvafit::fit
