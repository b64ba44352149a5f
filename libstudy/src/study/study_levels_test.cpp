// SPDX-License-Identifier: MIT
// The models that the levels of a study try, and their choices.
#include "study/study_levels.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "silvafit/base/error.hpp"
#include "study/nested_tests.hpp"

using namespace silvafit;
using namespace silvafit::study;
using Catch::Matchers::Contains;

namespace {

data::Table trees_of_two_species() {
  data::Table table;
  table.set("dbh", std::vector<double>{10.0, 20.0, 30.0, 40.0, 50.0});
  table.set("h", std::vector<double>{9.0, 15.0, 19.0, 21.5, 23.0});
  table.set("W", std::vector<double>{0.0, 0.5, 0.25, 1.0, 0.75});
  return table;
}

constexpr int kObservations = 1000;

/// A fit with only the values that the choices read.
Candidate candidate(double log_likelihood, int parameters) {
  Candidate result{
      .fit = fit::FittedModel(fit::specify_model("h ~ 1.3 + a*dbh^b", {}, trees_of_two_species()))};
  result.fit.coefficient_names = result.fit.specification.coefficient_names();
  result.fit.estimate = Eigen::Vector2d(1.0, 0.5);
  result.fit.covariance = Eigen::Matrix2d::Identity();
  result.fit.observations = kObservations;
  result.fit.log_likelihood = log_likelihood;
  result.fit.parameter_count = parameters;
  result.fit.convergence.status = fit::ConvergenceStatus::kConverged;
  return result;
}

Candidate failed() {
  Candidate result = candidate(0.0, 0);
  result.fit.convergence.status = fit::ConvergenceStatus::kMaximumNotReached;
  return result;
}

Candidate on_edge(double log_likelihood, int parameters) {
  Candidate result = candidate(log_likelihood, parameters);
  result.fit.convergence.add_boundary({.term = "cor(a, b)", .value = -1.0});
  return result;
}

Candidate tested(double log_likelihood, int parameters, const Candidate& reference) {
  Candidate result = candidate(log_likelihood, parameters);
  result.test = nested_test(result.fit, reference.fit);
  return result;
}

std::vector<int> ranks_of(const std::vector<Candidate>& candidates) {
  std::vector<int> ranks;
  ranks.reserve(candidates.size());
  for (const Candidate& one : candidates) ranks.push_back(one.rank);
  return ranks;
}

/// One criterion for all levels, without tests.
StudyOptions by_one(Criterion criterion) {
  return {.criteria = {.base = criterion,
                       .covariates = criterion,
                       .random = criterion,
                       .variance = criterion},
          .needs_tests = false};
}

fit::FittedModel fitted(const std::string& formula) {
  return fit::fit_model(fit::specify_model(formula, {}, trees_of_two_species()),
                        trees_of_two_species())
      .fit;
}

}  // namespace

TEST_CASE("level 1 chooses the fewest parameters within 2 AIC of the best") {
  // AIC: 208, 208.5 (fewer parameters), 211 (fewest, too far), none.
  std::vector<Candidate> candidates{
      candidate(-100.0, 4), candidate(-101.25, 3), candidate(-103.5, 2), failed()};
  CHECK(choose_base(candidates, {}) == 1U);
  CHECK(candidates[1].chosen);
  CHECK_FALSE(candidates[0].chosen);
  CHECK(ranks_of(candidates) == std::vector<int>{1, 2, 3, 0});
}

TEST_CASE("level 1 chooses the likeliest of those with equally few parameters") {
  std::vector<Candidate> candidates{
      candidate(-101.0, 3), candidate(-100.5, 3), candidate(-100.0, 4)};
  CHECK(choose_base(candidates, {}) == 1U);
}

TEST_CASE("exactly 2 AIC is still within 2 AIC") {
  std::vector<Candidate> candidates{candidate(-100.0, 4), candidate(-102.0, 3)};
  CHECK(choose_base(candidates, {}) == 1U);
}

TEST_CASE("nothing is chosen if nothing converged") {
  std::vector<Candidate> candidates{failed(), failed()};
  candidates[1].fit.convergence.status = fit::ConvergenceStatus::kConverged;
  candidates[1].fit.log_likelihood = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(choose_base(candidates, {}));
  CHECK_FALSE(choose_covariates(candidates, {}));
  CHECK_FALSE(choose_random_effects(candidates, {}));
  CHECK_FALSE(choose_variance(candidates, {}));
  CHECK(ranks_of(candidates) == std::vector<int>{0, 0});
}

TEST_CASE("level 2 chooses the lowest BIC among those that are significantly better") {
  const Candidate base = candidate(-100.0, 3);
  // log n = 6.9: a parameter lowers BIC if it adds 5 to the log-likelihood, not if it adds 1.
  std::vector<Candidate> candidates{
      base, tested(-95.0, 4, base), tested(-94.0, 5, base), tested(-90.0, 4, base)};
  CHECK(choose_covariates(candidates, {}) == 3U);
  CHECK(candidates[1].rank == 2);
  CHECK(candidates[2].rank == 4);
}

TEST_CASE("level 2 chooses the base if no covariate is significant") {
  // With so few trees BIC is less strict than the test: 2 * 1.8 = 3.6 < 3.84 although BIC falls.
  Candidate base = candidate(-100.0, 3);
  Candidate better = tested(-98.2, 4, base);
  base.fit.observations = better.fit.observations = 20;
  REQUIRE(better.fit.bic() < base.fit.bic());
  std::vector<Candidate> candidates{base, better};
  CHECK(choose_covariates(candidates, {}) == 0U);
}

TEST_CASE("level 3 chooses the lowest BIC of fits that are not boundary fits") {
  std::vector<Candidate> candidates{
      candidate(-100.0, 4), on_edge(-60.0, 6), candidate(-80.0, 6), failed()};
  CHECK(choose_random_effects(candidates, {}) == 2U);
  CHECK(ranks_of(candidates) == std::vector<int>{3, 1, 2, 0});
}

TEST_CASE("level 3 chooses a boundary fit only if there is no other") {
  std::vector<Candidate> candidates{on_edge(-100.0, 4), on_edge(-60.0, 6)};
  CHECK(choose_random_effects(candidates, {}) == 1U);
}

TEST_CASE("a variance function needs the lowest AIC and a significant test") {
  const Candidate none = candidate(-100.0, 5);
  std::vector<Candidate> weak{none, tested(-98.5, 6, none)};
  REQUIRE(weak[1].fit.aic() < none.fit.aic());
  CHECK(choose_variance(weak, {}) == 0U);  // 2 * 1.5 = 3 < 3.84
  std::vector<Candidate> strong{
      none, tested(-95.0, 6, none), tested(-96.0, 6, none), tested(-94.5, 7, none)};
  CHECK(choose_variance(strong, {}) == 1U);
}

TEST_CASE("a choice replaces the ranks and marks of an earlier one") {
  std::vector<Candidate> candidates{candidate(-100.0, 3), candidate(-90.0, 3)};
  choose_base(candidates, {});
  candidates[1].fit.convergence.status = fit::ConvergenceStatus::kMaximumNotReached;
  CHECK(choose_base(candidates, {}) == 0U);
  CHECK_FALSE(candidates[1].chosen);
  CHECK(candidates[1].rank == 0);
}

TEST_CASE("level 2 tries 16 subsets of four covariates on each parameter, the base once") {
  const fit::FittedModel base = fitted("h ~ 1.3 + a*dbh^b");
  data::Table table = trees_of_two_species();
  for (const char* name : {"M", "C", "U"}) table.set(name, std::vector<double>(5, 0.5));
  const std::vector<Trial> trials = covariate_trials(base, {"W", "M", "C", "U"}, 1, table);
  REQUIRE(trials.size() == 1 + 2 * (16 - 1));
  CHECK(trials.front().terms.empty());
  CHECK(trials[1].terms == std::vector<std::string>{"a ~ 1 + W"});
  CHECK(trials.back().terms == std::vector<std::string>{"b ~ 1 + W + M + C + U"});
  // Each starts from the base model, which it contains.
  CHECK(trials.back().options.start.at("a") == base.estimate[0]);
  CHECK(trials.back().options.start.at("b:C") == 0.0);
}

TEST_CASE("on request, pairs of parameters have covariates") {
  const fit::FittedModel base = fitted("h ~ 1.3 + a*(1 - exp(-b*dbh))");
  const std::vector<Trial> trials = covariate_trials(base, {"W", "M"}, 2, trees_of_two_species());
  // The base model, 3 subsets on each of two parameters, and 3 x 3 on both.
  REQUIRE(trials.size() == 1 + 2 * 3 + 9);
  CHECK(trials.back().terms == std::vector<std::string>{"a ~ 1 + W + M", "b ~ 1 + W + M"});
  CHECK(trials.back().specification.coefficient_names() ==
        std::vector<std::string>{"a", "a:W", "a:M", "b", "b:W", "b:M"});
}

TEST_CASE("more subsets of covariates than can be tried are an error") {
  const fit::FittedModel base = fitted("h ~ 1.3 + a*(1 - exp(-b*dbh))");
  const std::vector<std::string> names{"c1", "c2", "c3", "c4", "c5", "c6", "c7", "c8"};
  // 2 * 255 on one parameter, and 255 * 255 on both.
  CHECK_NOTHROW(covariate_trials(base, names, 1, trees_of_two_species()));
  CHECK_THROWS_WITH(covariate_trials(base, names, 2, trees_of_two_species()),
                    Contains("makes 65535 fits") && Contains("covariate_parameters 1"));
}

TEST_CASE("a parsimonious choice has the fewest parameters within two of the best") {
  std::vector<Candidate> candidates{candidate(-100.0, 4), candidate(-98.5, 5), candidate(-90.0, 9)};
  // AIC 208, 207, 198: the last is best by far.
  CHECK(choose_random_effects(candidates, {.criteria = {.random = Criterion::kAic}}) == 2U);
  candidates.pop_back();
  CHECK(choose_random_effects(candidates, {.criteria = {.random = Criterion::kAic}}) == 1U);
  CHECK(choose_random_effects(
            candidates, {.criteria = {.random = Criterion::kAic}, .parsimonious = true}) == 0U);
}

TEST_CASE("the intercept is removed only from the sub-model with covariates") {
  Candidate chosen{.terms = {"b ~ 1 + W"},
                   .fit = fit::FittedModel(fit::specify_model(
                       "h ~ 1.3 + a*dbh^b", {"b ~ 1 + W"}, trees_of_two_species()))};
  const auto trial = without_intercept(chosen, trees_of_two_species());
  REQUIRE(trial);
  CHECK(trial->terms == std::vector<std::string>{"b ~ 0 + W"});
  CHECK(trial->specification.coefficient_names() == std::vector<std::string>{"a", "b:W"});
  chosen.terms.clear();
  CHECK_FALSE(without_intercept(chosen, trees_of_two_species()));
}

TEST_CASE("level 3 tries all 2^p - 1 subsets of coefficients, or those up to a size") {
  const fit::FittedModel two = fitted("h ~ 1.3 + a*dbh^b");
  CHECK(random_effect_trials(two, "plot", 3).size() == 3);
  fit::FittedModel five = two;
  five.coefficient_names = {"a", "b", "c", "c:C", "c:M"};
  five.estimate = Eigen::VectorXd::Ones(5);
  CHECK(random_effect_trials(five, "plot", 5).size() == 31);
  const std::vector<Trial> capped = random_effect_trials(five, "plot", 3);
  REQUIRE(capped.size() == 5 + 10 + 10);
  CHECK(capped.front().terms.size() == 1);
  CHECK(capped.back().terms.size() == 3);
  CHECK(capped.front().specification.random.back().group == "plot");
}

TEST_CASE("the four variance functions are tried on the chosen random effects, none first") {
  Candidate mixed = candidate(-100.0, 4);
  mixed.terms = {"a"};
  mixed.fit.coefficient_names = {"a", "b"};
  mixed.fit.estimate = Eigen::Vector2d(1.0, 0.5);
  const std::vector<Trial> trials = variance_trials(mixed, StudyOptions{}.variance_functions);
  REQUIRE(trials.size() == 4);
  CHECK(trials[0].specification.variance.text() == "none");
  CHECK(trials[3].specification.variance.text() == "constant-plus-power");
}

TEST_CASE("cross-validation chooses the lowest error of all folds regardless of the likelihood") {
  const auto with_error = [](double log_likelihood, double rmse, std::size_t failed) {
    Candidate result = candidate(log_likelihood, 3);
    result.cross_validated = CrossValidated{.rmse = rmse, .folds = 10, .failed = failed};
    return result;
  };
  // The error of the third excludes the trees of a failed fold; the fourth has no error.
  std::vector<Candidate> candidates{with_error(-90.0, 2.0, 0),
                                    with_error(-100.0, 1.5, 0),
                                    with_error(-95.0, 1.0, 1),
                                    candidate(-50.0, 3)};
  const StudyOptions options = by_one(Criterion::kCrossValidation);
  CHECK(choose_base(candidates, options) == 1U);
  CHECK(ranks_of(candidates) == std::vector<int>{2, 1, 3, 4});
  CHECK(choose_covariates(candidates, options) == 1U);
  CHECK(choose_random_effects(candidates, options) == 1U);
  CHECK(choose_variance(candidates, options) == 1U);
}

TEST_CASE("errors within one standard error of the best are equally good") {
  const auto with_error = [](int parameters, double rmse, double standard_error) {
    Candidate result = candidate(-100.0, parameters);
    result.cross_validated =
        CrossValidated{.rmse = rmse, .standard_error = standard_error, .folds = 10};
    return result;
  };
  // The best has 1.5 with an error of 0.2, so that 1.65 is as good, and 1.75 is not.
  std::vector<Candidate> candidates{
      with_error(6, 1.5, 0.2), with_error(4, 1.65, 0.1), with_error(3, 1.75, 0.5)};
  StudyOptions options = by_one(Criterion::kCrossValidation);
  CHECK(choose_base(candidates, options) == 1U);
  CHECK(choose_random_effects(candidates, options) == 0U);
  options.parsimonious = true;
  CHECK(choose_random_effects(candidates, options) == 1U);
  CHECK(choose_variance(candidates, options) == 1U);
}

TEST_CASE("a requested criterion decides without tests") {
  Candidate base = candidate(-100.0, 3);
  Candidate better = tested(-98.2, 4, base);
  base.fit.observations = better.fit.observations = 20;
  std::vector<Candidate> candidates{base, better};
  REQUIRE(choose_covariates(candidates, {}) == 0U);  // 2 * 1.8 = 3.6 < 3.84
  CHECK(choose_covariates(candidates, by_one(Criterion::kBic)) == 1U);
  CHECK(choose_variance(candidates, by_one(Criterion::kAic)) == 1U);
  CHECK(value_of<Criterion>("aicc", "criterion") == Criterion::kAicc);
  CHECK_THROWS_AS(value_of<Criterion>("mse", "criterion"), UsageError);
}

TEST_CASE(
    "candidates with an objection are rejected, and only those that could be chosen are examined") {
  std::vector<std::size_t> asked;
  const Examination examine = [&](std::size_t i) {
    asked.push_back(i);
    return std::string(i == 0 ? "It falls." : "");
  };
  // AIC 206, 210, 211 (fewest parameters), 290.
  std::vector<Candidate> candidates{
      candidate(-100.0, 3), candidate(-101.0, 4), candidate(-103.5, 2), candidate(-140.0, 5)};
  CHECK(choose_base(candidates, {}, examine) == 2U);
  CHECK(asked == std::vector<std::size_t>{0, 1, 2});
  CHECK(candidates[0].objection == "It falls.");
  CHECK(candidates[0].rank == 1);
  CHECK_FALSE(candidates[0].chosen);
  CHECK_FALSE(candidates[3].is_examined);
  // The objections are stored.
  asked.clear();
  CHECK(choose_base(candidates, {}, examine) == 2U);
  CHECK(asked.empty());
}

TEST_CASE("if all have an objection, level 1 chooses the best, the other levels none") {
  const Examination never = [](std::size_t) { return std::string("It falls."); };
  std::vector<Candidate> candidates{candidate(-100.0, 4), candidate(-90.0, 4)};
  CHECK(choose_base(candidates, {}, never) == 1U);
  CHECK(candidates[1].objection == "It falls.");
  CHECK_FALSE(choose_covariates(candidates, {}, never));
  CHECK_FALSE(choose_random_effects(candidates, {}, never));
  CHECK_FALSE(choose_variance(candidates, {}, never));
}

TEST_CASE("a boundary fit is chosen if all other mixed models have an objection") {
  std::vector<Candidate> candidates{candidate(-60.0, 6), on_edge(-80.0, 6)};
  const Examination examine = [](std::size_t i) { return std::string(i == 0 ? "It falls." : ""); };
  CHECK(choose_random_effects(candidates, {}, examine) == 1U);
}

TEST_CASE("a model less likely than one that it contains has an objection") {
  const fit::FittedModel power = fitted("h ~ 1.3 + a*dbh^b");
  fit::FittedModel with_covariate =
      fit::fit_model(fit::specify_model("h ~ 1.3 + a*dbh^b", {"a ~ 1 + W"}, trees_of_two_species()),
                     trees_of_two_species())
          .fit;
  const std::vector<SmallerModel> smaller{{.name = "without W", .fit = &power}};
  CHECK(objection_to_likelihood(with_covariate, smaller).empty());
  with_covariate.log_likelihood = power.log_likelihood - 1.0;
  CHECK_THAT(objection_to_likelihood(with_covariate, smaller),
             Catch::Matchers::Contains("is lower than that of the model without W"));
  // The model with fewer coefficients contains nothing.
  CHECK(objection_to_likelihood(power, {{.name = "with W", .fit = &with_covariate}}).empty());
}

TEST_CASE("a mixed model farther from the observations than least squares has an objection") {
  const Candidate plain = candidate(-100.0, 3);
  fit::FittedModel least_squares = plain.fit;
  least_squares.population.rmse = 2.0;
  fit::FittedModel mixed = plain.fit;
  mixed.random = {{.names = {"a"}}};
  mixed.conditional.rmse = 1.9;
  CHECK(objection_to_error(mixed, least_squares).empty());
  mixed.conditional.rmse = 2.01;
  CHECK_THAT(objection_to_error(mixed, least_squares), Catch::Matchers::Contains("RMSE 2.010"));
  // Weights may change the unweighted error a little.
  mixed.specification.variance = fit::parse_variance_function("power");
  CHECK(objection_to_error(mixed, least_squares).empty());
  mixed.conditional.rmse = 2.2;
  CHECK_FALSE(objection_to_error(mixed, least_squares).empty());
}
