// SPDX-License-Identifier: MIT
// The published coefficients in models/published: each entry against the catalogue and against
// the fit statistics of its source.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "reference.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/fit/model_specification.hpp"
#include "silvafit/study/catalogue.hpp"

using namespace silvafit;
using nlohmann::json;

namespace {

json shanxia() {
  return json::parse(read_file(test::source_file("models/published/shanxia-2023.json")));
}

const json& entry(const json& document, const std::string& id) {
  for (const json& model : document["models"]) {
    if (model["id"] == id) return model;
  }
  throw std::out_of_range(id);
}

}  // namespace

TEST_CASE("published models are base models with coefficients for all their terms") {
  const study::Catalogue catalogue = study::Catalogue::load(test::source_file("models"));
  const json document = shanxia();
  CHECK(document["models"].size() == 27);
  std::set<std::string> ids;
  for (const json& model : document["models"]) {
    INFO(model["id"]);
    CHECK(ids.insert(model["id"]).second);
    const study::BaseModel& base = catalogue.find(model["base_model"].get<std::string>());
    CHECK(model["formula"] == base.formula);
    CHECK(model["response"] == base.response);
    std::set<std::string> names;
    for (const std::string& parameter : base.parameter_names()) {
      const auto sub_model = fit::parse_parameter_model(
          parameter + " ~ " + model["parameters"][parameter].get<std::string>());
      for (const std::string& name : sub_model.coefficient_names()) names.insert(name);
    }
    std::set<std::string> given;
    for (const auto& item : model["fixed"].items()) given.insert(item.key());
    CHECK(given == names);
    if (!model.contains("random")) continue;
    const json& random = model["random"];
    CHECK(random["variance"].size() == random["effects"].size());
    CHECK(random["correlation"].size() == random["effects"].size());
    for (const json& effect : random["effects"]) CHECK(names.count(effect) == 1);
  }
}

TEST_CASE("RMSE, number of trees and log-likelihood of the published height models agree") {
  const json document = shanxia();
  for (const char* species : {"SM", "BHN", "MH"}) {
    const json& statistics = entry(document, std::string(species) + "-h-base")["statistics"];
    const double n = statistics["n"];
    const double error = statistics["mean_error"];
    const double rmse = statistics["rmse"];
    const double sse = (rmse * rmse - error * error) * (n - 1.0) + n * error * error;
    const double log_likelihood = -0.5 * n * (std::log(2.0 * std::numbers::pi * sse / n) + 1.0);
    INFO(species);
    // Four digits of the RMSE are 961 / 2.76 * 5e-5 = 0.02 of the log-likelihood.
    CHECK(log_likelihood == Approx(statistics["log_likelihood"].get<double>()).margin(0.02));
  }
}

TEST_CASE("AIC and log-likelihood of the published base models agree on the parameters") {
  const json document = shanxia();
  for (const json& model : document["models"]) {
    if (model["level"] != "base") continue;
    INFO(model["id"]);
    const auto parameters = static_cast<double>(model["fixed"].size()) + 1.0;
    const json& statistics = model["statistics"];
    const double aic = -2.0 * statistics["log_likelihood"].get<double>() + 2.0 * parameters;
    // The log-likelihood is printed to 0.01.
    CHECK(aic == Approx(statistics["aic"].get<double>()).margin(0.011));
  }
}
