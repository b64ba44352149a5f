// SPDX-License-Identifier: MIT
#include "optimum_search/search_verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "model/simpler_model.hpp"
#include "optimization/tolerances.hpp"

namespace silvafit::fit {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// "a = 1.2, b = 3".
std::string estimates_text(const MixedEffectsFit& fit, const VectorXd& estimate) {
  std::vector<std::string> parts;
  for (Index j = 0; j < estimate.size(); ++j) {
    parts.push_back(fmt::format(
        "{} = {:.4g}", fit.coefficient_names[static_cast<std::size_t>(j)], estimate[j]));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

/// The likelihood by which optima are compared.
double rank_of(const LocalOptimum& optimum) {
  return std::isfinite(optimum.marginal_log_likelihood) ? optimum.marginal_log_likelihood
                                                        : optimum.log_likelihood;
}

/// The note on another optimum with a similar likelihood.
const LocalOptimum* close_optimum(const MixedEffectsFit& fit) {
  const auto found =
      std::find_if(fit.optima.begin() + 1, fit.optima.end(), [&](const LocalOptimum& optimum) {
        return rank_of(optimum) > rank_of(fit.optima.front()) - kDoubtful;
      });
  return found == fit.optima.end() ? nullptr : &*found;
}

/// The best optimum, if the user's wishes exclude it; else null.
const LocalOptimum* higher_optimum(const MixedEffectsFit& fit) {
  const auto highest = std::ranges::max_element(fit.optima, {}, rank_of);
  return rank_of(*highest) > rank_of(fit.optima.front()) + kHigher ? &*highest : nullptr;
}

/// Difference of the linearized likelihood from the marginal one, at the estimates and at its
/// maximum; for restricted likelihood, that of the marginal one at the estimates from its maximum.
double linearization_error(const MixedEffectsFit& fit, const SearchEvidence& evidence) {
  if (evidence.is_restricted) {
    const double below = evidence.marginal_maximum - evidence.marginal_here;
    return std::isfinite(below) ? below : 0.0;
  }
  double error = 0.0;
  for (const double marginal : {evidence.marginal_here, evidence.marginal_maximum}) {
    if (std::isfinite(marginal)) error = std::max(error, std::abs(marginal - fit.log_likelihood));
  }
  return error;
}

/// The method of the marginal likelihood that ranks fits by Lindstrom and Bates' method.
std::string name_of(Integration ranking) {
  return ranking == Integration::kLaplace ? "laplace" : "focei";
}

void add_optimum(const LocalOptimum& optimum, Convergence& convergence) {
  convergence.evidence.push_back({.kind = Evidence::Kind::kOtherOptimum,
                                  .term = optimum.origin,
                                  .value = optimum.log_likelihood});
}

}  // namespace

std::optional<ContainedModel> higher_than(double rank,
                                          const std::vector<ContainedModel>& contained) {
  const auto highest = std::ranges::max_element(contained, {}, &ContainedModel::rank);
  if (highest == contained.end() || !(highest->rank > rank + kHigher)) return std::nullopt;
  // The simplest of those that are equally high: they come first.
  return *std::ranges::find_if(contained, [&](const ContainedModel& model) {
    return model.rank > std::max(rank, highest->rank - kHigher);
  });
}

void judge_search(const ModelSpecification& specification,
                  const SearchEvidence& evidence,
                  MixedEffectsFit& fit) {
  Convergence& convergence = fit.convergence;
  if (!convergence.converged()) return;
  constexpr double kUseless = 0.1;  // per observation
  const double useless =
      std::max(10.0 * kDoubtful, kUseless * static_cast<double>(fit.observations));
  if (evidence.contained) {
    convergence.evidence.push_back({.kind = Evidence::Kind::kContainedModel,
                                    .term = evidence.contained->text,
                                    .value = evidence.contained->log_likelihood});
    const double excess = evidence.contained->log_likelihood - fit.log_likelihood;
    // A fixed point of the alternation, which nlme reports as well, need not be the highest one.
    const bool is_doubt = !evidence.method && excess < useless;
    if (!is_doubt) convergence.status = ConvergenceStatus::kContainedModelHigher;
    const bool is_helped = evidence.marginal_maximum > evidence.contained->rank + kHigher;
    const std::string found = fmt::format(
        "{}: the model {}, which this one contains, has a higher log-likelihood ({:.2f} against "
        "{:.2f}). Use that model, or {}.",
        is_doubt ? "Converged, with a doubt" : "Not converged",
        evidence.contained->text,
        evidence.contained->log_likelihood,
        fit.log_likelihood,
        is_helped ? fmt::format("`method={0}`: {0} converges at {1:.2f}",
                                name_of(evidence.marginal),
                                evidence.marginal_maximum)
                  : "give other start values");
    if (!is_doubt) {
      convergence.verdict = found;
      return;
    }
    convergence.verdict = fmt::format("{} {}", found, convergence.verdict);
  }
  if (evidence.first_order_maximum > fit.log_likelihood + 10.0 * kDoubtful) {
    convergence.status = ConvergenceStatus::kInvalidApproximation;
    convergence.evidence.push_back({.kind = Evidence::Kind::kMarginalMaximum,
                                    .term = "focei",
                                    .value = evidence.first_order_maximum});
    convergence.verdict = fmt::format(
        "Not converged: the first-order likelihood (focei) has a far higher maximum ({:.2f} "
        "against {:.2f}), at which the conditional density of a group's random effects is flat at "
        "its mode and the likelihood of this method is not valid. Use `method=focei`.",
        evidence.first_order_maximum,
        fit.log_likelihood);
    return;
  }
  if (evidence.unfinished > fit.log_likelihood + kHigher) {
    convergence.status = ConvergenceStatus::kMaximumNotReached;
    convergence.evidence.push_back(
        {.kind = Evidence::Kind::kHigherEnd, .value = evidence.unfinished});
    convergence.verdict = fmt::format(
        "Not converged: the maximum shown has a log-likelihood of {:.2f}, but another start "
        "reached {:.2f} without converging. Use {}{}.",
        fit.log_likelihood,
        evidence.unfinished,
        evidence.method == Integration::kInteraction ? "" : "`method=focei`, or ",
        simpler_model(specification));
    return;
  }
  const double error = linearization_error(fit, evidence);
  const std::string method = name_of(evidence.marginal);
  if (error > kDoubtful) {
    convergence.evidence.push_back(
        {.kind = Evidence::Kind::kMarginal, .term = method, .value = evidence.marginal_here});
    convergence.evidence.push_back({.kind = Evidence::Kind::kMarginalMaximum,
                                    .term = method,
                                    .value = evidence.marginal_maximum});
  }
  if (!evidence.is_restricted && error > useless) {
    convergence.status = ConvergenceStatus::kInvalidApproximation;
    // The sentences after the first one remain valid: boundaries, floored values.
    const std::size_t end = convergence.verdict.find(". ");
    const std::string further =
        end == std::string::npos ? std::string() : convergence.verdict.substr(end + 1);
    convergence.verdict = fmt::format(
        "Not converged: the linearized log-likelihood {0:.2f} is far from the marginal one ({1}: "
        "{2:.2f} at these estimates, {3:.2f} at its maximum), so this method is not reliable here. "
        "Use `method={1}`.{4}",
        fit.log_likelihood,
        method,
        evidence.marginal_here,
        evidence.marginal_maximum,
        further);
    return;
  }
  if (error > kDoubtful) {
    convergence.verdict += fmt::format(
        " The linearization is doubtful here: the marginal log-likelihood ({0}) is {1:.2f} at "
        "these estimates and {2:.2f} at its maximum. Use `method={0}`.",
        method,
        evidence.marginal_here,
        evidence.marginal_maximum);
  }
  if (fit.optima.size() < 2) return;
  if (const LocalOptimum* const higher = higher_optimum(fit)) {
    add_optimum(*higher, convergence);
    convergence.verdict += fmt::format(
        " Another optimum is higher: log-likelihood {:.2f} at {}. The start values or bounds "
        "select the one that is shown ({:.2f}).",
        higher->log_likelihood,
        estimates_text(fit, higher->estimate),
        fit.log_likelihood);
    return;
  }
  const auto from_start = std::ranges::find(fit.optima, kStartValues, &LocalOptimum::origin);
  if (from_start != fit.optima.end() && from_start != fit.optima.begin()) {
    add_optimum(*from_start, convergence);
    convergence.verdict +=
        fmt::format(" The start values lead to a lower optimum: log-likelihood {:.2f} at {}.",
                    from_start->log_likelihood,
                    estimates_text(fit, from_start->estimate));
    return;
  }
  if (const LocalOptimum* const other = close_optimum(fit)) {
    add_optimum(*other, convergence);
    convergence.verdict += fmt::format(" Another optimum is close: log-likelihood {:.2f} at {}.",
                                       other->log_likelihood,
                                       estimates_text(fit, other->estimate));
  }
}

void judge_kinks(MixedEffectsFit& fit, const Kinks& kinks, const SearchEvidence& evidence) {
  Convergence& convergence = fit.convergence;
  if (kinks.coefficients.empty() || !convergence.converged()) return;
  const bool is_quadrature = evidence.method == Integration::kQuadrature;
  const double error = std::abs(kinks.by_quadrature - fit.log_likelihood);
  if (is_quadrature && !(error > kHigher)) return;
  std::string text = fmt::format(
      "the formula has a kink in {}, {}",
      fmt::join(kinks.coefficients, ", "),
      is_quadrature ? "where quadrature needs more points" : "where this method is not exact");
  if (std::isfinite(kinks.by_quadrature)) {
    convergence.evidence.push_back(
        {.kind = Evidence::Kind::kMarginal, .term = "agq", .value = kinks.by_quadrature});
    text += fmt::format(
        "; by quadrature with {} points per random effect the log-likelihood at these estimates is "
        "{:.2f}{}",
        kinks.points,
        kinks.by_quadrature,
        evidence.is_restricted ? "" : fmt::format(", not {:.2f}", fit.log_likelihood));
  }
  text += is_quadrature ? fmt::format(". Use `agq_points={}`.", kinks.points)
                        : ". Compare with `method=agq`.";
  convergence.verdict = fmt::format("Converged, with a doubt: {} {}", text, convergence.verdict);
}

}  // namespace silvafit::fit
