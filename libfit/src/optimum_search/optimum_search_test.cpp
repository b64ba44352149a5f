// SPDX-License-Identifier: MIT
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "optimum_search/candidate_fits.hpp"
#include "optimum_search/exchanged_fits.hpp"
#include "optimum_search/group_fits.hpp"
#include "optimum_search/search_evidence.hpp"
#include "optimum_search/smaller_structures.hpp"
#include "optimum_search/starting_points.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/fit/fitted_model.hpp"

using Eigen::Index;
using Eigen::VectorXd;
using silvafit::Random;
using silvafit::data::Table;
using silvafit::data::TextColumn;
using namespace silvafit::fit;

namespace {

/// Groups of observations of a curve with a normal effect on its first parameter.
struct Curves {
  int groups = 15;
  std::vector<double> x{};
  double effect_sd = 0.0;
  double sigma = 0.0;
  std::function<double(double x, double effect)> mean{};
};

Table simulated(const Curves& curves, std::uint64_t seed) {
  Random random(seed);
  TextColumn group;
  std::vector<double> x;
  std::vector<double> y;
  for (int g = 0; g < curves.groups; ++g) {
    const double effect = random.normal(0.0, curves.effect_sd);
    for (const double at : curves.x) {
      group.append(std::to_string(g));
      x.push_back(at);
      y.push_back(curves.mean(at, effect) + random.normal(0.0, curves.sigma));
    }
  }
  Table table;
  table.set("g", group);
  table.set("x", x);
  table.set("y", y);
  return table;
}

/// Two terms, of which the fast one varies between groups.
Table biexponential(std::uint64_t seed) {
  return simulated({.x = {0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0},
                    .effect_sd = 0.6,
                    .sigma = 0.08,
                    .mean =
                        [](double x, double effect) {
                          return (2.8 + effect) * std::exp(-std::exp(0.8) * x) +
                                 0.5 * std::exp(-std::exp(-1.4) * x);
                        }},
                   seed);
}

constexpr const char* kGrowth = "y ~ h1 - 2*(h1 - ht)/(exp(s0*(x - th)) + exp(s1*(x - th)))";
const std::map<std::string, double> kGrowthTruth{
    {"h1", 170.0}, {"ht", 160.0}, {"s0", 0.12}, {"s1", 1.1}, {"th", 17.5}};

/// Heights of 15 children from 1 to 18 years. Source of the curve: Preece and Baines 1978, Annals
/// of Human Biology 5, 1-24, model 1.
Table growth(std::uint64_t seed) {
  Random random(seed);
  TextColumn group;
  std::vector<double> x;
  std::vector<double> y;
  for (int g = 0; g < 15; ++g) {
    const double h1 = random.normal(170.0, 5.0);
    const double s1 = random.normal(1.1, 0.11);
    const double th = random.normal(17.5, 0.9);
    for (int age = 1; age <= 18; ++age) {
      group.append(std::to_string(g));
      x.push_back(age);
      const double sum = std::exp(0.12 * (age - th)) + std::exp(s1 * (age - th));
      y.push_back(h1 - 2.0 * (h1 - 160.0) / sum + random.normal(0.0, 0.5));
    }
  }
  Table table;
  table.set("g", group);
  table.set("x", x);
  table.set("y", y);
  return table;
}

constexpr const char* kBiexponential = "y ~ A1*exp(-exp(l1)*x) + A2*exp(-exp(l2)*x)";

FittedModel searched_fit(const Table& table,
                         const char* formula,
                         const char* random,
                         const FitModelOptions& options = {}) {
  ModelSpecification specification = specify_model(formula, {}, table);
  add_random_effects(specification, random, table);
  return fit_model(specification, table, options).fit;
}

NonlinearModel bound(const Table& table, const char* formula, const char* random) {
  ModelSpecification specification = specify_model(formula, {}, table);
  add_random_effects(specification, random, table);
  return NonlinearModel(specification, table);
}

}  // namespace

TEST_CASE("of interchangeable terms the varying one gets the random effect") {
  // The truth is one of two maxima that differ by tens of log-likelihood units; they have the same
  // pooled fit.
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
    const Table table = biexponential(seed);
    for (const Method method : {Method::kLindstromBates, Method::kInteraction, Method::kLaplace}) {
      INFO("seed " << seed << ", " << silvafit::word_of(method));
      const FittedModel fit = searched_fit(table, kBiexponential, "A1 | g", {.method = method});
      INFO(fit.convergence.verdict());
      REQUIRE(fit.convergence.converged());
      // Five standard errors, of about 0.15 and 0.05.
      CHECK(fit.estimate[0] == Approx(2.8).margin(0.8));
      CHECK(fit.estimate[1] == Approx(0.8).margin(0.25));
      CHECK(fit.random.back().sd()[0] == Approx(0.6).margin(0.4));
      REQUIRE(fit.optima.size() >= 2);
      CHECK(fit.optima[0].estimate == fit.estimate);
      CHECK(fit.optima[0].log_likelihood > fit.optima[1].log_likelihood + 5.0);
    }
  }
}

TEST_CASE("it does not matter which of two interchangeable coefficients has the random effect") {
  // Preece and Baines' curve is the same if s0 and s1 are exchanged, so both models are the same.
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    INFO("seed " << seed);
    const Table table = growth(seed);
    const FittedModel first = searched_fit(table, kGrowth, "h1 + s1 + th | g");
    const FittedModel second = searched_fit(table, kGrowth, "h1 + s0 + th | g");
    INFO(first.convergence.verdict() << " " << second.convergence.verdict());
    REQUIRE(first.convergence.converged());
    REQUIRE(second.convergence.converged());
    // Both are within 1e-6 standard errors of the same fixed point.
    CHECK(first.log_likelihood == Approx(second.log_likelihood).margin(1e-6));
    CHECK(first.estimate[2] == Approx(second.estimate[4]).epsilon(1e-4));
  }
}

TEST_CASE("groups decide between curves that fit all groups together equally well") {
  // Between groups, th varies more than the sharp end of growth is wide, so that the pooled data
  // have no sharp end.
  for (const std::uint64_t seed : {3U, 4U}) {
    const Table table = growth(seed);
    for (const Method method : {Method::kLindstromBates, Method::kInteraction}) {
      INFO("seed " << seed << ", " << silvafit::word_of(method));
      const FittedModel fit = searched_fit(table, kGrowth, "h1 + s1 + th | g", {.method = method});
      const FittedModel from_truth = searched_fit(
          table, kGrowth, "h1 + s1 + th | g", {.method = method, .start = kGrowthTruth});
      INFO(fit.convergence.verdict());
      REQUIRE(fit.convergence.converged());
      // Both are within 1e-6 standard errors of their optimum.
      CHECK(fit.log_likelihood > from_truth.log_likelihood - 1e-6);
    }
  }
}

TEST_CASE("start values of the user are used") {
  // For observations at multiples of 0.4, w and w + 2 pi/0.4 give the same curve; only the start
  // value chooses between them.
  const double truth = 4.5 + 2.0 * 3.141592653589793 / 0.4;
  const Table table = simulated(
      {.groups = 8,
       .x = {0.8, 1.2, 1.6, 2.0, 2.4, 2.8, 3.2},
       .effect_sd = 0.5,
       .sigma = 0.05,
       .mean = [](double x,
                  double effect) { return 3.0 + effect + 2.0 * std::cos(4.5 * x + 0.7); }},
      3);
  const FittedModel fit = searched_fit(table,
                                       "y ~ a + b*cos(w*x + 0.7)",
                                       "a | g",
                                       {.start = {{"a", 3.1}, {"b", 1.9}, {"w", truth + 0.02}}});
  REQUIRE(fit.convergence.converged());
  // The standard error of w is about 0.005.
  CHECK(fit.estimate[2] == Approx(truth).margin(0.03));
  const FittedModel other = searched_fit(
      table, "y ~ a + b*cos(w*x + 0.7)", "a | g", {.start = {{"a", 3.0}, {"b", 2.0}, {"w", 4.48}}});
  CHECK(other.estimate[2] == Approx(4.5).margin(0.03));
  // The two are equal except for rounding in cosines of large arguments.
  CHECK(other.log_likelihood == Approx(fit.log_likelihood).epsilon(1e-9));
}

TEST_CASE("peaks are found if their places vary more than they are wide") {
  // All groups together have no peak, and the groups have few observations more than coefficients.
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Table table = simulated({.groups = 14,
                                   .x = {1.0, 3.5, 6.0, 8.5, 11.0, 13.5, 16.0, 18.5, 21.0, 23.5},
                                   .effect_sd = 3.0,
                                   .sigma = 0.3,
                                   .mean =
                                       [](double x, double effect) {
                                         const double z = (x - 13.0 - effect) / 2.0;
                                         return 4.0 + 0.2 * x + 8.0 * std::exp(-z * z);
                                       }},
                                  seed);
    for (const Method method : {Method::kLindstromBates, Method::kInteraction}) {
      INFO("seed " << seed << ", " << silvafit::word_of(method));
      const FittedModel fit =
          searched_fit(table, "y ~ c + d*x + A*exp(-((x - m)/s)^2)", "m | g", {.method = method});
      INFO(fit.convergence.verdict());
      REQUIRE(fit.convergence.converged());
      // Standard errors are about 0.1, 0.8 (the effects' over the root of 14) and 0.6.
      CHECK(fit.estimate[2] == Approx(8.0).margin(0.6));
      CHECK(fit.estimate[3] == Approx(13.0).margin(3.2));
      CHECK(fit.random.back().sd()[0] == Approx(3.0).margin(1.8));
    }
  }
}

/// Waves of period 12 with a phase for each group.
Table waves(const std::vector<double>& phases) {
  Table table;
  TextColumn group;
  std::vector<double> x;
  std::vector<double> y;
  for (std::size_t g = 0; g < phases.size(); ++g) {
    for (int i = 0; i < 12; ++i) {
      group.append(std::to_string(g));
      x.push_back(1.5 * i);
      const double angle = 2.0 * 3.14159265358979 * (x.back() - phases[g]) / 12.0;
      y.push_back(5.0 + 2.0 * std::cos(angle) + 0.01 * std::sin(5.0 * i + static_cast<double>(g)));
    }
  }
  table.set("g", group);
  table.set("x", x);
  table.set("y", y);
  return table;
}

TEST_CASE("phases of groups are angles") {
  // Around 12, which is 0; the groups' waves determine them to a hundredth.
  const Table table = waves({11.2, 0.6, 11.8, 0.0, 0.2, 11.6, 0.9});
  const char* const formula = "y ~ M + A*cos(2*pi*(x - t)/12)";
  const NonlinearModel model = bound(table, formula, "t | g");
  const std::vector<GroupFits> fits =
      fit_single_groups(model, model.pooled(), Eigen::Vector3d(5.0, 2.0, 3.0));  // M, A, t
  REQUIRE_FALSE(fits.empty());
  const VectorXd phases = fits.front().own.row(2).transpose();
  CHECK(phases.maxCoeff() - phases.minCoeff() == Approx(1.7).margin(0.02));
  CHECK(std::remainder(fits.front().medians[2], 12.0) == Approx(0.0).margin(0.03));
}

TEST_CASE("groups find their own peaks where a search from the common one does not") {
  // From the common place the slope is zero in groups whose peak is elsewhere.
  constexpr double kPlaces[] = {1.5, 2.5, 3.5, 5.0, 6.5, 8.0, 9.0};
  Table table;
  TextColumn group;
  std::vector<double> x;
  std::vector<double> y;
  for (const double place : kPlaces) {
    for (int i = 0; i < 20; ++i) {
      group.append(std::to_string(place));
      x.push_back(0.25 + 0.5 * i);
      y.push_back(1.0 + 10.0 * std::exp(-std::pow((x.back() - place) / 0.7, 2)) +
                  0.01 * std::sin(7.0 * i));
    }
  }
  table.set("g", group);
  table.set("x", x);
  table.set("y", y);
  const char* const formula = "y ~ b + A*exp(-((x - m)/s)^2)";
  const NonlinearModel model = bound(table, formula, "m | g");
  const Eigen::Vector4d at(1.0, 10.0, 5.0, 0.7);  // b, A, m, s
  const GroupFits found = fit_single_groups(model, model.pooled(), at).back();
  REQUIRE(found.fitted == std::size(kPlaces));
  for (Index g = 0; g < model.group_count(); ++g) {
    // The wave of 0.01 moves a peak of 10 by less than a thousandth of its width.
    CHECK(found.own(2, g) == Approx(kPlaces[g]).margin(1e-3));
  }
}

TEST_CASE("start values never give a lower result") {
  // In the region of a lower maximum, and far from the data.
  const std::map<std::string, double> far{{"A1", 0.5}, {"l1", -1.4}, {"A2", 2.8}, {"l2", 0.8}};
  const std::map<std::string, double> useless{
      {"A1", 50.0}, {"l1", 9.0}, {"A2", -40.0}, {"l2", 4.0}};
  for (const Method method : {Method::kLindstromBates, Method::kInteraction, Method::kLaplace}) {
    const Table table = biexponential(2);
    const FittedModel usual = searched_fit(table, kBiexponential, "A1 | g", {.method = method});
    REQUIRE(usual.convergence.converged());
    for (const auto& start : {far, useless}) {
      INFO(silvafit::word_of(method));
      const FittedModel fit =
          searched_fit(table, kBiexponential, "A1 | g", {.method = method, .start = start});
      REQUIRE(fit.convergence.converged());
      // The difference of two searches of one maximum.
      CHECK(fit.log_likelihood > usual.log_likelihood - 1e-3);
    }
  }
}

TEST_CASE("a phase is found if its period varies between groups") {
  // Only near the true phase, not periods away, do the groups' curves meet.
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Table table =
        simulated({.groups = 12,
                   .x = {1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29},
                   .effect_sd = 0.5,
                   .sigma = 0.3,
                   .mean =
                       [](double x, double effect) {
                         const double turns = (x - 14.0) / (8.0 + effect);
                         return 10.0 + 2.0 * std::cos(2.0 * 3.141592653589793 * turns);
                       }},
                  seed);
    for (const Method method : {Method::kLindstromBates, Method::kInteraction}) {
      INFO("seed " << seed << ", " << silvafit::word_of(method));
      const FittedModel fit =
          searched_fit(table, "y ~ M + A*cos(2*pi*(x - t)/P)", "P | g", {.method = method});
      INFO(fit.convergence.verdict());
      REQUIRE(fit.convergence.converged());
      // The standard error of t is about 0.05, that of P the effects' over the root of 12, 0.15.
      // With a negative amplitude the phase is half a period away.
      const double t = fit.estimate[2];
      CHECK((fit.estimate[1] > 0.0 ? std::abs(t - 14.0) : std::abs(std::abs(t - 14.0) - 4.0)) <
            0.5);
      CHECK(std::abs(fit.estimate[3]) == Approx(8.0).margin(0.75));
      CHECK(fit.random.back().sd()[0] == Approx(0.5).margin(0.4));
    }
  }
}

TEST_CASE("a formula that is linear after a transformation starts from its solution") {
  std::vector<double> x;
  std::vector<double> y;
  TextColumn group;
  for (int i = 0; i < 40; ++i) {
    x.push_back(5.0 + i);
    y.push_back(1.3 + x.back() * x.back() / (1.5 + 0.9 * x.back() + 0.02 * x.back() * x.back()));
    // Fewer groups than medians need, so that the solution is no other start.
    group.append(std::to_string(i % 2));
  }
  Table table;
  table.set("g", group);
  table.set("x", x);
  table.set("y", y);
  const NonlinearModel model = bound(table, "y ~ 1.3 + x^2/(a + b*x + c*x^2)", "a | g");
  LeastSquaresFit pooled;
  pooled.estimate = Eigen::Vector3d(9.0, 9.0, 9.0);  // far away
  const std::vector<StartingPoint> points = starting_points(model, pooled);
  const auto solved = std::ranges::find(points, "solved formula", &StartingPoint::origin);
  REQUIRE(solved != points.end());
  // A linear fit of exact data, conditioned about as its squares of diameters are large.
  CHECK((solved->coefficients - Eigen::Vector3d(1.5, 0.9, 0.02)).norm() < 1e-8);
}

TEST_CASE("spread starts are numerous, distinct and reproducible") {
  const NonlinearModel model = bound(biexponential(1), kBiexponential, "A1 | g");
  const LeastSquaresFit pooled = fit_least_squares(model, {.other_minima = true});
  const std::size_t usual = starting_points(model, pooled).size();
  const auto more = starting_points(model, pooled, 5);
  CHECK(more.size() == usual + 5);
  const auto again = starting_points(model, pooled, 5);
  for (std::size_t k = 0; k < more.size(); ++k) {
    CHECK(more[k].coefficients == again[k].coefficients);
  }
}

TEST_CASE("further starts never give a lower result") {
  for (const Method method : {Method::kLindstromBates, Method::kInteraction}) {
    const FittedModel usual =
        searched_fit(biexponential(2), kBiexponential, "A1 + A2 | g", {.method = method});
    const FittedModel more = searched_fit(
        biexponential(2), kBiexponential, "A1 + A2 | g", {.method = method, .spread_starts = 12});
    REQUIRE(usual.convergence.converged());
    REQUIRE(more.convergence.converged());
    // The difference of two searches of one maximum.
    CHECK(more.log_likelihood > usual.log_likelihood - 1e-3);
  }
}

TEST_CASE("a converged fit replaces an unconverged one at the same point") {
  Candidate given_up;
  given_up.fit.log_likelihood = -10.0;
  given_up.fit.fitted_conditional = Eigen::Vector2d(1.0, 2.0);
  given_up.fit.residual_sd = Eigen::Vector2d(0.5, 0.5);
  given_up.rank = -11.0;
  Candidate converged = given_up;
  converged.fit.convergence.status = ConvergenceStatus::kConverged;
  converged.rank = -12.0;
  std::vector<Candidate> candidates;
  CHECK(add_candidate(candidates, given_up));
  CHECK_FALSE(add_candidate(candidates, converged));
  REQUIRE(candidates.size() == 1);
  CHECK(candidates[0].fit.convergence.converged());
  CHECK(candidates[0].rank == -11.0);
  CHECK_FALSE(add_candidate(candidates, given_up));
  CHECK(candidates[0].fit.convergence.converged());
  Candidate elsewhere = converged;
  elsewhere.fit.fitted_conditional[1] = 3.0;
  CHECK(add_candidate(candidates, elsewhere));
  CHECK(candidates.size() == 2);
}

TEST_CASE("smaller structures omit each effect, and correlations") {
  const NonlinearModel model = bound(biexponential(1), kBiexponential, "A1 + l1 + A2 | g");
  const std::vector<SmallerStructure> smaller = smaller_structures(model);
  REQUIRE(smaller.size() == 4);
  CHECK(smaller[0].text == "without the random effect of A1");
  CHECK(smaller[1].model.specification().random.back().coefficients ==
        std::vector<std::string>{"A1", "A2"});
  CHECK(smaller[3].model.specification().random.back().covariance == Covariance::kDiagonal);

  MixedEffectsFit fit;
  fit.random.resize(1);
  fit.random.back().covariance.resize(3, 3);
  fit.random.back().covariance << 4.0, 1.0, 0.5, 1.0, 9.0, 0.2, 0.5, 0.2, 16.0;
  fit.random.back().effects = Eigen::MatrixXd::Constant(3, 15, 1.0);
  const MixedEffectsFit less = reduced(fit, smaller[1]);
  CHECK(less.random.back().covariance == Eigen::MatrixXd(Eigen::Matrix2d{{4.0, 0.5}, {0.5, 16.0}}));
  const MixedEffectsFit whole = enlarged(less, smaller[1], 0.3);
  CHECK(whole.random.back().covariance(1, 1) == Approx(0.09).epsilon(1e-15));
  CHECK(whole.random.back().covariance(0, 2) == 0.5);
  CHECK(whole.random.back().effects.row(1).isZero());
  const MixedEffectsFit independent = reduced(fit, smaller[3]);
  CHECK(independent.random.back().covariance.isDiagonal());
}

TEST_CASE("the findings of a search are in the convergence message") {
  MixedEffectsFit fit;
  fit.coefficient_names = {"a", "b"};
  fit.estimate = Eigen::Vector2d(1.0, 2.0);
  fit.log_likelihood = -100.0;
  fit.observations = 50;
  fit.convergence = {.status = ConvergenceStatus::kConverged,
                     .findings = {{.names = {"Converged."}}}};
  const ModelSpecification specification{.formula = silvafit::data::parse_formula("y ~ a*x^b")};
  const auto after = [&](const SearchEvidence& evidence) {
    MixedEffectsFit judged = fit;
    judge_search(specification, evidence, judged);
    return judged.convergence;
  };
  CHECK(after({}).verdict() == "Converged.");

  const Convergence below =
      after({.method = Method::kLaplace,
             .contained = ContainedModel{.text = "without b", .log_likelihood = -90.0}});
  CHECK(below.status == ConvergenceStatus::kContainedModelHigher);
  CHECK(below.has(Evidence::Kind::kContainedModel, "without b"));
  CHECK(below.evidence.back().value == -90.0);
  CHECK(below.verdict().find("without b") != std::string::npos);
  CHECK(below.verdict().find("other start values") != std::string::npos);
  // A fixed point of lb remains one, as nlme reports it, unless the linearization is useless.
  const Convergence lower =
      after({.contained = ContainedModel{.text = "without b", .log_likelihood = -90.0}});
  CHECK(lower.converged());
  CHECK(lower.verdict().starts_with("Converged, with a doubt: the model without b"));
  CHECK(after({.contained = ContainedModel{.log_likelihood = -79.0}}).status ==
        ConvergenceStatus::kContainedModelHigher);
  // Another method is recommended if it has a maximum above the contained model.
  const Convergence helped =
      after({.contained = ContainedModel{.log_likelihood = -90.0, .rank = -90.0},
             .marginal_maximum = -89.0});
  CHECK(helped.verdict().find("`method=laplace`: laplace converges at -89.00") !=
        std::string::npos);

  const Convergence doubtful = after({.marginal_here = -99.0, .marginal_maximum = -96.0});
  CHECK(doubtful.converged());
  CHECK(doubtful.has(Evidence::Kind::kMarginalMaximum, "laplace"));
  CHECK(doubtful.verdict().find("linearization is doubtful") != std::string::npos);
  CHECK(doubtful.verdict().find("`method=laplace`") != std::string::npos);
  CHECK(after({.marginal_here = -99.5, .marginal_maximum = -98.5}).verdict() == "Converged.");
  CHECK(after({.marginal_here = -60.0, .marginal_maximum = -59.0}).status ==
        ConvergenceStatus::kInvalidApproximation);
  const Convergence unfinished = after({.method = Method::kLaplace, .unfinished = -98.0});
  CHECK(unfinished.status == ConvergenceStatus::kMaximumNotReached);
  CHECK(unfinished.verdict().find("`method=focei`") != std::string::npos);
  // The message does not recommend the method that was used.
  CHECK(after({.method = Method::kInteraction, .unfinished = -98.0}).verdict().find("`method=") ==
        std::string::npos);
  CHECK(after({.first_order_maximum = -70.0}).status == ConvergenceStatus::kInvalidApproximation);

  fit.optima = {{.estimate = fit.estimate, .log_likelihood = -100.0},
                {.estimate = Eigen::Vector2d(5.0, 6.0), .log_likelihood = -101.0}};
  CHECK(after({}).verdict().find("log-likelihood -101.00 at a = 5, b = 6") != std::string::npos);
}

TEST_CASE("a linearized fit below a model that it contains is in doubt") {
  // Six plots of five trees: the linearization at random effects of both coefficients is worse than
  // that with one. Without b's effect nlme 3.1-162 finds -54.4135, and nls without both -54.4208,
  // so that nothing speaks for the larger of these two.
  Table table;
  TextColumn plot;
  for (int row = 0; row < 30; ++row) plot.append(std::to_string(row / 5));
  table.set("g", plot);
  table.set("x", std::vector<double>{17.673, 25.762, 9.48,   30.254, 32.05,  26.978, 30.674, 35.715,
                                     7.11,   28.091, 25.748, 28.952, 23.312, 17.342, 8.076,  23.202,
                                     25.931, 12.237, 24.573, 7.679,  25.826, 39.813, 34.547, 18.676,
                                     39.232, 10.697, 23.617, 17.272, 33.316, 26.141});
  table.set("y", std::vector<double>{17.64397, 22.59124, 11.65038, 21.82605, 24.08815, 19.86355,
                                     20.29426, 23.41601, 11.01131, 20.14210, 17.75279, 22.97370,
                                     17.91756, 16.91525, 12.10306, 22.98488, 20.55136, 11.43234,
                                     21.31052, 12.65264, 20.71243, 25.36562, 24.70559, 18.87936,
                                     23.88197, 11.33847, 19.57832, 17.26824, 24.53648, 19.80966});
  constexpr const char* kMeyer = "y ~ 1.3 + a*(1 - exp(-b*x))";
  const FittedModel contained = searched_fit(table, kMeyer, "a | g");
  CHECK(contained.log_likelihood == Approx(-54.4135).margin(1e-3));
  const FittedModel fit = searched_fit(table, kMeyer, "a + b | g");
  REQUIRE(fit.log_likelihood < contained.log_likelihood - 0.1);
  CHECK(fit.convergence.converged());
  CHECK(fit.convergence.has(Evidence::Kind::kContainedModel, "without random effects"));
  CHECK(fit.convergence.verdict().starts_with("Converged, with a doubt"));
  // Laplace's and the first-order likelihood have a maximum of -54.32 by both.
  CHECK(fit.convergence.verdict().find(" converges at -54.32") != std::string::npos);
}

TEST_CASE("the message of a fit with kinks has the likelihood by quadrature") {
  MixedEffectsFit fit;
  fit.log_likelihood = -100.0;
  fit.convergence = {.status = ConvergenceStatus::kConverged,
                     .findings = {{.names = {"Converged."}}}};
  const auto after = [&](double by_quadrature, const SearchEvidence& evidence) {
    MixedEffectsFit judged = fit;
    judge_quadrature(judged, {{"xmax"}, by_quadrature, 15}, evidence);
    return judged.convergence;
  };
  const Convergence linearized = after(-93.0, {});
  CHECK(linearized.converged());
  CHECK(linearized.has(Evidence::Kind::kMarginal, "agq"));
  CHECK(linearized.verdict().find("kink in xmax") != std::string::npos);
  CHECK(linearized.verdict().find("is -93.00, not -100.00") != std::string::npos);
  // Points may be too few without kinks, too, where the density of the effects is no normal one.
  MixedEffectsFit smooth = fit;
  judge_quadrature(smooth, {{}, -99.0, 15}, {.method = Method::kQuadrature});
  CHECK(smooth.convergence.verdict().find("is -99.00, not -100.00") != std::string::npos);
  // Quadrature with enough points needs no doubt.
  CHECK(after(-100.01, {.method = Method::kQuadrature}).verdict() == "Converged.");
  CHECK(after(-99.0, {.method = Method::kQuadrature}).verdict().find("`agq_points=15`") !=
        std::string::npos);
}

TEST_CASE("a search on a part of many observations has the same result") {
  // 2,100 groups: the part for the comparison of starts is a tenth of them.
  const Curves curves{.groups = 2100,
                      .x = {0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0},
                      .effect_sd = 0.6,
                      .sigma = 0.08,
                      .mean = [](double x, double effect) {
                        return (2.8 + effect) * std::exp(-std::exp(0.8) * x) +
                               0.5 * std::exp(-std::exp(-1.4) * x);
                      }};
  const FittedModel fit = searched_fit(simulated(curves, 1), kBiexponential, "A1 | g");
  REQUIRE(fit.convergence.converged());
  // Five standard errors of means of 2,100 groups.
  CHECK(fit.estimate[0] == Approx(2.8).margin(0.1));
  CHECK(fit.random.back().sd()[0] == Approx(0.6).margin(0.06));
}
