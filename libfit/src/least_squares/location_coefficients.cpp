// SPDX-License-Identifier: MIT
#include "least_squares/location_coefficients.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <string>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/random.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;

/// Slopes of the formula by a column and by each parameter, at arbitrary values of all of them: an
/// identity of the formula holds there as at the data, but without the rounding of very small
/// slopes.
class Slopes {
 public:
  /// \param is_one_curve  whether the parameters are the same at all points
  explicit Slopes(const NonlinearModel& model, bool is_one_curve = false)
      : formula_(model.specification().formula.right) {
    for (const ParameterModel& parameter : model.specification().parameters) {
      names_.push_back(parameter.name);
    }
    parameters_ = static_cast<Index>(names_.size());
    for (const std::string& name : formula_.variables()) {
      if (std::ranges::find(names_, name) == names_.end()) names_.push_back(name);
    }
    points_.resize(kPoints, static_cast<Index>(names_.size()));
    constexpr std::uint64_t kSeed = 3;
    Random random(kSeed, 0);
    for (double& value : points_.reshaped()) value = random.uniform(0.5, 1.5);
    for (Index k = 0; k < parameters_ && is_one_curve; ++k)
      points_.col(k).setConstant(points_(0, k));
    by_parameters_.resize(kPoints, parameters_);
    for (Index k = 0; k < parameters_; ++k) {
      by_parameters_.col(k) = by(names_[static_cast<std::size_t>(k)]);
    }
  }

  Index parameters() const { return parameters_; }
  /// Names of the columns.
  std::vector<std::string> columns() const { return {names_.begin() + parameters_, names_.end()}; }

  /// The shifts of the parameters that compensate a shift by 1 of a column, or of its logarithm;
  /// empty if there are none.
  VectorXd shifts(const std::string& column, bool is_logarithm) const {
    VectorXd slope = by(column);
    if (is_logarithm) {
      const auto place = std::ranges::find(names_, column) - names_.begin();
      slope = slope.cwiseProduct(points_.col(place));
    }
    if (!slope.allFinite() || !by_parameters_.allFinite() || slope.isZero(0.0)) return {};
    const VectorXd result = by_parameters_.colPivHouseholderQr().solve(-slope);
    if (!is_sum(result, slope)) return {};
    // Other slopes of the mean may be equal by chance; a shift is 0 or one unit.
    const bool is_shift = std::ranges::all_of(result, [&](double value) {
      return std::abs(value - std::round(value)) < 1e-6 && std::abs(value) < 1.5;
    });
    return is_shift ? VectorXd(result.array().round()) : VectorXd();
  }

  /// Whether changes of the parameters compensate a shift of a column.
  bool are_compensating(const std::string& column) const {
    const VectorXd slope = by(column);
    if (!slope.allFinite() || !by_parameters_.allFinite() || 2 * parameters_ > kPoints)
      return false;
    return !slope.isZero(0.0) && is_sum(by_parameters_.colPivHouseholderQr().solve(-slope), slope);
  }

 private:
  static constexpr Index kPoints = 24;

  bool is_sum(const VectorXd& changes, const VectorXd& slope) const {
    constexpr double kRounding = 1e-7;
    return (by_parameters_ * changes + slope).norm() <= kRounding * slope.norm();
  }

  VectorXd by(const std::string& name) const {
    const Expression slope = formula_.derivative(name);
    VectorXd result(kPoints);
    std::vector<double> values(names_.size());
    for (Index i = 0; i < kPoints; ++i) {
      for (std::size_t k = 0; k < names_.size(); ++k) values[k] = points_(i, static_cast<Index>(k));
      result[i] = slope.value(names_, values);
    }
    return result;
  }

  Expression formula_;
  std::vector<std::string> names_;  ///< parameters, then columns
  Index parameters_ = 0;
  MatrixXd points_;
  MatrixXd by_parameters_;
};

}  // namespace

std::vector<LocationCoefficient> location_coefficients(const NonlinearModel& model) {
  std::vector<LocationCoefficient> result;
  const Slopes slopes(model);
  for (const std::string& column : slopes.columns()) {
    const VectorXd values = model.column(column);
    double lowest_positive = kInfinity;
    for (const double value : values) {
      if (value > 0.0) lowest_positive = std::min(lowest_positive, value);
    }
    for (const bool is_logarithm : {false, true}) {
      if (is_logarithm && !(lowest_positive < values.maxCoeff())) continue;
      const VectorXd shifts = slopes.shifts(column, is_logarithm);
      const double low = is_logarithm ? std::log(lowest_positive) : values.minCoeff();
      const double high = is_logarithm ? std::log(values.maxCoeff()) : values.maxCoeff();
      if (!(high > low)) continue;
      for (Index k = 0; k < shifts.size(); ++k) {
        if (shifts[k] == 0.0) continue;
        const bool is_known = std::ranges::any_of(
            result, [&](const LocationCoefficient& known) { return known.coefficient == k; });
        if (is_known) continue;
        result.push_back({.coefficient = k,
                          .lowest = shifts[k] > 0.0 ? low : -high,
                          .highest = shifts[k] > 0.0 ? high : -low});
      }
    }
  }
  return result;
}

std::vector<FarColumn> far_columns(const NonlinearModel& model) {
  std::vector<FarColumn> result;
  const Slopes slopes(model, true);
  for (const std::string& column : slopes.columns()) {
    const VectorXd values = model.column(column);
    const double range = values.maxCoeff() - values.minCoeff();
    const double middle = 0.5 * (values.maxCoeff() + values.minCoeff());
    const bool is_far = range > 0.0 && std::abs(middle) > kFarFromZero * range;
    if (is_far && slopes.are_compensating(column)) result.push_back({column, middle});
  }
  return result;
}

}  // namespace silvafit::fit
