// SPDX-License-Identifier: MIT
#include "inference/profile_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "inference/profile_scale.hpp"
#include "optimization/quasi_newton.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Form = NaturalParameter::Form;

// Squared distance to the constrained maximum, in standard errors, at which the search ends: the
// error of the deviance is of the same size.
constexpr double kDecrement = 1e-9;
// The largest that counts as a minimum: the error of the deviance is of the same size.
constexpr double kGoodDecrement = 1e-6;
// Relative error of limits, as a share of the signed root of the deviance.
constexpr double kRootTolerance = 1e-6;
// A smaller deviance counts as zero.
constexpr double kNoDeviance = 1e-6;

/// A constrained maximum.
struct ProfilePoint {
  double t = 0.0;
  double root = 0.0;      ///< root of the deviance, on either side of the estimate
  bool is_above = false;  ///< the likelihood is higher than at the estimate
  VectorXd free{};
  MatrixXd hessian{};  ///< from the search for it; empty at the estimate
};

/// Limit of one side, and whether it is the end of the range.
struct Limit {
  double value = kNaN;
  bool is_end = false;      ///< of the parameter's range
  bool is_open = false;     ///< the likelihood never decreases enough
  bool is_cut_off = false;  ///< the search met points without a constrained maximum
};

class ProfileSearch {
 public:
  ProfileSearch(LikelihoodSurface& surface,
                const VarianceModel& variance,
                const NaturalParameter& parameter,
                const ProfileStart& start)
      : surface_(surface),
        variance_(variance),
        parameter_(parameter),
        start_(start),
        estimate_(parameter.value(surface.layout(), variance, surface.optimum())),
        scale_(parameter, estimate_) {
    find_slope();
  }

  double estimate() const { return estimate_; }
  bool is_at_lower_bound() const { return is_at_boundary(scale_.low); }
  bool is_at_upper_bound() const { return is_at_boundary(scale_.high); }
  /// How far a profile was above the maximum; 0 if it never was.
  double gain() const { return gain_; }

  /// \param sign  1 for the upper limit, -1 for the lower one
  Limit limit(int sign, double deviance) {
    const double target = std::sqrt(deviance);
    const double end = sign > 0 ? scale_.high : scale_.low;
    ProfilePoint inside{.t = scale_.to(estimate_), .free = surface_.optimum()};
    std::optional<ProfilePoint> before;
    std::optional<ProfilePoint> outside;
    bool is_blocked = false;
    double t = inside.t + sign * first_step(target);
    constexpr int kTrials = 60;
    for (int trial = 0; trial < kTrials; ++trial) {
      const bool is_at_end = sign * (t - end) >= 0.0;
      if (is_at_end) t = end;
      if (t == inside.t) break;
      const ProfilePoint point = constrained(t, inside, before);
      const bool is_close =
          std::abs(t - inside.t) <= kClose * std::max(span_, std::abs(t - origin()));
      const bool is_usable = std::isfinite(point.root) && !point.is_above &&
                             (is_close || is_plausible(point, inside, before));
      if (!is_usable) {
        if (is_close) {
          is_blocked = true;
          break;
        }
        t = 0.5 * (inside.t + t);
        continue;
      }
      if (std::abs(point.root - target) <= kRootTolerance * target) return at(point.t);
      if (point.root < target) {
        if (is_at_end) return {.value = scale_.from(end), .is_end = true};
        before = std::exchange(inside, point);
      } else {
        outside = point;
      }
      if (outside) {
        constexpr double kNarrow = 1e-10;
        const double width = std::abs(outside->t - inside.t);
        if (width <= kNarrow * std::max(std::abs(outside->t), span_)) return at(outside->t);
        t = between(inside, *outside, before, target);
      } else {
        if (std::abs(inside.t - origin()) > kFarthest * span_) return open(sign);
        t = beyond(inside, before, sign, target);
      }
    }
    if (outside) return at(outside->t);
    if (is_blocked) return {.is_cut_off = true};
    return open(sign);
  }

 private:
  // Steps shorter than this share of the distance or of a typical step are not tried.
  static constexpr double kClose = 1e-4;
  // A limit further away than this many first steps counts as none.
  static constexpr double kFarthest = 1e4;

  double origin() const { return scale_.to(estimate_); }

  bool is_at_boundary(double end) const {
    if (!std::isfinite(end)) return false;
    // A correlation of 1 - 2e-6 counts as 1.
    const double near = parameter_.form == Form::kCorrelation ? 2e-3 : 1e-4;
    return std::abs(origin() - end) <= near * boundary_unit();
  }

  /// Length of a step near the boundary, in units of the search scale.
  double boundary_unit() const {
    const bool is_deviation =
        parameter_.form == Form::kDeviation || parameter_.form == Form::kIdentity;
    return is_deviation ? std::abs(parameter_.scale) : 1.0;
  }

  /// Whether a point may belong to the same branch of the profile as those inside it. Near another
  /// maximum of the likelihood the deviance jumps.
  bool is_plausible(const ProfilePoint& point,
                    const ProfilePoint& inside,
                    const std::optional<ProfilePoint>& before) const {
    if (point.is_above) return false;
    constexpr double kSteeper = 3.0;
    constexpr double kSlack = 0.5;
    double slope = error_ > 0.0 ? 1.0 / error_ : 0.0;
    if (before && before->t != inside.t) {
      slope = std::max(slope, (inside.root - before->root) / std::abs(inside.t - before->t));
    }
    if (slope <= 0.0) return true;
    return point.root <= inside.root + kSteeper * slope * std::abs(point.t - inside.t) + kSlack;
  }

  static Limit open(int sign) { return {.value = sign * kInfinity, .is_open = true}; }
  Limit at(double t) const { return {.value = scale_.from(t)}; }

  /// The derivatives of the parameter's search scale at the maximum, and its standard error there.
  void find_slope() {
    const VectorXd& x = surface_.optimum();
    slope_.setZero(x.size());
    constexpr double kStep = 1e-5;
    for (Index k = 0; k < x.size(); ++k) {
      VectorXd moved = x;
      moved[k] += kStep;
      const double above = scale_.to(parameter_.value(surface_.layout(), variance_, moved));
      moved[k] -= 2.0 * kStep;
      const double below = scale_.to(parameter_.value(surface_.layout(), variance_, moved));
      slope_[k] = (above - below) / (2.0 * kStep);
    }
    if (!slope_.allFinite()) slope_.setZero();
    spread_ = start_.inverse * slope_;
    const double variance_of = slope_.dot(spread_);
    const bool is_known = std::isfinite(variance_of) && variance_of > 0.0;
    const bool is_inside = !is_at_lower_bound() && !is_at_upper_bound();
    error_ = is_known && is_inside ? std::sqrt(variance_of) : 0.0;
    span_ = error_ > 0.0 ? error_ : 0.1 * boundary_unit();
  }

  double first_step(double target) const {
    return error_ > 0.0 ? error_ * target : 0.1 * boundary_unit() * target;
  }

  /// Start for the constrained maximum: extrapolated from the last two, or along the ridge of the
  /// likelihood.
  VectorXd guess(double t,
                 const ProfilePoint& inside,
                 const std::optional<ProfilePoint>& before) const {
    if (before && before->t != inside.t) {
      const double share = (t - inside.t) / (inside.t - before->t);
      constexpr double kFar = 3.0;
      return inside.free + std::clamp(share, -kFar, kFar) * (inside.free - before->free);
    }
    if (error_ > 0.0 && inside.t == origin()) {
      return inside.free + (t - inside.t) / (error_ * error_) * spread_;
    }
    return inside.free;
  }

  /// The constrained maximum at t; the root is infinite if none was found.
  ProfilePoint constrained(double t,
                           const ProfilePoint& inside,
                           const std::optional<ProfilePoint>& before) {
    const double value = scale_.from(t);
    const std::optional<ProfilePoint> point =
        minimized(t, value, guess(t, inside, before), inside.hessian);
    if (point && is_plausible(*point, inside, before)) return *point;
    // The start may be where the likelihood has no value, or near another maximum.
    const std::optional<ProfilePoint> again = minimized(t, value, inside.free, inside.hessian);
    if (again && !again->is_above && (!point || point->is_above || again->root < point->root)) {
      return *again;
    }
    return point.value_or(ProfilePoint{.t = t, .root = kInfinity, .free = inside.free});
  }

  /// Nothing if the search ends before a minimum: such a point would look like a steep decrease of
  /// the likelihood.
  std::optional<ProfilePoint> minimized(double t,
                                        double value,
                                        const VectorXd& free,
                                        const MatrixXd& hessian) {
    const SurfaceLayout& layout = surface_.layout();
    const SmoothFunction objective = [&](const VectorXd& at, VectorXd* gradient) {
      const VectorXd x = parameter_.hold(layout, variance_, at, value);
      if (gradient == nullptr) return surface_.value(x, nullptr);
      VectorXd whole(x.size());
      const double result = surface_.value(x, &whole);
      if (std::isfinite(result)) {
        *gradient = parameter_.pull_back(layout, variance_, at, value, whole);
      }
      return result;
    };
    const MatrixXd begin = hessian.size() > 0 ? hessian : constrained_hessian(free, value);
    QuasiNewtonResult found =
        minimize(objective, free, begin, {.decrement = kDecrement, .maximum_steps = 60});
    // A Hessian from far away may be too wrong for updates.
    constexpr int kFreshStarts = 3;
    for (int i = 0; i < kFreshStarts && std::isfinite(found.value) && !is_minimum(found); ++i) {
      found = minimize(objective, found.x, {}, {.decrement = kDecrement, .maximum_steps = 60});
    }
    if (!std::isfinite(found.value) || !is_minimum(found)) return std::nullopt;
    ProfilePoint point{.t = t, .free = found.x, .hessian = found.hessian};
    const double deviance = 2.0 * (found.value - start_.value);
    gain_ = std::max(gain_, -0.5 * deviance);
    point.root = std::sqrt(std::max(0.0, deviance));
    point.is_above = deviance < -kNoDeviance;
    return point;
  }

  /// Rounding of the likelihood may prevent the last digits.
  bool is_minimum(const QuasiNewtonResult& found) const {
    const double rounding = 1e-13 * std::max(1.0, std::abs(found.value));
    return found.decrement <= kGoodDecrement + rounding;
  }

  /// J'HJ at the estimates' H, with J the derivative of x by the free vector.
  MatrixXd constrained_hessian(const VectorXd& free, double value) const {
    const Index n = free.size();
    MatrixXd transposed(n, n);
    for (Index k = 0; k < n; ++k) {
      transposed.col(k) =
          parameter_.pull_back(surface_.layout(), variance_, free, value, VectorXd::Unit(n, k));
    }
    if (!transposed.allFinite()) return start_.hessian;
    return transposed * start_.hessian * transposed.transpose();
  }

  /// The next trial between two points: a secant, kept away from the ends, else the middle.
  static double between(const ProfilePoint& inside,
                        const ProfilePoint& outside,
                        const std::optional<ProfilePoint>& before,
                        double target) {
    const double width = outside.t - inside.t;
    double share = (target - inside.root) / (outside.root - inside.root);
    // With three points, the parabola of t in the root.
    if (before && before->root < inside.root) {
      const double s0 = before->root;
      const double s1 = inside.root;
      const double s2 = outside.root;
      const double t = before->t * (target - s1) * (target - s2) / ((s0 - s1) * (s0 - s2)) +
                       inside.t * (target - s0) * (target - s2) / ((s1 - s0) * (s1 - s2)) +
                       outside.t * (target - s0) * (target - s1) / ((s2 - s0) * (s2 - s1));
      const double parabolic = (t - inside.t) / width;
      if (parabolic > 0.0 && parabolic < 1.0) share = parabolic;
    }
    if (!(share > 0.0 && share < 1.0)) share = 0.5;
    return inside.t + share * width;
  }

  /// The next trial further out.
  double beyond(const ProfilePoint& inside,
                const std::optional<ProfilePoint>& before,
                int sign,
                double target) const {
    const double done = std::abs(inside.t - origin());
    double step = 2.0 * std::max(done, span_);
    if (before && inside.root > before->root) {
      const double secant =
          (target - inside.root) * std::abs(inside.t - before->t) / (inside.root - before->root);
      // A little further, so that the limit is between.
      step = std::min(step, 1.02 * secant);
    }
    return inside.t + sign * step;
  }

  LikelihoodSurface& surface_;
  const VarianceModel& variance_;
  const NaturalParameter& parameter_;
  const ProfileStart& start_;
  double estimate_;
  ProfileScale scale_;
  VectorXd slope_;
  VectorXd spread_;     ///< inverse Hessian times slope
  double error_ = 0.0;  ///< standard error on the search scale; 0 where it is not known
  double span_ = 1.0;   ///< a typical step
  double gain_ = 0.0;
};

bool is_spread(const NaturalParameter& parameter) {
  return parameter.kind == ParameterKind::kDeviation;
}

void add_note(std::string& note, const std::string& text) {
  if (!note.empty()) note += "; ";
  note += text;
}

void take(const Limit& limit,
          bool is_upper,
          const NaturalParameter& parameter,
          ParameterInterval& interval) {
  (is_upper ? interval.upper : interval.lower) = limit.value;
  const char* const side = is_upper ? "upper" : "lower";
  if (limit.is_open || std::isinf(limit.value)) {
    add_note(
        interval.note,
        fmt::format("no {} limit: the likelihood does not fall below the limit's level", side));
  } else if (limit.is_end && is_spread(parameter)) {
    add_note(interval.note, "the data do not exclude 0");
  } else if (limit.is_end) {
    add_note(interval.note, fmt::format("the data do not exclude {:g}", limit.value));
  } else if (limit.is_cut_off) {
    add_note(interval.note,
             fmt::format("{} limit unknown: no constrained maximum was found there", side));
  }
}

}  // namespace

ParameterInterval profile_interval(LikelihoodSurface& surface,
                                   const VarianceModel& variance,
                                   const NaturalParameter& parameter,
                                   const ProfileStart& start,
                                   const ProfileCut& cut) {
  ParameterInterval interval{.kind = parameter.kind, .name = parameter.name};
  if (!parameter.can_be_held(variance)) {
    interval.estimate = parameter.value(surface.layout(), variance, surface.optimum());
    interval.lower = interval.upper = kNaN;
    interval.note = "correlations of this structure depend on each other; use Wald intervals";
    return interval;
  }
  ProfileSearch search(surface, variance, parameter, start);
  interval.estimate = search.estimate();
  if (std::isnan(interval.estimate)) {
    interval.lower = interval.upper = kNaN;
    interval.note = "undefined: a standard deviation is 0";
    return interval;
  }
  const bool is_low = search.is_at_lower_bound();
  const bool is_high = search.is_at_upper_bound();
  const double deviance = is_low || is_high ? cut.one_side : cut.both_sides;
  if (is_low) {
    interval.lower = interval.estimate;
  } else {
    take(search.limit(-1, deviance), false, parameter, interval);
  }
  if (is_high) {
    interval.upper = interval.estimate;
  } else {
    take(search.limit(1, deviance), true, parameter, interval);
  }
  if (is_low || is_high) {
    add_note(
        interval.note,
        "boundary estimate: one-sided, by the 50:50 mixture of chi-squared(0) and chi-squared(1)");
  }
  if (search.gain() > kNoDeviance) {
    add_note(interval.note,
             fmt::format("the log-likelihood is higher by {:.2g} at another point: the fit is at a "
                         "lower maximum",
                         search.gain()));
  }
  return interval;
}

}  // namespace silvafit::fit
