// SPDX-License-Identifier: MIT
#include "prediction/value_quantiles.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "prediction/mixture_quantile.hpp"
#include "prediction/nonlinear_directions.hpp"
#include "prediction/prediction_rules.hpp"
#include "prediction/residual_spread.hpp"
#include "prediction/row_mean.hpp"
#include "prediction/smooth_mixture.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

using Rows = std::vector<std::size_t>;

// If the outer of three points change the mean by less, in standard deviations of the prediction,
// three points are sufficient.
constexpr double kSmallMove = 0.15;
// Numbers at a time that a step may keep: 8 MB.
constexpr std::size_t kNumbersAtOnce = std::size_t{1} << 20U;

/// Some rows of the table with their means.
class Part {
 public:
  /// \param directions  of all rows, or none; those of a part have the same number of columns
  Part(const UnknownValues& all,
       const Rows& rows,
       const std::vector<NonlinearDirections>& directions)
      : fit_(all.fit),
        table_(all.table.select(rows)),
        mean_(all.fit.specification, table_, all.uncertain),
        center_(all.arguments(rows, Eigen::all)),
        follows_mean_(residual_follows_mean(all.fit)) {
    const bool has_none = rows.empty() || directions.empty();
    const Index width = has_none ? 0 : directions[rows.front()].root.cols();
    for (Index direction = 0; direction < width; ++direction) {
      MatrixXd& of_rows = roots_.emplace_back(center_.rows(), center_.cols());
      for (std::size_t k = 0; k < rows.size(); ++k) {
        of_rows.row(static_cast<Index>(k)) = directions[rows[k]].root.col(direction).transpose();
      }
    }
    // The same for any mean.
    if (!follows_mean_) {
      residual_ = residual_sd_if_known(fit_, VectorXd::Ones(center_.rows()), table_);
    }
  }

  const RowMean& mean() const { return mean_; }
  const MatrixXd& center() const { return center_; }

  /// (n) means away from the center, and the standard deviations of the values there.
  /// \param steps  (q) along the directions, in standard deviations
  VectorXd mean_at(const Eigen::Ref<const VectorXd>& steps) const {
    MatrixXd at = center_;
    for (Index k = 0; k < steps.size(); ++k) {
      if (steps[k] != 0.0) at += steps[k] * roots_[static_cast<std::size_t>(k)];
    }
    return mean_.mean(at);
  }
  /// \param linear  (n) standard deviations of the linear part
  VectorXd deviation(const VectorXd& mean, const VectorXd& linear) const {
    const VectorXd residual = follows_mean_ ? residual_sd_if_known(fit_, mean, table_) : residual_;
    return (residual.array().square() + linear.array().square()).sqrt();
  }

 private:
  const FittedModel& fit_;
  data::Table table_;
  RowMean mean_;
  MatrixXd center_;
  std::vector<MatrixXd> roots_{};  ///< (n x K + U) of each direction
  bool follows_mean_;
  VectorXd residual_{};  ///< (n) if it does not follow the mean
};

/// Calls a function with successive parts of some rows, of each of which it keeps some numbers.
template <typename Function>
void by_parts(const Rows& rows, std::size_t numbers_a_row, const Function& function) {
  const std::size_t size = std::max<std::size_t>(1, kNumbersAtOnce / (numbers_a_row + 1));
  for (std::size_t begin = 0; begin < rows.size(); begin += size) {
    const std::size_t end = std::min(rows.size(), begin + size);
    function(Rows(rows.begin() + static_cast<std::ptrdiff_t>(begin),
                  rows.begin() + static_cast<std::ptrdiff_t>(end)));
  }
}

/// How the rows of one number of directions are integrated.
class Quadrature {
 public:
  explicit Quadrature(const UnknownValues& all)
      : all_(all), directions_(all.roots.size()), result_(all.roots.size(), 2) {
    result_.setConstant(kNaN);
  }

  MatrixXd run(double tail) {
    find_directions();
    std::map<Index, Rows> rows_of_width;
    for (std::size_t row = 0; row < directions_.size(); ++row) {
      rows_of_width[directions_[row].root.cols()].push_back(row);
    }
    for (const auto& [width, rows] : rows_of_width) {
      const std::vector<bool> is_nonlinear = nonlinear_beside_main(rows, width);
      const std::vector<MainPoints> needed = main_points(rows, width);
      for (const MainPoints points : {MainPoints::kFew, MainPoints::kDense, MainPoints::kGapless}) {
        for (const bool many : {false, true}) {
          Rows chosen;
          for (std::size_t k = 0; k < rows.size(); ++k) {
            if (is_nonlinear[k] == many && needed[k] == points) chosen.push_back(rows[k]);
          }
          if (chosen.empty()) continue;
          const PredictionRule rule = prediction_rule(width, points, many);
          // Means and deviations.
          const auto numbers = 2 * static_cast<std::size_t>(rule.points.weights.size());
          by_parts(chosen, numbers, [&](const Rows& some) { integrate(some, rule, tail); });
        }
      }
    }
    return result_;
  }

 private:
  const MatrixXd& root(std::size_t row) const { return directions_[row].root; }

  VectorXd linear_deviation(const Rows& rows) const {
    VectorXd result(static_cast<Index>(rows.size()));
    for (std::size_t k = 0; k < rows.size(); ++k) {
      result[static_cast<Index>(k)] = directions_[rows[k]].linear;
    }
    return result;
  }

  void find_directions() {
    Rows rows;
    Index width = 0;
    for (std::size_t row = 0; row < all_.roots.size(); ++row) {
      rows.push_back(row);
      width = std::max(width, all_.roots[row].cols());
    }
    const bool split = !residual_follows_mean(all_.fit);
    const auto numbers = static_cast<std::size_t>(width * probe_count(width));
    by_parts(rows, numbers, [&](const Rows& some) {
      const Part part(all_, some, {});
      std::vector<MatrixXd> roots;
      for (const std::size_t row : some) roots.push_back(all_.roots[row]);
      std::vector<NonlinearDirections> found = nonlinear_directions(part.mean(),
                                                                    part.center(),
                                                                    all_.gradient(some, Eigen::all),
                                                                    roots,
                                                                    kStraight * all_.error(some),
                                                                    split);
      for (std::size_t k = 0; k < some.size(); ++k) directions_[some[k]] = std::move(found[k]);
    });
  }

  /// The points in the main direction that each of some rows needs.
  std::vector<MainPoints> main_points(const Rows& rows, Index width) const {
    if (width < 1) return std::vector<MainPoints>(rows.size(), MainPoints::kFew);
    std::vector<MainPoints> result;
    for (const double value : steepness(rows)) result.push_back(points_for(value));
    return result;
  }

  /// (rows) largest change of the mean per standard deviation of the main direction, in standard
  /// deviations of what has no points; infinite where the mean is not finite everywhere.
  VectorXd steepness(const Rows& rows) const {
    const Part part(all_, rows, directions_);
    const VectorXd spread = linear_deviation(rows);
    const Index width = root(rows.front()).cols();
    constexpr std::array kPlaces{-3.0, -1.5, 0.0, 1.5, 3.0};
    constexpr double kStep = 1.5;
    VectorXd result = VectorXd::Zero(spread.size());
    VectorXd last_mean;
    VectorXd last_sd;
    for (const double place : kPlaces) {
      const VectorXd here = part.mean_at(place * VectorXd::Unit(width, 0));
      const VectorXd sd = part.deviation(here, spread);
      for (Index k = 0; k < here.size() && place > kPlaces.front(); ++k) {
        const double change =
            std::abs(here[k] - last_mean[k]) / (kStep * std::min(sd[k], last_sd[k]));
        result[k] = std::max(result[k], change);
        if (!std::isfinite(change)) result[k] = kInfinity;
      }
      last_mean = here;
      last_sd = sd;
    }
    return result;
  }

  /// Whether each of some rows needs many points in the directions in which its mean does not
  /// change to first order.
  std::vector<bool> nonlinear_beside_main(const Rows& rows, Index width) const {
    std::vector<bool> result(rows.size(), false);
    if (width < 2) return result;
    const Part part(all_, rows, directions_);
    for (Index direction = 1; direction < width; ++direction) {
      for (const double side : {-std::sqrt(3.0), std::sqrt(3.0)}) {
        const VectorXd moved = part.mean_at(side * VectorXd::Unit(width, direction));
        for (std::size_t k = 0; k < rows.size(); ++k) {
          const auto row = static_cast<Index>(rows[k]);
          const double move = std::abs(moved[static_cast<Index>(k)] - all_.value[row]);
          if (!(move <= kSmallMove * all_.error[row])) result[k] = true;
        }
      }
    }
    return result;
  }

  void integrate(const Rows& rows, const PredictionRule& chosen, double tail) {
    const QuadratureRule& rule = chosen.points;
    const Part part(all_, rows, directions_);
    const VectorXd spread = linear_deviation(rows);
    const auto count = static_cast<Index>(rows.size());
    MatrixXd means(count, rule.weights.size());
    MatrixXd deviations(count, rule.weights.size());
    for (Index k = 0; k < rule.weights.size(); ++k) {
      const VectorXd mean = part.mean_at(rule.nodes.col(k));
      means.col(k) = mean;
      deviations.col(k) = part.deviation(mean, spread);
    }
    NormalMixture mixture;
    VectorXd mean_of_row;
    VectorXd deviation_of_row;
    for (Index i = 0; i < count; ++i) {
      mean_of_row = means.row(i);
      deviation_of_row = deviations.row(i);
      if (chosen.stride > 0) close_gaps(mean_of_row, deviation_of_row, chosen.stride);
      const auto row = static_cast<Index>(rows[static_cast<std::size_t>(i)]);
      mixture.assign(mean_of_row, deviation_of_row, rule.weights, tail);
      result_(row, 0) = mixture.quantile(tail);
      result_(row, 1) = mixture.quantile(1.0 - tail);
    }
  }

  const UnknownValues& all_;
  std::vector<NonlinearDirections> directions_;
  MatrixXd result_;
};

}  // namespace

MatrixXd value_quantiles(const UnknownValues& rows, double tail) {
  return Quadrature(rows).run(tail);
}

}  // namespace silvafit::fit
