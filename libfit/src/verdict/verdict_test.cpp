// SPDX-License-Identifier: MIT
#include <catch2/catch.hpp>

#include "silvafit/fit/convergence.hpp"
#include "silvafit/fit/finding.hpp"

using namespace silvafit::fit;
using Kind = Finding::Kind;

TEST_CASE("each kind of finding has a sentence with all its names and values") {
  for (int kind = 0; kind <= static_cast<int>(Kind::kFarColumn); ++kind) {
    const std::string text = verdict_of({{.kind = static_cast<Kind>(kind),
                                          .names = {"a", "b", "c"},
                                          .values = {1.0, 2.0, 3.0, 4.0, 5.0}}});
    INFO(kind << ": " << text);
    CHECK_FALSE(text.empty());
    CHECK(text.find_first_of("{}[]") == std::string::npos);
  }
}

TEST_CASE("sentences have a place, and the last result counts") {
  const std::string text = verdict_of({{.kind = Kind::kSettledAlternations, .values = {1.0, 2e-9}},
                                       {.kind = Kind::kSingular, .names = {"sd(a) = 0", "rho = 1"}},
                                       {.kind = Kind::kKink, .names = {"b"}},
                                       {.kind = Kind::kFallback, .names = {"lb"}}});
  CHECK(text ==
        "Fitted by focei, because lb found no result. Converged, with a doubt: the formula has a "
        "kink in b, where this method is not exact. Compare with `method=agq`. Converged after 1 "
        "alternation: further iterations change no estimate by more than 2e-09 standard errors. "
        "Boundary (singular) fit: sd(a) = 0; rho = 1. A simpler structure fits equally well.");
  CHECK(verdict_of({{.kind = Kind::kPoorlyDetermined, .names = {"a"}},
                    {.kind = Kind::kLimitOfCurve, .names = {"a", "b", "c"}}}) ==
        "Not converged: the log-likelihood has no maximum; it is as high as here, or higher, while "
        "a, b and c go to a limit of the curve (infinity, zero or a step): the data do not cover "
        "the part of the curve that they "
        "describe. Use a model with fewer coefficients.");
}

TEST_CASE("the remedy is what the model has") {
  const auto remedy = [](const Reducible& model) {
    return verdict_of({{.kind = Kind::kTrySimplerOnly, .reducible = model}});
  };
  CHECK(remedy({}) == "Try a curve with fewer coefficients.");
  CHECK(remedy({.variance = true}) == "Try a simpler variance function.");
  CHECK(remedy({.effects = true, .covariances = true, .correlation = true}) ==
        "Try fewer random effects, a diagonal covariance matrix or a simpler correlation of the "
        "residuals.");
}

TEST_CASE("a conclusion replaces what was found before, and its names are evidence") {
  Convergence convergence;
  convergence.find({.kind = Kind::kMachinePrecision});
  convergence.conclude(ConvergenceStatus::kNotIdentifiable,
                       {.kind = Kind::kConfounded, .names = {"a", "b"}},
                       Evidence::Kind::kNotIdentifiable);
  CHECK(convergence.status == ConvergenceStatus::kNotIdentifiable);
  CHECK(convergence.has(Evidence::Kind::kNotIdentifiable, "b"));
  CHECK(convergence.verdict() ==
        "Not converged: a and b are not identifiable: their effects on the mean are linearly "
        "dependent. Remove one of them.");
}
