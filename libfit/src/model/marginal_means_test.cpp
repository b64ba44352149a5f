// SPDX-License-Identifier: MIT
#include "model/marginal_means.hpp"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"

using namespace silvafit;
using namespace silvafit::fit;

namespace {

data::Table trees() {
  data::Table table;
  data::TextColumn species;
  data::TextColumn site;
  for (const char letter : std::string("AAAAAABBBBBBCCCCCC"))
    species.append(std::string(1, letter));
  for (const char letter : std::string("uuuuvvuvvvvuuuvuvv")) site.append(std::string(1, letter));
  table.set("species", species);
  table.set("site", site);
  table.set(
      "z",
      {1.2, 0.4, 2.2, 1.9, 0.3, 1.1, 0.7, 1.6, 2.4, 0.9, 1.3, 0.2, 1.8, 2.1, 0.6, 1.4, 0.5, 1.0});
  table.set("x", {12, 25, 18, 31, 9, 22, 14, 27, 35, 19, 11, 24, 16, 29, 21, 33, 13, 26});
  table.set("y",
            {10.1,
             16.9,
             14.8,
             22.6,
             7.7,
             15.2,
             9.9,
             19.4,
             26.1,
             14.0,
             10.2,
             13.7,
             13.9,
             22.2,
             13.1,
             22.9,
             8.8,
             16.6});
  return table;
}

const ModelTexts kTexts{.formula = "y ~ a + b*x",
                        .sub_models = {"a ~ species*z + site", "b ~ species"},
                        .means = {"species", "site"}};

}  // namespace

TEST_CASE("Estimated marginal means of parameters are those of emmeans") {
  const data::Table table = trees();
  const FittedModel fit = fit_model(specify_model(kTexts, table), table).fit;
  // bench/r/reference_marginal_means.R: R 4.2.2, emmeans.
  struct Mean {
    std::string name;
    double estimate;
    double standard_error;
  };
  const std::vector<Mean> expected{{"a (species A)", 3.10260201973, 0.637057631780},
                                   {"a (species B)", 4.40727697345, 0.763528520849},
                                   {"a (species C)", 3.16801188102, 0.799061055983},
                                   {"b (species A)", 0.586070684488, 0.0311201661613},
                                   {"b (species B)", 0.518374519178, 0.0328918937450},
                                   {"b (species C)", 0.564730112615, 0.0337017072995},
                                   {"a (site u)", 3.67124557488, 0.512202529214},
                                   {"a (site v)", 3.44734834125, 0.430853645888}};
  const std::vector<DerivedValue> means = derived_values(fit);
  REQUIRE(means.size() == expected.size());
  for (std::size_t i = 0; i < means.size(); ++i) {
    INFO(expected[i].name);
    CHECK(fit.specification.derived[i].name == expected[i].name);
    CHECK(means[i].estimate == Approx(expected[i].estimate).epsilon(1e-9));
    CHECK(means[i].standard_error == Approx(expected[i].standard_error).epsilon(1e-9));
    CHECK(means[i].degrees_of_freedom == 8.0);
  }
}

TEST_CASE("Marginal means are kept in files, and comparisons with texts are factors") {
  const data::Table table = trees();
  const FittedModel fit = fit_model(specify_model(kTexts, table), table).fit;
  const FittedModel read = from_json(to_json(fit), "fit.json");
  REQUIRE(read.specification.derived.size() == 8);
  CHECK(derived_values(read)[1].estimate == derived_values(fit)[1].estimate);
  // A comparison has the same mean as the factor of two levels.
  ModelTexts texts{.formula = "y ~ a + b*x", .sub_models = {"a ~ species + site"}};
  texts.means = {"species"};
  ModelTexts compared = texts;
  compared.sub_models = {"a ~ species + (site == \"v\")"};
  const auto means = derived_values(fit_model(specify_model(texts, table), table).fit);
  const auto same = derived_values(fit_model(specify_model(compared, table), table).fit);
  for (std::size_t i = 0; i < means.size(); ++i) {
    CHECK(same[i].estimate == Approx(means[i].estimate).epsilon(1e-12));
  }
}

TEST_CASE("A mean of a coefficient that varies has the freedom of the groups, as in emmeans") {
  data::Table table = trees();
  data::TextColumn plot;
  for (int row = 0; row < 18; ++row) plot.append(std::to_string(row % 5));
  table.set("plot", plot);
  ModelTexts texts{.formula = "y ~ a + b*x",
                   .sub_models = {"a ~ species"},
                   .random = "a | plot",
                   .means = {"species"}};
  const FittedModel fit = fit_model(specify_model(texts, table), table).fit;
  for (const DerivedValue& mean : derived_values(fit)) CHECK(mean.degrees_of_freedom == 4.0);
}

TEST_CASE("Rows without a value have no part in the means of numbers") {
  data::Table table = trees();
  std::vector<double> z{table.numbers("z").begin(), table.numbers("z").end()};
  z[17] = 100.0;
  std::vector<double> y{table.numbers("y").begin(), table.numbers("y").end()};
  y[17] = data::kMissing;
  table.set("z", z);
  table.set("y", y);
  const auto means = specify_model(kTexts, table).derived;
  // The mean of z over the other 17 rows.
  CHECK(means.front().value.text().find("1.211764705882") != std::string::npos);
}

TEST_CASE("Means are of factors") {
  const data::Table table = trees();
  ModelTexts texts = kTexts;
  texts.means = {"z"};
  CHECK_THROWS_WITH(specify_model(texts, table),
                    Catch::Matchers::Contains("'z' is not a factor of a sub-model; factors: "));
  texts.means = {"site", "site"};
  CHECK_THROWS_WITH(specify_model(texts, table),
                    Catch::Matchers::Contains("'site' is given twice"));
}
