// SPDX-License-Identifier: MIT
#include "inference/profile_search.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "inference/profile_scale.hpp"
#include "optimization/quasi_newton.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"

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
  double root = 0.0;               ///< root of the deviance, on either side of the estimate
  bool is_above = false;           ///< the likelihood is higher than at the estimate
  bool is_from_all_sides = false;  ///< found by the search that needs no start
  VectorXd free{};
  MatrixXd hessian{};  ///< from the search for it; empty at the estimate
};

/// Limit of one side, and whether it is the end of the range.
struct Limit {
  double value = kNaN;
  bool is_end = false;      ///< of the parameter's range
  bool is_open = false;     ///< the likelihood never decreases enough
  bool is_cut_off = false;  ///< the search met points without a constrained maximum
  bool is_edge = false;     ///< the formula has no value beyond
};

class ProfileSearch {
 public:
  ProfileSearch(LikelihoodSurface& surface,
                const VarianceModel& variance,
                const NaturalParameter& parameter,
                const ProfileStart& start,
                const HeldStarts& starts)
      : surface_(surface),
        variance_(variance),
        parameter_(parameter),
        start_(start),
        starts_(starts),
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
    const Limit found = limit_before(std::nullopt, sign, target);
    if (!found.is_open || !(sign * origin() < 0.0)) return found;
    std::optional<ProfilePoint> excluded = excluded_near_zero(target);
    return excluded ? limit_before(std::move(excluded), sign, target) : found;
  }

  /// Whether a value as far away as limits are searched is in the set.
  bool contains_far(int sign, double deviance) {
    ProfilePoint far{
        .t = origin() + sign * farthest(), .root = kInfinity, .free = surface_.optimum()};
    look_from_all_sides(far);
    return far.root < std::sqrt(deviance);
  }

 private:
  /// \param outside  an excluded point on this side, if one is known
  Limit limit_before(std::optional<ProfilePoint> outside, int sign, double target) {
    const double end = sign > 0 ? scale_.high : scale_.low;
    ProfilePoint inside{.t = scale_.to(estimate_), .free = surface_.optimum()};
    std::optional<ProfilePoint> before;
    bool is_edge = false;  // the last trials had no value
    double last_width = kInfinity;
    double t = outside ? 0.5 * (inside.t + outside->t) : inside.t + sign * first_step(target);
    constexpr int kTrials = 100;
    for (int trial = 0; trial < kTrials; ++trial) {
      const bool is_at_end = sign * (t - end) >= 0.0;
      if (is_at_end) t = end;
      if (t == inside.t) break;
      ProfilePoint point = constrained(t, inside, before);
      const bool is_close = std::abs(t - inside.t) <= closest(t);
      const auto is_usable = [&] {
        return std::isfinite(point.root) && !point.is_above &&
               (is_close || point.is_from_all_sides || is_plausible(point, inside, before));
      };
      if (!is_usable() || point.root >= target * (1.0 - kRootTolerance)) {
        is_edge = look_from_all_sides(point);
      }
      const bool is_lost = is_overflow(point) && point.root < target;
      if (is_lost || !is_usable()) {
        if ((is_lost || is_close) && passed(inside, t, sign, target)) {
          before.reset();
          t = beyond(inside, before, sign, target);
          continue;
        }
        // The likelihood does not fall to the level as far as there are numbers.
        if (is_lost) return open(sign);
        if (is_close) break;
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
      if (!outside) {
        if (std::abs(inside.t - origin()) > farthest()) return open(sign);
        t = beyond(inside, before, sign, target);
        continue;
      }
      const double width = std::abs(outside->t - inside.t);
      constexpr double kNarrow = 1e-10;
      if (width <= kNarrow * std::max(std::abs(outside->t), span_)) {
        const bool is_jump = outside->root - inside.root > kSlack;
        if (!is_jump || !passed(inside, outside->t, sign, target)) return at(outside->t);
        outside.reset();
        before.reset();
        t = beyond(inside, before, sign, target);
        continue;
      }
      // A secant that does not halve the bracket in two trials is of no use, as at a jump.
      const bool is_slow = trial % 3 == 0 && width > 0.5 * last_width;
      if (trial % 3 == 0) last_width = width;
      t = is_slow ? 0.5 * (inside.t + outside->t) : between(inside, *outside, before, target);
    }
    if (outside) return at(outside->t);
    if (is_edge) return edge(inside.t, t);
    return {.is_cut_off = true};
  }

  /// A point next to 0, if it is excluded. A coefficient whose reciprocal may be 0 can be at either
  /// infinity: steps from one to the other pass all excluded values, and these are around 0. At 0
  /// itself the curve may lack a coefficient whose limit is not excluded.
  std::optional<ProfilePoint> excluded_near_zero(double target) {
    if (parameter_.form != Form::kCoefficient && parameter_.form != Form::kDerived) {
      return std::nullopt;
    }
    const ProfilePoint estimate{.t = origin(), .free = surface_.optimum()};
    // A search may fail so far from the estimate.
    for (const double share : {1e-3, 1e-2, 1e-1}) {
      ProfilePoint near = constrained(share * origin(), estimate, std::nullopt);
      look_from_all_sides(near);
      if (!std::isfinite(near.root)) continue;
      return near.root >= target ? std::optional(std::move(near)) : std::nullopt;
    }
    return std::nullopt;
  }

  /// A parameter to hold, and the likelihood of the others.
  struct Held {
    LikelihoodSurface& surface;
    const VarianceModel& variance;
    const NaturalParameter& parameter;
  };
  Held own() const { return {surface_, variance_, parameter_}; }

  // Steps shorter than this share of the distance or of a typical step are not tried.
  static constexpr double kClose = 1e-4;
  // A larger difference between the roots of two points that are next to each other is a jump.
  static constexpr double kSlack = 0.5;
  // A limit further away than this many first steps counts as none.
  static constexpr double kFarthest = 1e4;

  /// Beyond a factor of e^100 a range or the odds of a correlation are at their end.
  double farthest() const { return parameter_.form == Form::kResidual ? 100.0 : kFarthest * span_; }
  double closest(double t) const { return kClose * std::max(span_, std::abs(t - origin())); }

  double origin() const { return scale_.to(estimate_); }

  bool is_at_boundary(double end) const {
    if (!std::isfinite(end)) return false;
    // A correlation of 1 - 2e-6 counts as 1.
    const bool is_correlation =
        parameter_.form == Form::kCorrelation || parameter_.form == Form::kCommonCorrelation;
    const double near = is_correlation ? 2e-3 : 1e-4;
    return std::abs(origin() - end) <= near * boundary_unit();
  }

  /// Length of a step near the boundary, in units of the search scale.
  double boundary_unit() const {
    const bool is_deviation = parameter_.form == Form::kDeviation ||
                              parameter_.form == Form::kIdentity ||
                              parameter_.form == Form::kCommonDeviation;
    return is_deviation ? std::abs(parameter_.scale) : 1.0;
  }

  /// Whether a point may belong to the same branch of the profile as those inside it. Near another
  /// maximum of the likelihood the deviance jumps.
  bool is_plausible(const ProfilePoint& point,
                    const ProfilePoint& inside,
                    const std::optional<ProfilePoint>& before) const {
    if (point.is_above) return false;
    constexpr double kSteeper = 3.0;
    double slope = error_ > 0.0 ? 1.0 / error_ : 0.0;
    if (before && before->t != inside.t) {
      slope = std::max(slope, (inside.root - before->root) / std::abs(inside.t - before->t));
    }
    if (slope <= 0.0) return true;
    return point.root <= inside.root + kSteeper * slope * std::abs(point.t - inside.t) + kSlack;
  }

  Limit open(int sign) const {
    if (parameter_.form == Form::kResidual) {
      const double end = sign > 0 ? parameter_.high : parameter_.low;
      if (std::isfinite(end)) return {.value = end, .is_end = true};
    }
    return {.value = sign * kInfinity, .is_open = true};
  }
  Limit at(double t) const { return {.value = scale_.from(t)}; }

  /// Between the last point with a value and the next one without: 0 if it is there.
  Limit edge(double inside, double outside) const {
    const double from = scale_.from(inside);
    const double to = scale_.from(outside);
    return {.value = from * to <= 0.0 ? 0.0 : from, .is_edge = true};
  }

  bool is_overflow(const ProfilePoint& point) const {
    // Near the largest number, or its root where covariances hold squares. A maximum that is flat
    // towards infinity ends long before.
    const double largest = surface_.layout().terms() > 0 ? 1e150 : 1e300;
    return surface_.layout().beta(point.free).cwiseAbs().maxCoeff() > largest;
  }

  /// Whether the likelihood is above the target again beyond a jump of the root, where the maximum
  /// went to infinity and comes back from the other side. The inside then is there.
  bool passed(ProfilePoint& inside, double from, int sign, double target) {
    if (!starts_) return false;
    for (double step = span_ / 64.0; step <= span_; step *= 2.0) {
      ProfilePoint point{.t = from + sign * step, .root = kInfinity, .free = inside.free};
      look_from_all_sides(point);
      if (point.root < target && !point.is_above && !is_overflow(point)) {
        inside = std::move(point);
        return true;
      }
    }
    return false;
  }

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
    // Where the likelihood is flat the variance is nothing or rounding errors: a correlation at the
    // end of its range is, on the search scale, a logarithm or logit.
    constexpr double kLeast = 1e-10;
    constexpr double kMost = 100.0;
    const bool is_flat =
        parameter_.form == Form::kResidual && !(variance_of > kLeast && variance_of < kMost);
    const bool is_known = std::isfinite(variance_of) && variance_of > 0.0 && !is_flat;
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
        minimized(own(), t, value, guess(t, inside, before), hessian_at(inside, value));
    if (point && is_plausible(*point, inside, before)) return *point;
    // The start may be where the likelihood has no value, or near another maximum.
    const std::optional<ProfilePoint> again =
        minimized(own(), t, value, inside.free, hessian_at(inside, value));
    if (again && !again->is_above && (!point || point->is_above || again->root < point->root)) {
      return *again;
    }
    return point.value_or(ProfilePoint{.t = t, .root = kInfinity, .free = inside.free});
  }

  /// The lowest of the constrained minima from all starts, if it is below the point.
  /// \return whether the formula has no value there, with any other coefficients
  bool look_from_all_sides(ProfilePoint& point) {
    if (!starts_) return false;
    const double value = scale_.from(point.t);
    std::vector<std::unique_ptr<HeldSurface>> starts;
    try {
      starts = starts_(value);
    } catch (const DomainError&) {
    }
    bool has_value = std::isfinite(point.root);
    for (const std::unique_ptr<HeldSurface>& start : starts) {
      LikelihoodSurface& there = *start->surface;
      const SurfaceSetting& setting = start->setting;
      const std::vector<NaturalParameter> all = natural_parameters(setting, there.layout());
      const NaturalParameter& parameter =
          *std::ranges::find(all, parameter_.name, &NaturalParameter::name);
      VectorXd free = there.optimum();
      if (setting.fit.method != Method::kOrdinary) {
        // The effects on the mean have the size of those at the estimate.
        const Index others = free.size() - there.layout().beta_count();
        free.tail(others) = surface_.optimum().tail(others);
      }
      VectorXd gradient(free.size());
      const VectorXd held = parameter.hold(there.layout(), setting.variance, free, value);
      if (!std::isfinite(there.value(held, &gradient))) continue;
      has_value = true;
      std::optional<ProfilePoint> found =
          minimized({there, setting.variance, parameter}, point.t, value, free, {});
      if (!found || found->root >= point.root) continue;
      found->free = in_own_units(there.layout(), found->free);
      found->hessian.resize(0, 0);
      found->is_from_all_sides = true;
      point = *std::move(found);
    }
    return !has_value;
  }

  /// A point of a surface in other units.
  VectorXd in_own_units(const SurfaceLayout& layout, const VectorXd& x) const {
    const SurfaceLayout& own = surface_.layout();
    VectorXd result = x;
    result.head(own.beta_count()) = own.frame().beta.partialPivLu().solve(layout.beta(x));
    for (std::size_t term = 0; term < own.terms(); ++term) {
      own.set_own_factor(term, layout.own_factor(x, term), result);
    }
    return result;
  }

  /// Nothing if the search ends before a minimum: such a point would look like a steep decrease of
  /// the likelihood.
  std::optional<ProfilePoint> minimized(
      const Held& in, double t, double value, const VectorXd& free, const MatrixXd& begin) {
    const SurfaceLayout& layout = in.surface.layout();
    NaturalParameter parameter = in.parameter;
    VectorXd from = free;
    parameter.hold_near(layout, value, from);
    const SmoothFunction objective = [&](const VectorXd& at, VectorXd* gradient) {
      const VectorXd x = parameter.hold(layout, in.variance, at, value);
      if (gradient == nullptr) return in.surface.value(x, nullptr);
      VectorXd whole(x.size());
      const double result = in.surface.value(x, &whole);
      if (std::isfinite(result)) {
        *gradient = parameter.pull_back(layout, in.variance, at, value, whole);
      }
      return result;
    };
    // The Hessian is of the coordinates that are free.
    const bool is_same = parameter.coordinate == in.parameter.coordinate;
    QuasiNewtonResult found = minimize(objective,
                                       lifted(layout, from),
                                       is_same ? begin : MatrixXd(),
                                       {.decrement = kDecrement, .maximum_steps = 60});
    // A Hessian from far away may be too wrong for updates.
    constexpr int kFreshStarts = 3;
    for (int i = 0; i < kFreshStarts && std::isfinite(found.value) && !is_minimum(found); ++i) {
      VectorXd again = found.x;
      parameter.hold_near(layout, value, again);
      found = minimize(objective, again, {}, {.decrement = kDecrement, .maximum_steps = 60});
    }
    if (!std::isfinite(found.value) || !is_minimum(found)) return std::nullopt;
    // A point of a quantity is where it is held, whatever coordinate the next search moves.
    const bool is_derived = parameter.form == Form::kDerived;
    ProfilePoint point{
        .t = t,
        .free = is_derived ? parameter.hold(layout, in.variance, found.x, value) : found.x,
        .hessian = is_derived ? MatrixXd() : found.hessian};
    const double deviance = 2.0 * (found.value - start_.value);
    gain_ = std::max(gain_, -0.5 * deviance);
    point.root = std::sqrt(std::max(0.0, deviance));
    point.is_above = deviance < -kNoDeviance;
    return point;
  }

  /// A start inside the ranges of the variance components and of the correlation.
  VectorXd lifted(const SurfaceLayout& layout, const VectorXd& from) const {
    VectorXd result = layout.lifted(from);
    const Index count = variance_.correlation_count();
    if (count == 0) return result;
    auto own = result.segment(layout.variance_at() + variance_.parameter_count() - count, count);
    own = variance_.correlated()->structure().lifted(own);
    return result;
  }

  /// Rounding of the likelihood may prevent the last digits.
  bool is_minimum(const QuasiNewtonResult& found) const {
    const double rounding = 1e-13 * std::max(1.0, std::abs(found.value));
    return found.decrement <= kGoodDecrement + rounding;
  }

  MatrixXd hessian_at(const ProfilePoint& point, double value) const {
    return point.hessian.size() > 0 ? point.hessian : constrained_hessian(point.free, value);
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
  const HeldStarts& starts_;
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
  } else if (limit.is_edge) {
    add_note(interval.note, fmt::format("the formula has no value beyond {:g}", limit.value));
  } else if (limit.is_cut_off) {
    add_note(interval.note,
             fmt::format("{} limit unknown: no constrained maximum was found there", side));
  }
}

/// A ratio may pass infinity where its denominator may be 0, and so may a coefficient.
void note_beyond_infinity(ProfileSearch& search, double deviance, ParameterInterval& interval) {
  const bool is_one_sided = std::isinf(interval.lower) != std::isinf(interval.upper);
  if (!is_one_sided) return;
  if (interval.kind == ParameterKind::kDerived) {
    add_note(interval.note,
             "if it is a ratio, values at the other end, beyond infinity, are not excluded either");
  } else if (interval.kind == ParameterKind::kFixed &&
             search.contains_far(std::isinf(interval.upper) ? -1 : 1, deviance)) {
    add_note(interval.note, "values at the other end, beyond infinity, are not excluded either");
  }
}

FittedModel moved(FittedModel fit, const VectorXd& estimate) {
  Index next = 0;
  for (Index j = 0; j < fit.estimate.size(); ++j) {
    if (!std::isnan(fit.covariance(j, j))) fit.estimate[j] = estimate[next++];
  }
  return fit;
}

}  // namespace

HeldSurface::HeldSurface(const FittedModel& of, const data::Table& table, const VectorXd& estimate)
    : fit(moved(of, estimate)), setting(fit, table), surface(make_surface(setting)) {}

ParameterInterval profile_interval(LikelihoodSurface& surface,
                                   const VarianceModel& variance,
                                   const NaturalParameter& parameter,
                                   const ProfileStart& start,
                                   const ProfileCut& cut,
                                   const HeldStarts& starts) {
  ParameterInterval interval{.kind = parameter.kind, .name = parameter.name};
  if (!parameter.can_be_held(variance)) {
    interval.estimate = parameter.value(surface.layout(), variance, surface.optimum());
    interval.lower = interval.upper = kNaN;
    interval.note = "correlations of this structure depend on each other; use Wald intervals";
    return interval;
  }
  ProfileSearch search(surface, variance, parameter, start, starts);
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
  note_beyond_infinity(search, deviance, interval);
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
