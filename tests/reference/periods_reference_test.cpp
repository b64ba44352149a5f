// SPDX-License-Identifier: MIT
// A study of repeated measurements against R 4.2.2 with nlme 3.1-162; bench/r/reference_periods.R
// drew the trees and made the figures.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "expected.hpp"
#include "silvafit/study/whole_study.hpp"

using namespace silvafit;

TEST_CASE("the random effects of plots and of years within them are those of nlme", "[reference]") {
  const nlohmann::json expected = test::read_expected("nlme_periods.json");
  study::StudyConfiguration settings;
  settings.study.responses = {"h"};
  settings.study.candidates["h"] = {"h ~ 1.3 + a*(1 - exp(-b*dbh))"};
  settings.study.variance_functions = {"none"};
  settings.study.period = "year";
  const study::StudyRecord record =
      study::whole_study(test::reference_data("repeated.csv"),
                         study::Catalogue::load(test::source_file("models")),
                         settings);
  REQUIRE(record.study.results.size() == 1);
  const study::ResponseStudy& result = record.study.results.front();
  CHECK(result.rows.size() == expected["n"].get<std::size_t>());
  CHECK(result.plots == 10);
  // The trees were drawn with random effects of both on the asymptote.
  CHECK(result.chosen_terms(&study::ResponseStudy::random) == "a | plot; a | plot/year");
  REQUIRE(result.nlme);
  const fit::FittedModel& fit = result.nlme->fit;
  REQUIRE(fit.random.size() == 2);
  // nlme stops within its own tolerances: 1e-7 in the estimates, 1e-4 in its penalized step.
  const auto number = [&](const char* key) { return expected[key].get<double>(); };
  CHECK(fit.log_likelihood == Approx(number("log_likelihood")).margin(1e-3));
  CHECK(fit.bic() == Approx(number("BIC")).margin(2e-3));
  CHECK(fit.estimate[0] == Approx(number("a")).epsilon(1e-4));
  CHECK(fit.estimate[1] == Approx(number("b")).epsilon(1e-4));
  CHECK(fit.random.front().sd()[0] == Approx(number("sd_plot")).epsilon(1e-3));
  CHECK(fit.random.back().sd()[0] == Approx(number("sd_year")).epsilon(1e-3));
  CHECK(fit.sigma == Approx(number("sigma")).epsilon(1e-4));
  const auto effect_of = [](const fit::EstimatedEffects& term, const std::string& label) {
    const auto found = std::ranges::find(term.labels, label);
    REQUIRE(found != term.labels.end());
    return term.effects(0, found - term.labels.begin());
  };
  for (int plot = 1; plot <= 10; ++plot) {
    CHECK(effect_of(fit.random.front(), std::to_string(plot)) ==
          Approx(expected["effects_of_plots"][plot - 1].get<double>()).margin(1e-3));
  }
  for (int year = 0; year < 3; ++year) {
    CHECK(effect_of(fit.random.back(), fmt::format("1/{}", 2005 + 7 * year)) ==
          Approx(expected["effects_of_plot_1"][year].get<double>()).margin(1e-3));
  }
  for (const study::Candidate& candidate : result.random) {
    if (candidate.terms == std::vector<std::string>{"a"}) {
      CHECK(candidate.fit.log_likelihood == Approx(number("log_likelihood_plot")).margin(1e-3));
    }
  }
}
