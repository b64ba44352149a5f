// SPDX-License-Identifier: MIT
// Running mean and standard deviation, with weights.
#pragma once

#include <cmath>
#include <cstddef>

#include "silvafit/data/table.hpp"

namespace silvafit::stand {

/// Welford's recurrence, which loses no digits if the mean is large (with weights: West 1979).
/// Missing values, and those without weight, are skipped.
class Moments {
 public:
  /// \param weight  0 or more; the unit of weights does not matter
  void add(double value, double weight = 1.0) {
    if (std::isnan(value) || weight == 0.0) return;
    ++count_;
    weights_ += weight;
    const double deviation = value - mean_;
    mean_ += deviation * weight / weights_;
    squares_ += weight * deviation * (value - mean_);
  }

  /// NaN without values.
  double mean() const { return count_ > 0 ? mean_ : data::kMissing; }
  /// With n - 1; NaN for fewer than two values. With weights the divisor is their sum times
  /// (n - 1) / n, which is n - 1 for equal weights.
  double standard_deviation() const {
    if (count_ < 2) return data::kMissing;
    const auto n = static_cast<double>(count_);
    return std::sqrt(squares_ / (weights_ * (n - 1.0) / n));
  }

 private:
  std::size_t count_ = 0;
  double weights_ = 0.0;
  double mean_ = 0.0;
  double squares_ = 0.0;
};

}  // namespace silvafit::stand
