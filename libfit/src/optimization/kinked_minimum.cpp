// SPDX-License-Identifier: MIT
#include "optimization/kinked_minimum.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Gradients at neighbouring points of a smooth function differ by rounding; conditional modes
/// leave about 1e-8.
constexpr double kJump = 1e-6;
/// Coordinates are of order one: a kink farther away is not what a search was stuck at.
constexpr double kReach = 1.0;
constexpr double kSettled = 1e-12;  // squared standard errors
constexpr int kMostSteps = 30;
constexpr int kHalvings = 8;

struct Sample {
  VectorXd x{};
  double value = std::numeric_limits<double>::infinity();
  VectorXd gradient{};
};

/// Neighbouring points on both sides of a kink: the function falls on the line to it before, and
/// rises behind it.
struct Crossing {
  Sample before{};
  Sample behind{};
};

class KinkSearch {
 public:
  KinkSearch(const SmoothFunction& function, const HessianFunction& hessian)
      : function_(function), hessian_(hessian) {}

  std::optional<KinkedMinimum> run(const VectorXd& start) {
    at_ = sample(start);
    if (!std::isfinite(at_.value) || !add_kink(-at_.gradient)) return std::nullopt;
    for (int step = 0; step < kMostSteps; ++step) {
      if (!linearize()) return std::nullopt;
      if (decrement_ <= kSettled) return certified();
      if (move()) continue;
      if (!add_kink(step_)) return decrement_ <= kRoundedDecrement ? certified() : std::nullopt;
    }
    return std::nullopt;
  }

 private:
  /// Where rounding of the function refuses further steps.
  static constexpr double kRoundedDecrement = 1e-8;

  Sample sample(const VectorXd& x) const {
    Sample result{.x = x, .gradient = VectorXd::Zero(x.size())};
    result.value = function_(x, &result.gradient);
    if (!result.gradient.allFinite()) result.value = std::numeric_limits<double>::infinity();
    return result;
  }

  /// The kink on a line downhill; none if the function is smooth up to its minimum there.
  std::optional<Crossing> crossing(const Sample& from, const VectorXd& direction) const {
    const VectorXd unit = direction.normalized();
    if (!(from.gradient.dot(unit) < 0.0)) return std::nullopt;
    Crossing result{.before = from};
    double low = 0.0;
    double high = 1e-12;
    for (;; high *= 4.0) {
      if (high > kReach) return std::nullopt;
      result.behind = sample(from.x + high * unit);
      if (!std::isfinite(result.behind.value)) return std::nullopt;
      if (result.behind.gradient.dot(unit) >= 0.0) break;
      low = high;
      result.before = result.behind;
    }
    for (double middle = std::midpoint(low, high); low < middle && middle < high;
         middle = std::midpoint(low, high)) {
      Sample between = sample(from.x + middle * unit);
      if (between.x == result.before.x || between.x == result.behind.x) break;
      const bool is_behind = between.gradient.dot(unit) >= 0.0;
      (is_behind ? high : low) = middle;
      (is_behind ? result.behind : result.before) = std::move(between);
    }
    const double jump = (result.behind.gradient - result.before.gradient).dot(unit);
    return jump > kJump ? std::optional(std::move(result)) : std::nullopt;
  }

  /// Adds the kink that lies in a direction, and moves to it.
  bool add_kink(const VectorXd& direction) {
    if (normals_.cols() == at_.x.size()) return false;
    std::optional<Crossing> found = crossing(at_, direction);
    if (!found) return false;
    normals_.conservativeResize(at_.x.size(), normals_.cols() + 1);
    normals_.rightCols(1) = (found->behind.gradient - found->before.gradient).normalized();
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(normals_);
    if (qr.rank() < normals_.cols()) return false;
    at_ = std::move(found->before);
    return true;
  }

  /// Directions each of which leads across one kink and along the others.
  MatrixXd across() const {
    return normals_ * (normals_.transpose() * normals_)
                          .llt()
                          .solve(MatrixXd::Identity(normals_.cols(), normals_.cols()));
  }

  /// Orthonormal directions along all kinks.
  MatrixXd along() const {
    const MatrixXd q = Eigen::HouseholderQR<MatrixXd>(normals_).householderQ();
    return q.rightCols(q.cols() - normals_.cols());
  }

  bool linearize() {
    tangents_ = along();
    curvature_ = hessian_ ? hessian_(at_.x) : one_sided();
    if (!curvature_.allFinite()) return false;
    const Eigen::LLT<MatrixXd> reduced(tangents_.transpose() * curvature_ * tangents_);
    if (reduced.info() != Eigen::Success) return false;
    const VectorXd slope = tangents_.transpose() * at_.gradient;
    const VectorXd newton = reduced.solve(slope);
    step_ = -tangents_ * newton;
    decrement_ = slope.dot(newton);
    return true;
  }

  /// The Hessian from differences of gradients, a step away from the kinks on the side of the
  /// point.
  MatrixXd one_sided() const {
    constexpr double kStep = 1e-5;
    const MatrixXd outwards = -across();
    MatrixXd directions(at_.x.size(), at_.x.size());
    directions << outwards, tangents_;
    const Sample base = sample(at_.x + kStep * outwards.rowwise().sum());
    MatrixXd changes(directions.rows(), directions.cols());
    for (Index k = 0; k < directions.cols(); ++k) {
      const Sample beside = sample(base.x + kStep * directions.col(k));
      changes.col(k) = (beside.gradient - base.gradient) / kStep;
    }
    const MatrixXd hessian = changes * directions.partialPivLu().inverse();
    return 0.5 * (hessian + hessian.transpose());
  }

  /// A step along the kinks, and back to them.
  bool move() {
    double share = 1.0;
    for (int halving = 0; halving < kHalvings; ++halving, share *= 0.5) {
      std::optional<Sample> next = onto_kinks(sample(at_.x + share * step_));
      if (!next || !(next->value < at_.value)) continue;
      at_ = *std::move(next);
      return true;
    }
    return false;
  }

  /// The point of all kinks that is next to one beside them.
  std::optional<Sample> onto_kinks(Sample point) const {
    const MatrixXd directions = across();
    for (Index k = 0; k < directions.cols(); ++k) {
      const double slope = point.gradient.dot(directions.col(k));
      std::optional<Crossing> found =
          crossing(point, slope < 0.0 ? VectorXd(directions.col(k)) : VectorXd(-directions.col(k)));
      if (!found) return std::nullopt;
      point = slope < 0.0 ? std::move(found->before) : std::move(found->behind);
    }
    return point;
  }

  /// The result, if the function increases on both sides of each kink.
  std::optional<KinkedMinimum> certified() const {
    const MatrixXd directions = across();
    for (Index k = 0; k < directions.cols(); ++k) {
      if (!crossing(at_, directions.col(k))) return std::nullopt;
    }
    return KinkedMinimum{.x = at_.x,
                         .value = at_.value,
                         .gradient = at_.gradient,
                         .hessian = curvature_,
                         .normals = normals_,
                         .decrement = decrement_};
  }

  const SmoothFunction& function_;
  const HessianFunction& hessian_;
  Sample at_;
  MatrixXd normals_;   ///< (n x kinks) of length one, to the side where the function increases
  MatrixXd tangents_;  ///< (n x rest)
  MatrixXd curvature_;
  VectorXd step_;
  double decrement_ = 0.0;
};

}  // namespace

std::vector<Index> kinked_coefficients(const MatrixXd& frame, const MatrixXd& normals) {
  // Of the jump of the gradient in coordinates whose units change the mean alike; others are
  // rounding.
  constexpr double kShare = 1e-3;
  const Index p = frame.rows();
  if (p == 0) return {};
  const MatrixXd jumps = frame.transpose().partialPivLu().solve(normals.topRows(p));
  const VectorXd units = frame.rowwise().norm();
  const VectorXd sizes = (units.asDiagonal() * jumps).rowwise().norm();
  const VectorXd others = normals.bottomRows(normals.rows() - p).rowwise().norm();
  const double largest =
      others.size() > 0 ? std::max(sizes.maxCoeff(), others.maxCoeff()) : sizes.maxCoeff();
  std::vector<Index> result;
  for (Index j = 0; j < p; ++j) {
    if (sizes[j] > kShare * largest) result.push_back(j);
  }
  return result;
}

std::optional<KinkedMinimum> minimum_at_kinks(const SmoothFunction& function,
                                              const VectorXd& x,
                                              const HessianFunction& hessian) {
  return KinkSearch(function, hessian).run(x);
}

}  // namespace silvafit::fit
