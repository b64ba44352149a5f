// SPDX-License-Identifier: MIT
// Nonlinear mixed-effects models, and generalized least squares as the case without random effects.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/enum_words.hpp"
#include "silvafit/fit/estimates.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The method of a fit.
enum class Method {
  kOrdinary,        ///< ordinary least squares, "ols"
  kGeneralized,     ///< with a variance function, without random effects, "gnls"
  kLindstromBates,  ///< mixed effects by Lindstrom and Bates' alternation, as R nlme: "lb"
  kFirstOrder,      ///< marginal likelihood, first order without interaction: "foce"
  kInteraction,     ///< the same with interaction: "focei"
  kLaplace,         ///< marginal likelihood by Laplace's method: "laplace"
  kQuadrature,      ///< marginal likelihood by adaptive Gauss-Hermite quadrature: "agq"
};
/// Whether a method estimates random effects.
bool is_mixed(Method method);
/// Whether a method maximizes a marginal likelihood, with the random effects integrated out.
bool is_marginal(Method method);
constexpr std::array<std::string_view, 7> words_of(Method /*method*/) {
  return {"ols", "gnls", "lb", "foce", "focei", "laplace", "agq"};
}

/// The extent of a search for the highest maximum.
enum class SearchEffort {
  /// By lb, one run from the pooled least-squares fit and from each given start; as kQuick by other
  /// methods.
  kBrief,
  /// From the pooled least-squares fit, and from others only if that does not converge.
  kQuick,
  /// From all known starting points, with checks of the maximum; docs/local-maxima.md.
  kThorough,
};

struct MixedEffectsOptions {
  /// (p) further start values; the result is the fit with the highest likelihood.
  std::vector<Eigen::VectorXd> starts{};
  int maximum_iterations = 200;  ///< of Lindstrom and Bates' method: alternations of the two steps
  /// Restricted maximum likelihood instead of maximum likelihood, by Lindstrom and Bates' method:
  /// of the model that is linear around the estimates (R nlme's REML).
  bool reml = false;
  /// Whether there is only one run from a start, even if it does not converge, instead of runs with
  /// other variance components.
  bool is_brief = false;
  int quadrature_points = 7;  ///< per random effect
  /// Called with one line for each iteration or value of a marginal likelihood, if given.
  std::function<void(const std::string&)> trace{};
};

/// A fitted model with its fitted values: G groups, N observations in the model's order.
struct MixedEffectsFit : Estimates {
  Eigen::VectorXd fitted_population{};   ///< (N) f(beta)
  Eigen::VectorXd fitted_conditional{};  ///< (N) f(beta + b)
  Eigen::VectorXd residual_sd{};         ///< (N) sigma g
  /// Number of fitted values too near zero for a power, which were floored.
  Eigen::Index floored_variances = 0;
};

/// Fits by maximum marginal likelihood.
///
/// Starts from a fit by Lindstrom and Bates' method, converged or not, and maximizes the likelihood
/// with its exact gradient until the Newton decrement vanishes. Standard errors are those of the
/// observed information. A failed fit is a result with converged = false and a message.
/// \param start   (p) start values: the pooled least-squares fit
/// \param method  foce, focei, laplace or agq
/// \throws UsageError without random effects, or if there are too many for quadrature, which takes
///   at most 3, of one grouping, and 20,000 points over them
/// Source: docs/marginal-likelihood.md.
MixedEffectsFit fit_marginal(const NonlinearModel& model,
                             const Eigen::VectorXd& start,
                             Method method,
                             const MixedEffectsOptions& options = {});

/// Fits by the method of Lindstrom and Bates, with one grouping or two nested ones: R nlme's
/// objective, by maximum or restricted maximum likelihood.
///
/// Alternates penalized nonlinear least squares in beta and b with the profile likelihood of the
/// model that is linear around them, until both do not change the estimates. Psi = sigma^2 L L'
/// is never inverted, so that a singular Psi is an ordinary point; the reported log-likelihood is
/// that of the linearized model, as in nlme. Without random effects it is generalized nonlinear
/// least squares (nlme's gnls). A failed fit is a result with converged = false and a message,
/// not an exception.
/// \param start  (p) start values: the pooled least-squares fit
/// Source: Lindstrom and Bates 1990, Biometrics 46, 673-687; Pinheiro and Bates 2000, chapters 5
/// and 7.
MixedEffectsFit fit_lindstrom_bates(const NonlinearModel& model,
                                    const Eigen::VectorXd& start,
                                    const MixedEffectsOptions& options = {});

}  // namespace silvafit::fit
