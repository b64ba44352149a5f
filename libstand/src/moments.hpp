// SPDX-License-Identifier: MIT
// Running mean and standard deviation.
#pragma once

#include <cmath>
#include <cstddef>

#include "silvafit/data/table.hpp"

namespace silvafit::stand {

/// Welford's recurrence, which loses no digits if the mean is large. Missing values are
/// skipped.
class Moments {
 public:
  void add(double value) {
    if (std::isnan(value)) return;
    ++count_;
    const double deviation = value - mean_;
    mean_ += deviation / static_cast<double>(count_);
    squares_ += deviation * (value - mean_);
  }

  /// NaN without values.
  double mean() const { return count_ > 0 ? mean_ : data::kMissing; }
  /// With n - 1; NaN for fewer than two values.
  double standard_deviation() const {
    return count_ > 1 ? std::sqrt(squares_ / static_cast<double>(count_ - 1)) : data::kMissing;
  }

 private:
  std::size_t count_ = 0;
  double mean_ = 0.0;
  double squares_ = 0.0;
};

}  // namespace silvafit::stand
