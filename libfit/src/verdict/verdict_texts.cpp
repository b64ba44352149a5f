// SPDX-License-Identifier: MIT
#include "verdict/verdict_texts.hpp"

#include <algorithm>

namespace silvafit::fit {

std::string_view text_of(Finding::Kind kind) {
  using enum Finding::Kind;
  struct Text {
    Finding::Kind kind;
    std::string_view text;
  };
  static constexpr Text kTexts[] = {
      {kText, "{a}"},
      {kMachinePrecision, "Converged to machine precision."},
      {kPerfectFit,
       "Perfect fit: sigma is 0 and the log-likelihood is infinite. Do not compare this model "
       "with others by these values."},
      {kAllHeld, "All coefficients are fixed; only sigma was estimated."},
      {kPublished, "Published model, not fitted by silvafit: {a}; {b}."},
      {kPoorlyDetermined,
       "Converged, but {names} [is|are] poorly determined (standard error more than ten times the "
       "estimate)."},
      {kSettledAlternations,
       "Converged after {x:.0f} alternation[|s]: further iterations change no estimate by more "
       "than {y:.0e} standard errors."},
      {kSettledEvaluations,
       "Converged after {x:.0f} evaluations: the maximum is within {y:.0e} standard errors of the "
       "estimates."},
      {kTooFewObservations,
       "{x:.0f} coefficients need at least as many observations, but there are {y:.0f}. Use a "
       "model with fewer coefficients or more data."},
      {kNoStart,
       "No start values were found at which the formula is finite for all observations. Give "
       "start values."},
      {kUndefinedDerivatives,
       "The derivatives of the formula became infinite or undefined during the search. Give start "
       "values, or use another model."},
      {kPerfectOnlyAtLimit, "Perfect fit, reached only while {unbounded}"},
      {kSquaresKeepFalling,
       "The sum of squares keeps decreasing, ever more slowly, while {unbounded}"},
      {kLikelihoodKeepsRising,
       "Not converged: the log-likelihood keeps increasing, ever more slowly, while {unbounded}"},
      {kLimitOfCurve,
       "Not converged: the log-likelihood has no maximum; it is as high as here, or higher, while "
       "{unbounded}"},
      {kUnboundedPower,
       "Not converged: the log-likelihood keeps increasing, ever more slowly, while {a} of {b} "
       "grows without bound: only the observations with {c} {x:.6g} have another variance. Use a "
       "power, or a stratum for these observations."},
      {kConfounded,
       "Not converged: {names} [is not identifiable: the mean does not depend on it. Remove "
       "it.|are not identifiable: their effects on the mean are linearly dependent. Remove one of "
       "them.]"},
      {kSteps,
       "Not converged: the mean changes with {names} by steps only, where an observation changes "
       "from one branch of the formula to another, so that a range of values has one likelihood. "
       "Fix [it|them] at one of them: fits with other values can be compared by their "
       "log-likelihoods."},
      {kNearlyConfounded,
       "Not converged: {names} are hardly identifiable: their effects on the mean are nearly "
       "linearly dependent. Remove one of them."},
      {kDependentEstimates,
       "Not converged: the coefficients are not identifiable: their estimates are linearly "
       "dependent. Remove a covariate or a parameter."},
      {kConfoundedVariances,
       "Not converged: {names} [is not identifiable: the likelihood does not depend on it. Remove "
       "it.|are not identifiable: their effects on the likelihood are linearly dependent.]"},
      {kUnseenCorrelation,
       "Not converged: {names} is not identifiable: no group has both effects. Fit them as "
       "independent effects, with `covariance=diagonal` or blocks."},
      {kNoMinimum,
       "No minimum was reached: the estimates are still {x:.2g} standard errors away. Give other "
       "start values or use a model with fewer coefficients."},
      {kStillChanging, "Not converged after {x:.0f} alternation[|s]: the estimates still change."},
      {kStillChangingBy,
       "Not converged after {x:.0f} alternation[|s]: the estimates still change by {y:.2g} "
       "standard errors."},
      {kNoMaximumFound,
       "Not converged after {x:.0f} evaluations of the likelihood: the best point found is not a "
       "maximum of the likelihood."},
      {kMaximumAway,
       "Not converged after {x:.0f} evaluations of the likelihood: the maximum is still {y:.2g} "
       "standard errors away."},
      {kNoClearMode,
       "Not converged: the likelihood increases towards points where the conditional density of a "
       "group's random effects is flat at its mode and the approximation is not valid."},
      {kDivergedAway,
       "Not converged: the search diverged to values at which the mean hardly depends on {names}. "
       "Use other start values, fewer random effects, or a curve with fewer coefficients."},
      {kPerfectByFixedEffects,
       "Not converged: perfect fit by the fixed effects alone. Remove the random effects."},
      {kNoFirstStep,
       "Not converged: the first penalized least-squares step found no finite value. Use "
       "{simpler}, or a model that fits the pooled data better."},
      {kSmallGroupsExact,
       "Not converged: no group of {a} has more observations than random effects, so these fit it "
       "perfectly and the residual standard deviation goes to 0. Use fewer random effects, or "
       "groups with more observations."},
      {kPerfectCurve,
       "Not converged: perfect fit: the model goes through all observations, so the residual "
       "standard deviation goes to 0 and the likelihood has no maximum. Check whether the "
       "response was computed from the covariates instead of measured."},
      {kSingularCorrelation,
       "Not converged: a combination of the residuals is 0 in every group, so that the likelihood "
       "of {a} has no maximum. Use a structure with fewer parameters, or more groups."},
      {kBeyondMeasure,
       "Not converged: {names} [grows|grow] without bound: at two standard deviations from the "
       "center, the curve is more than a million times the spread of the response away. The data "
       "do not support [this random effect; remove it|these random effects; remove them], or "
       "choose another variance function."},
      {kSaturated,
       "Not converged: {names} [grows|grow] without bound: at one standard deviation from the "
       "center, the curve no longer depends on the random effect[|s]. Remove [the random "
       "effect|one of them]."},
      {kImpossibleError,
       "Not converged: the information matrix is nearly singular: {x:.0f} groups whose {a} have a "
       "standard deviation of {y:.3g} cannot give their mean a standard error of {z:.2g}. The "
       "coefficients are hardly identifiable; fix or remove one of them."},
      {kInvalidAtFirstOrder,
       "Not converged: at the estimates of focei, which are shown, the conditional density of a "
       "group's random effects is flat at its mode, so the likelihood of this method is not valid "
       "there. Use `method=focei`, or {simpler}."},
      {kNoModes,
       "Not converged: no conditional mode of the random effects was found from any start. Use "
       "{simpler}, or a model that fits the pooled data better."},
      {kInvalidForSample,
       "Not converged: the likelihood of all data does not hold at the estimates of a sample of "
       "{x:.0f} observations, which are shown. Use fewer random effects, or `method=focei`."},
      {kFirstOrderHigher,
       "Not converged: the first-order likelihood (focei) has a far higher maximum ({x:.2f} "
       "against {y:.2f}), at which the conditional density of a group's random effects is flat at "
       "its mode and the likelihood of this method is not valid. Use `method=focei`."},
      {kContainedHigher,
       "Not converged: the model {a}, which this one contains, has a higher log-likelihood "
       "({x:.2f} against {y:.2f}). [Use that model, or give other start values|Use `method={b}`: "
       "{b} converges at {z:.2f}]."},
      {kUnfinishedHigher,
       "Not converged: the maximum shown has a log-likelihood of {x:.2f}, but another start "
       "reached {y:.2f} without converging. Use `method=focei`, or {simpler}."},
      {kUnfinishedFirstOrder,
       "Not converged: the maximum shown has a log-likelihood of {x:.2f}, but another start "
       "reached {y:.2f} without converging. Use {simpler}."},
      {kLinearizationFar,
       "Not converged: the linearized log-likelihood {x:.2f} is far from the marginal one ({a}: "
       "{y:.2f} at these estimates, {z:.2f} at its maximum), so this method is not reliable here. "
       "Use `method={a}`."},
      {kNoneFromStart, "Not converged from the start values of the original fit."},
      {kRisesInwards,
       "Not converged: with {b} the likelihood increases into the range of {a}, but no maximum "
       "was found there. Give start values or narrower bounds."},
      {kHeldImpossible, "Not converged: with {a} held, {b}"},
      {kVanishingConstant,
       "Not converged: the log-likelihood has no maximum: for {x:.0f} of the observations only the "
       "constant of {a} is left, and the curve passes through them exactly, so the constant goes "
       "to 0. Exclude such rows with `where`, hold the constant, or use another variance "
       "function."},
      {kVanishingStratum,
       "Not converged: the log-likelihood has no maximum: the curve passes through all "
       "observations of {names} exactly, so their standard deviation goes to 0. Join this stratum "
       "with another one, or exclude its rows with `where`."},
      {kRangeUnbounded,
       "Not converged: the likelihood increases as the range of the correlation grows without "
       "bound. Use another `correlation`, or random effects in its place."},
      {kFarVariance,
       "Not converged: the values of {a} are far from 0 compared with their range, so that sigma "
       "or the powers of the variance function are beyond the range of numbers. Use the "
       "exponential of a column with about {x:.6g} subtracted from {a} (`columns`), whose "
       "variances are nearly the same."},

      {kFallback, "Fitted by focei, because {a} found no result."},
      {kStartFailed, "Not converged: the least-squares fit for the start values failed."},
      {kNoneInside,
       "Not converged: no fit within the bounds was found. The fit without bounds is shown."},
      {kContainedDoubt,
       "Converged, with a doubt: the model {a}, which this one contains, has a higher "
       "log-likelihood ({x:.2f} against {y:.2f}). [Use that model, or give other start values|Use "
       "`method={b}`: {b} converges at {z:.2f}]."},
      {kKink,
       "Converged, with a doubt: the formula has a kink in {names}, where this method is not "
       "exact. Compare with `method=agq`."},
      {kKinkRestricted,
       "Converged, with a doubt: the formula has a kink in {names}, where this method is not "
       "exact; by quadrature with {x:.0f} points per random effect the log-likelihood at these "
       "estimates is {y:.2f}. Compare with `method=agq`."},
      {kKinkByQuadrature,
       "Converged, with a doubt: the formula has a kink in {names}, where this method is not "
       "exact; by quadrature with {x:.0f} points per random effect the log-likelihood at these "
       "estimates is {y:.2f}, not {z:.2f}. Compare with `method=agq`."},
      {kKinkFewPoints,
       "Converged, with a doubt: the formula has a kink in {names}, where quadrature needs more "
       "points; by quadrature with {x:.0f} points per random effect the log-likelihood at these "
       "estimates is {y:.2f}, not {z:.2f}. Use `agq_points={x:.0f}`."},
      {kFewPoints,
       "Converged, with a doubt: by quadrature with {x:.0f} points per random effect the "
       "log-likelihood at these estimates is {y:.2f}, not {z:.2f}. Use `agq_points={x:.0f}`."},
      {kRangeDoubt,
       "Converged, with a doubt: with a range of the correlation that grows without bound the "
       "log-likelihood is higher ({x:.2f} against {y:.2f}). Compare with random effects, or with "
       "`correlation=compound-symmetry`."},
      {kTwoValues,
       "The response {a} has two values only ({b} and {c}), but the residuals of this fit are "
       "taken as normal: its standard errors and tests are not valid. A binomial model suits it, "
       "such as glm() or lme4::glmer() with family = binomial in R."},
      {kCounts,
       "All values of {a} are whole numbers, some of them 0: if they are counts, their variance "
       "grows with the mean. Use `variance=power(delta = 0.5)`, or a Poisson or negative binomial "
       "model, such as glm(), MASS::glm.nb() or lme4::glmer() in R."},
      {kMissingCode,
       "The only value below 0 in the column {a} is {b}, in {x:.0f} of the rows: if this is a code "
       "of missing values, leave these fields empty, or name it with `missing={b}` where a file is "
       "read."},
      {kIsolatedCode,
       "The value {b} in {x:.0f} rows of the column {a} is far from all others: if this is a code "
       "of missing values, leave these fields empty, or name it with `missing={b}` where a file is "
       "read."},
      {kImputedRows,
       "{a} was imputed in {x:.0f} of the rows ({a}_source), by a model and not by measurement: "
       "estimates and their errors are not those of the measured rows. Use `where={a}_source == "
       "\"measured\"`."},
      {kCodesRead, "Codes read as missing values: {a}."},
      {kNameDoubt,
       "{a} is not a column of the data and was taken as a parameter; did you mean the column "
       "{b}?"},
      {kInseparable,
       "{a} were taken as parameters, because they are not columns of the data ({b}), and have one "
       "effect together only, {c}; one of them may be a misspelt column."},

      {kMovingMost, "The farthest from its optimum is {a}."},
      {kLinearModelInvalid, "The linear model there has no likelihood."},
      {kEffectsDiverge, "The random effects of some groups diverge."},
      {kStepsDoNotSettle,
       "The two steps of the method do not settle, so a fixed point may not exist."},
      {kPassLimit, "The limit of passes over the data is reached."},
      {kSquaresDiverge,
       "Penalized least squares fails, because the random effects of some groups diverge."},
      {kIterationLimit, "The iteration limit is reached."},
      {kEvaluationLimit, "The evaluation limit is reached."},
      {kJumps, "The likelihood has a jump, because the conditional mode of a group changes."},
      {kTryKinks, "Try the method agq, since the formula has a kink in {names}."},
      {kKinkUnsettled,
       "The formula has a kink in {names}, where the steps of this method may not settle: use "
       "`method=focei`."},
      {kKinkUnsettledWithoutEffects,
       "The formula has a kink in {names}, where the steps of this method may not settle: fix "
       "[it|them] at values near these, and compare the log-likelihoods."},
      {kTrySimpler, "Try the method focei or laplace, or {simpler}."},
      {kTrySimplerOnly, "Try {simpler}."},
      {kTryOtherMethod, "Try {simpler}; another method has the same likelihood."},
      {kTryLeastSquares,
       "Use a simpler variance function or other start values; `method=ols` shows whether the "
       "curve itself fits the data."},
      {kSingleObservations,
       "Each group of {a} has one observation, so random effects and residuals are hardly "
       "identifiable. Remove the random effects, or use groups with several observations."},
      {kSingleObservationsOf,
       "The reason is that each group of {a} has one observation. Remove the random effects by "
       "{a}, or use groups with several observations."},
      {kEqualGroupings,
       "The reason is that each group of {a} has one of {b}. Remove one of the two groupings."},
      {kRemoveOneEffect, "Remove one of them, or one of their random effects."},
      {kRemoveOne, "Remove one of them."},
      {kUseAgq,
       "The formula has a kink in {names}. Use `method=agq` with more points, such as "
       "`agq_points=15`, or {simpler}."},
      {kUseFocei, "Use `method=focei`, or {simpler}."},
      {kSingular, "Boundary (singular) fit: {each}. A simpler structure fits equally well."},
      {kCorrelationEnd,
       "The residuals' correlation is at the end of its range: {each}. Tests and Wald intervals of "
       "its parameters are not valid there; compare with another structure."},
      {kExactStratum,
       "The residual standard deviation of {names} is 0: the random effects fit these observations "
       "exactly. Its Wald intervals, and intervals of predictions of these observations, are not "
       "valid; use profile intervals, or one standard deviation for all strata."},
      {kStratumOfFew,
       "These estimates are a local maximum at best: the likelihood grows without bound as the "
       "curve passes through all observations of {names} and their standard deviation goes to 0. "
       "Join this stratum with another one, or use REML."},
      {kAtKink,
       "The optimum is at a kink of the formula in {names}, where an observation changes from one "
       "branch to another: standard errors are those of one side, so compare them with "
       "profile intervals."},
      {kPowerOfFew,
       "The power of the variance{a} matters for {x:.0f} of the observations only: with an "
       "exponent "
       "of {y:.3g} the variance of all others is constant. Compare with a constant variance, or "
       "with a stratum of these observations."},
      {kFloored,
       "{x:.0f} fitted value[ is|s are] too near zero for a power variance and set to a lower "
       "limit."},
      {kFlooredPower,
       "{x:.0f} fitted value[ is|s are] too near zero for a power variance and set to a lower "
       "limit; constant-plus-power may fit better."},
      {kExpectedErrors,
       "Standard errors are those of the expected information of the population's curve, because "
       "the likelihood is nearly flat along a ridge."},
      {kLinearizationDoubtful,
       "The linearization is doubtful here: the marginal log-likelihood ({a}) is {x:.2f} at these "
       "estimates and {y:.2f} at its maximum. Use `method={a}`."},
      {kHigherOptimum,
       "Another optimum is higher: log-likelihood {x:.2f} at {point}. The start values or bounds "
       "select the one that is shown ({y:.2f})."},
      {kLowerFromStart,
       "The start values lead to a lower optimum: log-likelihood {x:.2f} at {point}."},
      {kCloseOptimum, "Another optimum is close: log-likelihood {x:.2f} at {point}."},
      {kAtBounds, "At its bound, with the likelihood decreasing into the range: {each}."},
      {kEndsAtBounds, "At its bound: {each}."},
      {kSampleStart, "Start values come from a sample of {x:.0f} observations."},
      {kParametersTaken, "Names that are not columns were taken as parameters: {names}."},
      {kFarColumn,
       "The values of {a} are far from 0 compared with their range: first subtract about their "
       "mean in the formula, as ({a} - {x:.6g}), which is the same curve with other coefficients."},
  };
  return std::ranges::find(kTexts, kind, &Text::kind)->text;
}

}  // namespace silvafit::fit
