// SPDX-License-Identifier: MIT
#include "mixed_effects/boundary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "conditional_modes/sparse_factor.hpp"
#include "correlation/correlation_structure.hpp"
#include "model/correlated_rows.hpp"
#include "model/model_groups.hpp"
#include "model/symmetric_eigen.hpp"
#include "optimization/tolerances.hpp"
#include "result/group_coefficients.hpp"
#include "variance/variance_kind.hpp"
#include "verdict/thresholds.hpp"

namespace silvafit::fit {
namespace {

/// The random effects of one grouping.
struct GroupingCovariance {
  const std::vector<std::string>& names;
  const MatrixXd& covariance;
  const MatrixXd& frame;  ///< coordinates of the effects
  bool has_equal_variances = false;
  std::string group{};  ///< " | stand" in the name, if there are two groupings
};

/// Random effects whose standard deviation changes the mean by a negligible part of the residual
/// standard deviation. One that is shared has vanished if it does so for all effects.
std::vector<Evidence> vanished_effects(const NonlinearModel& model,
                                       const GroupingCovariance& level,
                                       const VectorXd& slopes,
                                       double residual_sd) {
  std::vector<Evidence> result;
  for (std::size_t k = 0; k < level.names.size(); ++k) {
    const auto at = static_cast<Index>(k);
    const double effect =
        std::sqrt(level.covariance(at, at)) * slopes[model.coefficient_index(level.names[k])];
    if (effect < Thresholds::kShareOfSigma * residual_sd) {
      result.push_back(
          {.term = fmt::format("sd({}{})", level.names[k], level.group), .value = 0.0});
    }
  }
  if (level.has_equal_variances && result.size() < level.names.size()) result.clear();
  return result;
}

/// Whether the covariance of the effects is positive definite in orthogonal coordinates. A
/// covariate with a large mean makes correlations nearly 1 in the coordinates of the coefficients.
bool is_inside_in_frame(const GroupingCovariance& level) {
  if (level.frame.isDiagonal(0.0)) return false;
  const auto frame = level.frame.triangularView<Eigen::Lower>();
  const MatrixXd half = frame.solve(level.covariance);
  const MatrixXd correlation = correlation_of(frame.solve(half.transpose()));
  return correlation.allFinite() &&
         symmetric_eigen(correlation).values[0] >= Thresholds::kDependence;
}

/// Correlations of 1 or -1, or a linear dependence of three or more effects.
std::vector<Evidence> dependent_effects(const GroupingCovariance& level) {
  std::vector<Evidence> result;
  const MatrixXd correlation = correlation_of(level.covariance);
  if (!correlation.allFinite() || correlation.rows() < 2) return result;
  if (is_inside_in_frame(level)) return result;
  for (Index i = 0; i < correlation.rows(); ++i) {
    for (Index j = 0; j < i; ++j) {
      if (1.0 - std::abs(correlation(i, j)) > Thresholds::kDependence) continue;
      result.push_back({.term = fmt::format("cor({}, {}{})",
                                            level.names[static_cast<std::size_t>(j)],
                                            level.names[static_cast<std::size_t>(i)],
                                            level.group),
                        .value = correlation(i, j) > 0 ? 1.0 : -1.0});
    }
  }
  if (result.empty() && symmetric_eigen(correlation).values[0] < Thresholds::kDependence) {
    result.push_back({.term = fmt::format("the random effects {}{} depend linearly on each other",
                                          fmt::join(level.names, ", "),
                                          level.group)});
  }
  return result;
}

std::vector<Evidence> boundary_of(const NonlinearModel& model,
                                  const PopulationSlopes& slopes,
                                  const MixedEffectsFit& fit) {
  const ModelSpecification& specification = model.specification();
  std::vector<GroupingCovariance> levels;
  const std::size_t terms = specification.random.size();
  for (std::size_t k = terms; k-- > 0;) {
    levels.push_back({fit.random[k].names,
                      fit.random[k].covariance,
                      slopes.frame.effects[k],
                      specification.random[k].has_equal_variances(),
                      terms > 1 ? " | " + specification.random[k].group_name() : ""});
  }
  std::vector<Evidence> result;
  for (const GroupingCovariance& level : levels) {
    std::vector<Evidence> found =
        vanished_effects(model, level, slopes.sizes, fit.residual_sd.mean());
    if (found.empty()) found = dependent_effects(level);
    result.insert(result.end(), found.begin(), found.end());
  }
  return result;
}

/// (N) the share of the power in constant-plus-power.
VectorXd power_shares(const VarianceFactorEstimate& factor,
                      const VectorXd& v,
                      const std::vector<Index>& stratum_of) {
  VectorXd result(v.size());
  for (Index i = 0; i < v.size(); ++i) {
    const Index s = stratum_of.empty() ? 0 : stratum_of[static_cast<std::size_t>(i)];
    const double constant = factor.constant[std::min(s, factor.constant.size() - 1)];
    const double delta = factor.delta[std::min(s, factor.delta.size() - 1)];
    const double log_v = std::log(std::max(std::abs(v[i]), 1e-300));
    result[i] = 1.0 / (1.0 + std::exp(std::log(constant) - delta * log_v));
  }
  return result;
}

/// \param rows  those with the exponent
PowerUse power_use(const std::vector<Index>& rows,
                   double delta,
                   const VectorXd& share,
                   const VectorXd& v) {
  // Without the power at some observations the log-likelihood falls by at most the sum of their
  // squared shares, since its slope is zero. The same holds for the constant.
  const VectorXd own = share(rows);
  const Index top = *std::ranges::max_element(rows, {}, [&](Index i) { return share[i]; });
  PowerUse result{.delta = delta,
                  .is_absent = own.squaredNorm() < kSameLikelihood,
                  .is_alone = (1.0 - own.array()).square().sum() < kSameLikelihood};
  if (result.is_absent || result.is_alone) return result;
  const double size = std::abs(v[top]);
  double others = 0.0;
  bool has_others = false;
  for (const Index i : rows) {
    if (std::abs(v[i]) == size) continue;
    others += share[i] * share[i];
    has_others = true;
  }
  // Of fitted values the steepest power is that of the response.
  constexpr double kNearly = 0.9;
  const double steepest = constant_plus_power_variance().typical(v(rows)).steepest();
  const bool is_steepest = std::abs(delta) > kNearly * steepest;
  if (has_others && (others < kSameLikelihood || is_steepest)) result.only_at = size;
  const Index count = (own.array() > Thresholds::kCounts / (1.0 + Thresholds::kCounts)).count();
  const double most = std::abs(delta) > Thresholds::kSteep ? 1.0 : Thresholds::kFew;
  if (static_cast<double>(count) < most * static_cast<double>(own.size())) result.few = count;
  return result;
}

/// (N x Q) the columns of the random effects of all terms, times a root of their covariance and
/// divided by the residual standard deviations.
MatrixXd effects_over_residuals(const NonlinearModel& model, const MixedEffectsFit& fit) {
  const MatrixXd jacobian = model.curve_at(group_coefficients(model, fit)).jacobian;
  MatrixXd result(jacobian.rows(), 0);
  for (std::size_t t = 0; t < model.term_count(); ++t) {
    const MatrixXd root = covariance_factor(fit.random[t].covariance);
    const Index before = result.cols();
    result.conservativeResize(Eigen::NoChange, before + root.cols());
    result.rightCols(root.cols()) =
        jacobian(Eigen::all, model.coefficients_of(model.specification().random[t])) * root;
  }
  result.array().colwise() /= fit.residual_sd.array();
  return result;
}

/// (Q x cells) the places of the random effects of the cells of a cluster, and their number.
std::pair<Eigen::MatrixXi, Index> effect_places(const NonlinearModel& model, Index cluster) {
  const Index first = model.cluster_begin(cluster);
  const Index cells = model.cluster_begin(cluster + 1) - first;
  Eigen::MatrixXi places(0, cells);
  Index size = 0;
  for (std::size_t t = 0; t < model.term_count(); ++t) {
    const std::vector<Index>& begin = model.groups().cluster_begin[t];
    const auto c = static_cast<std::size_t>(cluster);
    const Index q = std::ssize(model.coefficients_of(model.specification().random[t]));
    const Index before = places.rows();
    places.conservativeResize(before + q, Eigen::NoChange);
    for (Index cell = 0; cell < cells; ++cell) {
      const Index of_group = size + q * (model.group_of(t, first + cell) - begin[c]);
      for (Index k = 0; k < q; ++k) places(before + k, cell) = static_cast<int>(of_group + k);
    }
    size += q * (begin[c + 1] - begin[c]);
  }
  return {std::move(places), size};
}

/// (N) the share of the residual variance in the variance of each observation given all others:
/// r_i (V^-1)_ii, with V = Z Psi Z' of all terms + R.
VectorXd residual_shares(const NonlinearModel& model, const MixedEffectsFit& fit) {
  const MatrixXd effects = effects_over_residuals(model, fit);
  VectorXd result(effects.rows());
  for (Index cluster = 0; cluster < model.cluster_count(); ++cluster) {
    const Index first = model.cluster_begin(cluster);
    const Index end = model.cluster_begin(cluster + 1);
    const auto rows_of = [&](Index cell) {
      const Index begin = model.group_begin(cell);
      return effects.middleRows(begin, model.group_begin(cell + 1) - begin);
    };
    auto [places, size] = effect_places(model, cluster);
    const SparsePattern pattern(size, std::move(places));
    SparseFactor factor;
    factor.begin(pattern, 1.0);
    for (Index cell = first; cell < end; ++cell) {
      factor.add(cell - first, SmallMatrix(rows_of(cell).transpose() * rows_of(cell)));
    }
    if (!effects.allFinite() || !factor.factorize())
      return VectorXd::Constant(effects.rows(), kNaN);
    factor.invert();
    for (Index cell = first; cell < end; ++cell) {
      const auto own = rows_of(cell);
      const MatrixXd explained = own * factor.inverse_block(cell - first);
      result.segment(model.group_begin(cell), own.rows()) =
          1.0 - explained.cwiseProduct(own).rowwise().sum().array();
    }
  }
  return result;
}

/// Whether the correlations of all rows are negligible: |R| is the product of 1 - r^2, r the
/// correlations with the rows before.
bool is_independent(const NonlinearModel& model, const CorrelationEstimate& estimate) {
  double sum = 0.0;
  for (const auto& factor : CorrelatedRows::of(model, &estimate)->factors(estimate)) {
    sum -= 2.0 * factor->log_determinant();
  }
  return sum < Thresholds::kDependence * Thresholds::kDependence;
}

/// The ends of a structure whose partial autocorrelations are at 1 or -1.
void add_arma_ends(const CorrelationEstimate& estimate,
                   const VectorXd& partials,
                   std::vector<Evidence>& result) {
  const Index p = estimate.correlation.autoregressive;
  const auto add = [&](Index first, Index count, const char* what) {
    const VectorXd own = partials.segment(first, count);
    if (count == 0 || 1.0 - own.cwiseAbs().maxCoeff() > Thresholds::kDependence) return;
    if (count == 1) {
      result.push_back({.term = estimate.names[static_cast<std::size_t>(first)],
                        .value = std::copysign(1.0, own[0])});
    } else {
      result.push_back({.term = what});
    }
  };
  add(0, p, "the autoregression is at its limit of stationarity");
  add(p, partials.size() - p, "the moving average is at its limit of invertibility");
}

/// Ends of the ranges of the residuals' correlation that a fit has reached.
struct CorrelationEnds {
  /// Where a structure with fewer parameters has the same correlation.
  std::vector<Evidence> simpler{};
  std::vector<Evidence> others{};
};

CorrelationEnds correlation_ends(const NonlinearModel& model, const MixedEffectsFit& fit) {
  using Kind = Correlation::Kind;
  CorrelationEnds result;
  if (!fit.variance.correlation || !fit.variance.correlation->values.allFinite()) return result;
  const CorrelationEstimate& estimate = *fit.variance.correlation;
  const Kind kind = estimate.correlation.kind;
  const CorrelationStructure structure(estimate);
  const VectorXd& values = estimate.values;
  const std::string& name = estimate.names.front();
  if (kind == Kind::kArma) {
    add_arma_ends(estimate, (0.5 * structure.unconstrained(values)).array().tanh(), result.others);
    return result;
  }
  if (kind == Kind::kSymmetric) {
    if (least_variance(estimate) < Thresholds::kDependence) {
      result.others.push_back({.term = "the correlations of the times depend on each other"});
    }
    return result;
  }
  // The correlation at a typical smallest distance, of ar1 with the sign of phi.
  const double nearest =
      kind == Kind::kAr1 || kind == Kind::kCompoundSymmetry
          ? std::copysign(std::pow(std::abs(values[0]), estimate.unit), values[0])
          : structure.at(structure.unconstrained(values))
                ->between(estimate.unit, 0.0, 0.0, nullptr);
  const bool has_nugget = estimate.correlation.has_nugget;
  const double nugget = has_nugget ? values[1] : 0.0;
  const auto [low, high] = structure.limits(0);
  // Near 0 powers of phi have no slope.
  const bool is_power = kind == Kind::kAr1 && estimate.unit > 1.0;
  const bool has_no_slope = is_power && std::abs(nearest) < Thresholds::kDependence;
  const bool can_be_negative = low < 0.0 && !has_no_slope;
  if (1.0 - nearest / (1.0 - nugget) < Thresholds::kDependence) {
    const bool is_range = std::isinf(high);
    result.others.push_back(
        {.term = is_range ? "the range of the correlation is without bound" : name,
         .value = is_range ? kNaN : high});
  } else if (can_be_negative) {
    if (nearest - low < Thresholds::kDependence * (high - low)) {
      result.others.push_back({.term = name, .value = low});
    }
  } else if (nearest < Thresholds::kDependence && is_independent(model, estimate)) {
    const bool is_nugget = has_nugget && 1.0 - nugget < Thresholds::kDependence;
    result.simpler.push_back({.term = is_nugget ? "nugget" : name, .value = is_nugget ? 1.0 : 0.0});
    return result;
  }
  if (has_nugget && nugget < Thresholds::kDependence) {
    result.simpler.push_back({.term = "nugget", .value = 0.0});
  }
  return result;
}

}  // namespace

std::vector<std::string> strata_without_residuals(const NonlinearModel& model,
                                                  const MixedEffectsFit& fit) {
  std::vector<std::string> result;
  if (model.term_count() == 0 || fit.variance.correlation) return result;
  VectorXd shares;
  for (const VarianceFactorEstimate& factor : fit.variance.factors) {
    if (factor.factor.stratum.empty()) continue;
    if (shares.size() == 0) shares = residual_shares(model, fit);
    const NonlinearModel::Strata& strata = model.strata(factor.factor.stratum);
    VectorXd sums = VectorXd::Zero(std::ssize(strata.labels));
    for (Index i = 0; i < shares.size(); ++i) {
      sums[strata.of_rows[static_cast<std::size_t>(i)]] += shares[i] * shares[i];
    }
    for (Index s = 0; s < sums.size(); ++s) {
      const std::string& label = strata.labels[static_cast<std::size_t>(s)];
      const bool is_known = std::ranges::find(result, label) != result.end();
      if (sums[s] < kSameLikelihood && !is_known) result.push_back(label);
    }
  }
  return result;
}

double least_variance(const CorrelationEstimate& estimate) {
  using Kind = Correlation::Kind;
  const Kind kind = estimate.correlation.kind;
  if (!estimate.values.allFinite()) return 1.0;
  if (kind == Kind::kAr1 || kind == Kind::kCompoundSymmetry) {
    return 1.0 - std::pow(std::abs(estimate.values[0]), estimate.unit);
  }
  if (kind != Kind::kSymmetric) return 1.0;
  const Index times = std::ssize(estimate.times);
  MatrixXd correlation = MatrixXd::Identity(times, times);
  Index next = 0;
  for (Index i = 0; i < times; ++i) {
    for (Index j = i + 1; j < times; ++j) {
      correlation(i, j) = correlation(j, i) = estimate.values[next++];
    }
  }
  return symmetric_eigen(correlation).values[0];
}

PopulationSlopes population_slopes(const NonlinearModel& model, const MixedEffectsFit& fit) {
  MatrixXd jacobian = model.curve_at(model.extended(fit.estimate)).jacobian;
  const double root = std::sqrt(static_cast<double>(jacobian.rows()));
  PopulationSlopes result{.sizes = jacobian.colwise().norm() / root};
  result.frame = orthogonal_frame(model, std::move(jacobian), 1.0);
  return result;
}

VectorXd variable_of(const NonlinearModel& model,
                     const MixedEffectsFit& fit,
                     const VarianceFactorEstimate& factor) {
  const std::string& column = factor.factor.column;
  return column.empty() ? fit.fitted_conditional : model.column(column);
}

std::vector<PowerUse> power_uses(const NonlinearModel& model,
                                 const VarianceFactorEstimate& factor,
                                 const VectorXd& v) {
  if (factor.constant.size() == 0 || factor.factor.constant) return {};
  const bool has_strata = !factor.factor.stratum.empty();
  const std::vector<Index> stratum_of =
      has_strata ? model.strata(factor.factor.stratum).of_rows : std::vector<Index>();
  const VectorXd share = power_shares(factor, v, stratum_of);
  std::vector<std::vector<Index>> rows(static_cast<std::size_t>(factor.delta.size()));
  for (Index i = 0; i < v.size(); ++i) {
    const bool is_own = has_strata && rows.size() > 1;
    rows[is_own ? static_cast<std::size_t>(stratum_of[static_cast<std::size_t>(i)]) : 0].push_back(
        i);
  }
  std::vector<PowerUse> result;
  for (std::size_t s = 0; s < rows.size(); ++s) {
    if (rows[s].empty()) continue;
    PowerUse use = power_use(rows[s], factor.delta[static_cast<Index>(s)], share, v);
    if (rows.size() > 1) use.stratum = factor.strata[s];
    result.push_back(std::move(use));
  }
  return result;
}

std::vector<std::string> name_boundary(const NonlinearModel& model,
                                       const PopulationSlopes& slopes,
                                       MixedEffectsFit& fit) {
  for (const Evidence& found : boundary_of(model, slopes, fit)) fit.convergence.add_boundary(found);
  for (const VarianceFactorEstimate& factor : fit.variance.factors) {
    for (const PowerUse& use : power_uses(model, factor, variable_of(model, fit, factor))) {
      const std::string of = use.stratum.empty() ? "" : " of " + use.stratum;
      if (use.is_absent) {
        fit.convergence.add_boundary({.term = fmt::format("the variance{} is constant", of)});
      } else if (use.is_alone) {
        fit.convergence.add_boundary(
            {.term = fmt::format("the constant of the variance function{}", of), .value = 0.0});
      }
    }
  }
  const CorrelationEnds ends = correlation_ends(model, fit);
  for (const Evidence& end : ends.simpler) fit.convergence.add_boundary(end);
  std::vector<std::string> others;
  for (const Evidence& end : ends.others) {
    others.push_back(text_of(end));
    fit.convergence.add_boundary(end);
  }
  return others;
}

}  // namespace silvafit::fit
