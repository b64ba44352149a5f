// SPDX-License-Identifier: MIT
#include "lindstrom_bates/lindstrom_bates.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "model/coefficient_frame.hpp"
#include "model/symmetric_eigen.hpp"
#include "optimization/tolerances.hpp"
#include "result/group_coefficients.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/fit/fit_statistics.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {
namespace {

/// (p x p) cross products of the columns of X.
MatrixXd column_products(const Linearization& at) {
  const Index p = at.model.moments.width() - 1;
  return at.model.moments.total(0).topLeftCorner(p, p);
}

/// Root mean squares of the columns of X, 1 for zero columns.
VectorXd column_sizes(const Linearization& at) {
  const VectorXd squares = column_products(at).diagonal();
  VectorXd sizes = (squares / static_cast<double>(at.model.observations)).cwiseSqrt();
  for (double& value : sizes) {
    if (!std::isfinite(value) || value == 0.0) value = 1.0;
  }
  return sizes;
}

/// The smallest eigenvalue of the correlations (without centering) of the columns of fixed effects,
/// a measure of linear dependence.
double distance_from_dependence(const Linearization& at) {
  const Index p = at.model.moments.width() - 1 - at.model.random_only;
  const VectorXd unit = column_sizes(at).head(p).cwiseInverse();
  const MatrixXd products =
      column_products(at).topLeftCorner(p, p) / static_cast<double>(at.model.observations);
  if (unit.size() == 0 || !products.allFinite()) return 1.0;
  return symmetric_eigen(unit.asDiagonal() * products * unit.asDiagonal()).values[0];
}

// Columns with a smaller eigenvalue are orthogonalized.
constexpr double kNearDependence = 1e-4;

/// M of the frame of coefficients of each group; empty where it is the identity.
MatrixXd mixing_at(const NonlinearModel& model, const MatrixXd& coefficients) {
  return shared_frame(model, model.curve_at(coefficients).jacobian, 1.0).mixing();
}

VarianceData residual_data(const NonlinearModel& model, bool is_correlated) {
  VarianceData data = VarianceData::of(model);
  if (!is_correlated) data.correlated.reset();
  return data;
}

/// Whether g is about one at typical values for any parameters.
bool normalized(const VarianceFunction& variance) {
  return std::ranges::all_of(variance.factors, [](const VarianceFactor& factor) {
    return kind_of(factor).reads_value() && factor.stratum.empty() && !factor.delta &&
           !factor.constant;
  });
}

// The factor 0.375 is that of nlme's start: random effects explain most of the possible spread.
constexpr double kStartDivisor = 0.375;
// Coordinates are recomputed if a column of the Jacobian has changed by more than this factor.
constexpr double kUnsuitable = 4.0;

}  // namespace

double LindstromBatesState::penalty() const {
  double sum = 0.0;
  for (const MatrixXd& of_term : spherical) sum += of_term.squaredNorm();
  return sum;
}

PooledFit pooled_fit(const NonlinearModel& model,
                     const VectorXd& start,
                     const MixedEffectsOptions& options) {
  const VarianceModel constant({}, VarianceData{});
  const Index columns = model.column_count();
  LinearizationPoint point{.coefficients = model.extended(start),
                           .effects = MatrixXd::Zero(columns, model.group_count()),
                           .variance = VectorXd(0),
                           .units = VectorXd::Ones(columns)};
  Linearizer linearizer(model, constant);
  Linearization at;
  linearizer.linearize(point, false, nullptr, at);
  if (distance_from_dependence(at) < kNearDependence) {
    point.mixing = mixing_at(model, point.coefficients.replicate(1, model.group_count()));
    linearizer.linearize(point, false, nullptr, at);
  }
  PooledFit result{
      .coefficients = start,
      .scale = column_sizes(at).cwiseInverse(),
      .mixing = point.mixing,
      .log_likelihood = least_squares_log_likelihood(at.squares.sum(), model.observations())};
  if (options.reml) {
    at.model.restricted = true;
    RelativeFactors none;
    for (const std::vector<Index>& term : at.model.random.terms) {
      none.emplace_back(MatrixXd::Zero(std::ssize(term), std::ssize(term)));
    }
    result.log_likelihood = -profile(at.model, none, VectorXd(0), false).minus_log_likelihood;
  }
  return result;
}

LindstromBates::LindstromBates(const NonlinearModel& model,
                               const PooledFit& pooled,
                               const VarianceFunction& variance,
                               const MixedEffectsOptions& options,
                               bool is_correlated)
    : model_(model),
      options_(options),
      variance_text_(variance.text()),
      random_(model.random_coefficients()),
      pooled_(pooled),
      all_(static_cast<std::size_t>(pooled.coefficients.size())),
      scale_(pooled.scale),
      mixing_(pooled.mixing),
      variance_(variance, residual_data(model, is_correlated)),
      is_normalized_(normalized(variance)),
      linearizer_(model, variance_) {
  std::iota(all_.begin(), all_.end(), Index{0});
  make_factors();
}

void LindstromBates::make_factors() {
  factors_.clear();
  for (std::size_t t = 0; t < random_.size(); ++t) {
    factors_.emplace_back(model_.specification().random[t], VectorXd(scale_(random_[t])));
  }
}

Index LindstromBates::random_parameter_count() const {
  Index count = 0;
  for (const RelativeFactor& factor : factors_) count += factor.parameter_count();
  return count;
}

RelativeFactors LindstromBates::factors(const VectorXd& theta) const {
  RelativeFactors result(factors_.size());
  for_each_term([&](std::size_t t, const RelativeFactor& factor, Index begin) {
    result[t] = factor.factor(theta.segment(begin, factor.parameter_count()));
  });
  return result;
}

void LindstromBates::set_factors(const RelativeFactors& factors, VectorXd& theta) const {
  for_each_term([&](std::size_t t, const RelativeFactor& factor, Index begin) {
    theta.segment(begin, factor.parameter_count()) = factor.from_factor(factors[t]);
  });
}

double LindstromBates::typical_deviation(std::size_t term) const {
  return 1.0 / (kStartDivisor * std::sqrt(static_cast<double>(model_.observations()) /
                                          static_cast<double>(model_.group_count(term))));
}

LindstromBatesState LindstromBates::start(double spread) {
  adopt_units(pooled_.scale, pooled_.mixing);
  LindstromBatesState state{
      .scale = pooled_.scale,
      .mixing = pooled_.mixing,
      .beta = scaled_values(all_, pooled_.coefficients),
      .spherical = std::vector<MatrixXd>(factors_.size()),
      .theta = VectorXd(random_parameter_count() + variance_.parameter_count())};
  for_each_term([&](std::size_t t, const RelativeFactor& factor, Index begin) {
    const Index groups = model_.group_count(t);
    state.spherical[t].setZero(factor.size(), groups);
    // In scaled coordinates the mean square of each column of Z is one at the start.
    state.theta.segment(begin, factor.parameter_count()) =
        factor.from_diagonal(VectorXd::Constant(factor.size(), spread * typical_deviation(t)));
  });
  state.theta.tail(variance_.parameter_count()) = variance_.start();
  return state;
}

LindstromBatesState LindstromBates::with_theta(const LindstromBatesState& state,
                                               const VectorXd& theta) const {
  LindstromBatesState moved = state;
  moved.theta = theta;
  const RelativeFactors from = factors(state.theta);
  const RelativeFactors to = factors(theta);
  // The same effects, as far as the other factor can represent them.
  for (std::size_t t = 0; t < to.size(); ++t) {
    moved.spherical[t] = spherical_effects(to[t], from[t] * state.spherical[t]);
  }
  return moved;
}

SmallerVariance LindstromBates::variance_of(const LindstromBatesOutcome& outcome) const {
  const double n = static_cast<double>(model_.observations());
  return {.state = outcome.state,
          .quantities = variance_.quantities(),
          .parameters = variance_parameters(outcome.state.theta),
          .mean_log = is_normalized_ ? 0.0 : outcome.at->model.moments.sum_log()[0] / n,
          .log_likelihood = outcome.log_likelihood,
          .converged = outcome.converged};
}

LindstromBatesState LindstromBates::start_from(const SmallerVariance& smaller,
                                               const std::vector<std::size_t>& factors_of) {
  VectorXd parameters = variance_.start();
  for (const VarianceModel::Quantity& quantity : variance_.quantities()) {
    bool is_known = false;
    bool has_factor = false;
    for (const VarianceModel::Quantity& from : smaller.quantities) {
      if (factors_of[from.factor] != quantity.factor) continue;
      has_factor = true;
      if (from.kind != quantity.kind) continue;
      is_known = true;
      auto target = parameters.segment(quantity.first, quantity.count);
      if (from.count == quantity.count) {
        target = smaller.parameters.segment(from.first, from.count);
      } else {
        target.setConstant(smaller.parameters[from.first]);
      }
    }
    // The constant that a pure power lacks; it is positive, because zero is a stationary point.
    constexpr double kSmall = 0.1;
    if (has_factor && !is_known) {
      parameters.segment(quantity.first, quantity.count) *= kSmall;
    }
  }
  LindstromBatesState state = smaller.state;
  state.theta.resize(random_parameter_count() + parameters.size());
  state.theta.head(random_parameter_count()) = smaller.state.theta.head(random_parameter_count());
  state.theta.tail(parameters.size()) = parameters;
  // Psi / sigma^2 with the new scale of sigma.
  adopt_units(state.scale, state.mixing);
  Linearization at;
  if ((!is_normalized_ || smaller.mean_log != 0.0) && linearize(state, nullptr, at)) {
    const double mean_log =
        at.model.moments.sum_log()[0] / static_cast<double>(model_.observations());
    state.theta.head(random_parameter_count()) *= std::exp(mean_log - smaller.mean_log);
    for (MatrixXd& of_term : state.spherical) of_term *= std::exp(smaller.mean_log - mean_log);
  }
  return state;
}

bool LindstromBates::has_unbounded_range(const LindstromBatesState& state) const {
  return variance_.correlated() != nullptr &&
         variance_.correlated()->structure().has_unbounded_range(
             variance_.correlation_part(variance_parameters(state.theta)));
}

bool LindstromBates::is_limit(const LindstromBatesOutcome& outcome) {
  if (!outcome.converged) return false;
  const bool has_constant =
      std::ranges::any_of(variance_.quantities(), [](const VarianceModel::Quantity& quantity) {
        return quantity.kind == VarianceQuantity::kConstant;
      });
  return has_unbounded_range(outcome.state) ||
         (has_constant && has_unbounded_power(model_, result(outcome)));
}

double LindstromBates::log_units() const {
  return -2.0 * scale_.head(model_.coefficient_count()).array().log().sum();
}

MatrixXd LindstromBates::own_values(const std::vector<Index>& columns,
                                    const MatrixXd& scaled) const {
  const MatrixXd result = VectorXd(scale_(columns)).asDiagonal() * scaled;
  return mixing_.size() == 0 || columns.empty() ? result
                                                : MatrixXd(mixing_(columns, columns) * result);
}

MatrixXd LindstromBates::scaled_values(const std::vector<Index>& columns,
                                       const MatrixXd& own) const {
  MatrixXd result = own;
  if (mixing_.size() > 0 && !columns.empty())
    result = MatrixXd(mixing_(columns, columns)).partialPivLu().solve(own);
  return VectorXd(scale_(columns)).cwiseInverse().asDiagonal() * result;
}

void LindstromBates::adopt_units(const VectorXd& scale, const MatrixXd& mixing) {
  scale_ = scale;
  mixing_ = mixing;
  make_factors();
}

bool LindstromBates::rescale(LindstromBatesState& state, Linearization& at) {
  const VectorXd size = column_sizes(at);
  if (size.size() == 0) return false;
  if (remix(state, at)) return true;
  if (size.maxCoeff() < kUnsuitable && size.minCoeff() > 1.0 / kUnsuitable) return false;
  RelativeFactors scaled = factors(state.theta);
  for (std::size_t t = 0; t < scaled.size(); ++t) {
    scaled[t] = VectorXd(size(random_[t])).asDiagonal() * scaled[t];
  }
  state.scale = state.scale.cwiseQuotient(size);
  state.beta = state.beta.cwiseProduct(size.head(state.beta.size()));
  at.model.moments.divide_columns(size);
  adopt_units(state.scale, state.mixing);
  at.model.log_units = log_units();
  set_factors(scaled, state.theta);
  return true;
}

bool LindstromBates::remix(LindstromBatesState& state, Linearization& at) {
  const double distance = distance_from_dependence(at);
  if (distance >= kNearDependence) return false;
  LindstromBatesState mixed = state;
  const MatrixXd effects = own_effects(state);
  mixed.mixing =
      mixing_at(model_, effects.colwise() + model_.extended(own_values(all_, state.beta)));
  RelativeFactors moved = factors(state.theta);
  for (std::size_t t = 0; t < moved.size(); ++t) moved[t] = own_values(random_[t], moved[t]);
  const auto adopt = [&](const LindstromBatesState& of) { adopt_units(of.scale, of.mixing); };
  const VectorXd beta = own_values(all_, state.beta);
  adopt(mixed);
  mixed.beta = scaled_values(all_, beta);
  for (std::size_t t = 0; t < moved.size(); ++t) moved[t] = scaled_values(random_[t], moved[t]);
  set_factors(moved, mixed.theta);
  Linearization there;
  constexpr double kBetter = 10.0;
  if (!linearize(mixed, nullptr, there) ||
      !(distance_from_dependence(there) > kBetter * distance)) {
    adopt(state);
    return false;
  }
  state = std::move(mixed);
  at = std::move(there);
  return true;
}

MatrixXd LindstromBates::own_effects(const LindstromBatesState& state) const {
  const RelativeFactors now = factors(state.theta);
  MatrixXd result = MatrixXd::Zero(scale_.size(), model_.group_count());
  std::vector<MatrixXd> effects;
  for (std::size_t t = 0; t < now.size(); ++t) {
    effects.push_back(own_values(random_[t], now[t] * state.spherical[t]));
  }
  add_group_effects(model_.groups(), random_, effects, result);
  return result;
}

bool LindstromBates::linearize(const LindstromBatesState& state,
                               const Linearization* before,
                               Linearization& at) {
  if (passes_left_ <= 0) return false;
  --passes_left_;
  ++work_.passes;
  const LinearizationPoint point{.coefficients = model_.extended(own_values(all_, state.beta)),
                                 .effects = own_effects(state),
                                 .variance = variance_parameters(state.theta),
                                 .units = scale_,
                                 .mixing = mixing_};
  at.model.restricted = options_.reml;
  at.model.log_units = log_units();
  return linearizer_.linearize(point, true, before, at);
}

LinearMixedProfile LindstromBates::profile_at(const Linearization& at,
                                              const VectorXd& theta,
                                              bool with_derivatives) const {
  const Index parameters = at.model.moments.parameters();
  VectorXd displacement(parameters);
  if (parameters > 0) {
    displacement = variance_parameters(theta) - at.variance;
    if ((displacement.array().abs() > at.longest_change.array()).any()) return {};
  }
  return profile(at.model, factors(theta), displacement, with_derivatives);
}

LinearMixedProfile LindstromBates::profile_near(const LindstromBatesState& state,
                                                const Linearization& at,
                                                const VectorXd& theta) {
  model_.check_stop();
  if (!linearizer_.is_curved() || variance_parameters(theta) == at.variance) {
    return profile_at(at, theta, true);
  }
  // The likelihood of constant-plus-power has ridges and several maxima, for which the series of
  // the weights is not accurate enough.
  LindstromBatesState moved = state;
  moved.theta.tail(variance_.parameter_count()) = variance_parameters(theta);
  Linearization there;
  if (!linearize(moved, nullptr, there)) return {};
  return profile_at(there, theta, true);
}

VectorXd LindstromBates::gradient(const VectorXd& theta, const LinearMixedProfile& at) const {
  VectorXd result = VectorXd::Zero(random_parameter_count() + variance_.parameter_count());
  for_each_term([&](std::size_t t, const RelativeFactor& factor, Index begin) {
    const auto own = theta.segment(begin, factor.parameter_count());
    result.segment(begin, own.size()) = factor.gradient(own, at.by_factor[t]);
  });
  if (at.by_variance.size() > 0) result.tail(variance_.parameter_count()) = at.by_variance;
  return result;
}

double LindstromBates::take_step(LindstromBatesState& state,
                                 Linearization& at,
                                 const LinearMixedProfile& target) {
  // The squares of each group with those of its effects of the last term.
  const bool is_crossed = model_.crossed() != nullptr;
  const auto penalized = [is_crossed](VectorXd squares, const LindstromBatesState& of) {
    if (!of.spherical.empty() && !is_crossed)
      squares += of.spherical.back().colwise().squaredNorm().transpose();
    return squares;
  };
  const VectorXd current = penalized(at.squares, state);
  const double total = at.squares.sum() + state.penalty();
  // A few diverging groups must not slow the others: first only their effects take shorter steps.
  // If that is not sufficient, all steps are shortened together, until the objective decreases.
  constexpr int kGroupTrials = 6;
  constexpr int kTrials = 36;
  std::vector<VectorXd> lengths;  // of the groups of each term, relative to that of all
  const auto lengthen = [&] {
    lengths.clear();
    for (const MatrixXd& of : state.spherical) lengths.emplace_back(VectorXd::Ones(of.cols()));
  };
  lengthen();
  double length = 1.0;
  for (int attempt = 0; attempt < kTrials; ++attempt) {
    LindstromBatesState trial = state;
    trial.beta += length * target.coefficients;
    for (std::size_t t = 0; t < lengths.size(); ++t) {
      const MatrixXd change = target.spherical[t] - state.spherical[t];
      trial.spherical[t] += length * change * lengths[t].asDiagonal();
    }
    Linearization point;
    if (passes_left_ <= 0) return 0.0;
    const bool is_finite = linearize(trial, &at, point);
    if (is_finite && point.squares_before.sum() + trial.penalty() <= total * (1.0 + 1e-13)) {
      state = std::move(trial);
      at = std::move(point);
      return length;
    }
    const VectorXd reached = penalized(point.squares_before, trial);
    Index shortened = 0;
    for (Index cluster = 0, j = 0; j < reached.size(); ++j) {
      while (j >= model_.cluster_begin(cluster + 1)) ++cluster;
      // Crossed effects move many groups.
      if (reached[j] <= current[j] + 0.1 * total || lengths.empty() || is_crossed) continue;
      if (lengths.size() > 1) lengths.front()[cluster] *= 0.5;
      lengths.back()[j] *= 0.25;
      ++shortened;
    }
    if (attempt < kGroupTrials && shortened > 0) continue;
    lengthen();
    length *= 0.5;
  }
  return 0.0;
}

SquaresEnd LindstromBates::penalized_least_squares(LindstromBatesState& state,
                                                   Linearization& at,
                                                   double tolerance) {
  if (!linearize(state, nullptr, at)) return SquaresEnd::kFailed;
  constexpr int kSteps = 100;
  // Many consecutive short steps do not lead to a solution.
  constexpr double kShort = 0.1;
  int short_steps = 0;
  double last_decrement = kInfinity;
  for (int step = 0; step < kSteps; ++step) {
    const LinearMixedProfile target = profile_at(at, state.theta, true);
    if (!target.is_valid) return SquaresEnd::kFailed;
    const double current = at.squares.sum() + state.penalty();
    const double decrement = (current - target.sum_of_squares) / target.sigma2;
    constexpr double kEnough = 1e-12;
    constexpr double kRounded = 1e-6;
    // The steps converge slowly, or not at all because of rounding.
    const bool is_slow = decrement < tolerance && decrement >= 0.5 * last_decrement;
    const bool is_rounded = decrement < kLoosestSquares && decrement >= last_decrement;
    if (is_rounded) return SquaresEnd::kRounded;
    if (decrement <= kEnough || is_slow) return SquaresEnd::kReached;
    last_decrement = decrement;
    const double length = take_step(state, at, target);
    if (length == 0.0) return decrement < kRounded ? SquaresEnd::kRounded : SquaresEnd::kFailed;
    short_steps = length < kShort ? short_steps + 1 : 0;
    if (short_steps > short_steps_) return SquaresEnd::kFailed;
  }
  return SquaresEnd::kLimit;
}

}  // namespace silvafit::fit
