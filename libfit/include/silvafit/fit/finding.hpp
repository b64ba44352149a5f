// SPDX-License-Identifier: MIT
// What a fit and its search have found out, as data.
#pragma once

#include <string>
#include <vector>

namespace silvafit::fit {

/// What can be taken away from a model that has no good fit.
struct Reducible {
  bool effects = false;      ///< it has several random effects
  bool covariances = false;  ///< of random effects
  bool variance = false;     ///< it has a variance function
  bool correlation = false;  ///< of the residuals
};

/// One finding: a kind, and the names and values that the sentence of this kind needs.
/// src/verdict/verdict_texts.cpp has the table of the sentences, each with its remedy.
struct Finding {
  // clang-format off
  enum class Kind {
    // A sentence of the caller, or of a file.
    kText,
    // The result of a fit that has converged; the last one counts.
    kMachinePrecision, kPerfectFit, kAllHeld, kPublished, kPoorlyDetermined, kSettledAlternations,
    kSettledEvaluations,
    // Why a fit has not converged.
    kTooFewObservations, kNoStart, kUndefinedDerivatives, kPerfectOnlyAtLimit, kSquaresKeepFalling,
    kLikelihoodKeepsRising, kLimitOfCurve, kUnboundedPower, kConfounded, kSteps, kNearlyConfounded,
    kDependentEstimates, kConfoundedVariances, kUnseenCorrelation, kNoMinimum, kStillChanging,
    kStillChangingBy, kNoMaximumFound, kMaximumAway, kNoClearMode, kDivergedAway,
    kPerfectByFixedEffects, kNoFirstStep, kSmallGroupsExact, kPerfectCurve, kSingularCorrelation,
    kBeyondMeasure, kSaturated, kImpossibleError, kInvalidAtFirstOrder, kNoModes,
    kInvalidForSample, kFirstOrderHigher, kContainedHigher,
    kUnfinishedHigher, kUnfinishedFirstOrder, kLinearizationFar, kNoneFromStart, kRisesInwards,
    kHeldImpossible, kVanishingConstant, kVanishingStratum, kRangeUnbounded, kFarVariance,
    // Before the result; the last finding comes first.
    kFallback, kFirstBefore = kFallback, kStartFailed, kNoneInside, kContainedDoubt, kKink,
    kKinkRestricted, kKinkByQuadrature, kKinkFewPoints, kFewPoints, kRangeDoubt, kTwoValues,
    kCounts, kMissingCode, kIsolatedCode, kImputedRows, kCodesRead, kNameDoubt, kInseparable,
    // After the result.
    kMovingMost, kFirstAfter = kMovingMost, kLinearModelInvalid, kEffectsDiverge, kStepsDoNotSettle,
    kPassLimit, kSquaresDiverge, kIterationLimit, kEvaluationLimit, kJumps,
    kTryKinks, kKinkUnsettled, kKinkUnsettledWithoutEffects, kTrySimpler, kTrySimplerOnly,
    kTryOtherMethod, kTryLeastSquares, kSingleObservations, kSingleObservationsOf, kEqualGroupings,
    kRemoveOneEffect, kRemoveOne, kUseAgq, kUseFocei, kSingular, kCorrelationEnd, kExactStratum,
    kStratumOfFew, kAtKink, kPowerOfFew, kFloored, kFlooredPower, kExpectedErrors,
    kLinearizationDoubtful, kHigherOptimum, kLowerFromStart,
    kCloseOptimum, kAtBounds, kEndsAtBounds, kSampleStart, kParametersTaken, kFarColumn,
  };
  // clang-format on
  Kind kind = Kind::kText;
  std::vector<std::string> names{};
  std::vector<double> values{};
  Reducible reducible{};  ///< of the model, where the remedy is a simpler one
};

/// The convergence message: what was found, and the remedy.
std::string verdict_of(const std::vector<Finding>& findings);

}  // namespace silvafit::fit
