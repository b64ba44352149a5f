// SPDX-License-Identifier: MIT
#include "silvafit/study/catalogue.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "reference.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/study/table_checks.hpp"

using namespace silvafit;
using study::BaseModel;
using study::Catalogue;
using Values = std::map<std::string, double>;

namespace {

const Catalogue& catalogue() {
  static const Catalogue loaded = Catalogue::load(test::source_file("models"));
  return loaded;
}

/// A table of one tree, whose response is 1.
data::Table one_row(const BaseModel& model, const Values& arguments) {
  data::Table table;
  for (const auto& [name, value] : arguments) table.set(name, std::vector<double>{value});
  table.set(model.response, std::vector<double>{1.0});
  return table;
}

/// A models folder of one edited entry, removed at the end.
class TemporaryModels {
 public:
  explicit TemporaryModels(const std::string& name)
      : directory_(std::filesystem::temp_directory_path() / ("silvafit-catalogue-" + name)) {
    std::filesystem::remove_all(directory_);
  }
  ~TemporaryModels() { std::filesystem::remove_all(directory_); }
  TemporaryModels(const TemporaryModels&) = delete;
  TemporaryModels& operator=(const TemporaryModels&) = delete;

  void add(const std::string& file, const nlohmann::json& entry) const {
    write_file(directory_ / "base" / file, entry.dump());
  }
  const std::filesystem::path& path() const { return directory_; }

 private:
  std::filesystem::path directory_;
};

nlohmann::json meyer() {
  return nlohmann::json::parse(read_file(test::source_file("models/base/M04.json")));
}

Values values_of(const std::map<std::string, data::Expression>& expressions,
                 const Values& parameters) {
  Values result;
  std::vector<std::string> names;
  std::vector<double> numbers;
  for (const auto& [name, value] : parameters) {
    names.push_back(name);
    numbers.push_back(value);
  }
  for (const auto& [name, expression] : expressions) {
    result[name] = expression.value(names, numbers);
  }
  return result;
}

}  // namespace

TEST_CASE("the catalogue has the 32 candidates in the order of their numbers") {
  REQUIRE(catalogue().models().size() >= 32);
  for (std::size_t i = 0; i < 32; ++i) {
    CHECK(catalogue().models()[i].id == "M" + std::to_string(i + 1));
  }
  CHECK(catalogue().candidates("h").size() >= 16);
  CHECK(catalogue().candidates("hcb").size() >= 5);
  CHECK(catalogue().candidates("cw").size() >= 11);
  CHECK(catalogue().find("M4").name == "Meyer");
}

TEST_CASE("every base model gives its reference points") {
  for (const BaseModel& model : catalogue().models()) {
    INFO(model.id << " " << model.formula);
    CHECK(model.reference_points.size() >= 3);
    for (const study::ReferencePoint& point : model.reference_points) {
      CHECK_NOTHROW(study::require_domain(model, one_row(model, point.arguments)));
      // About ten rounding errors of 1e-16, the largest enlarged by exponents of about 4.
      CHECK(model.value(point.arguments, point.parameters) ==
            Approx(point.value).epsilon(1e-14).margin(0.0));
    }
  }
}

TEST_CASE("every base model is undefined outside of its domain") {
  for (const BaseModel& model : catalogue().models()) {
    INFO(model.id);
    CHECK_FALSE(model.invalid.empty());
    for (const Values& arguments : model.invalid) {
      CHECK_THROWS_AS(study::require_domain(model, one_row(model, arguments)), DomainError);
    }
  }
}

TEST_CASE("a base model equals another one in the cases of its entry") {
  std::size_t checked = 0;
  for (const BaseModel& model : catalogue().models()) {
    for (const study::Equivalence& equivalence : model.equals) {
      const BaseModel& other = catalogue().find(equivalence.model);
      INFO(model.id << " as " << other.id);
      CHECK(other.response == model.response);
      for (const study::ReferencePoint& point : model.reference_points) {
        Values parameters = point.parameters;
        for (const auto& [name, value] : values_of(equivalence.where, point.parameters)) {
          parameters[name] = value;
        }
        const Values others = values_of(equivalence.with, parameters);
        // Logarithms of parameters cost a few digits more.
        CHECK(model.value(point.arguments, parameters) ==
              Approx(other.value(point.arguments, others)).epsilon(1e-13).margin(0.0));
        ++checked;
      }
    }
  }
  CHECK(checked > 60);
}

TEST_CASE("a base model that is declared as increasing increases at its reference parameters") {
  for (const BaseModel& model : catalogue().models()) {
    if (model.monotone == study::Monotone::kUnknown) continue;
    INFO(model.id);
    const double direction = model.monotone == study::Monotone::kIncreasing ? 1.0 : -1.0;
    for (const study::ReferencePoint& point : model.reference_points) {
      Values arguments = point.arguments;
      arguments["dbh"] = 1.0;
      double last = model.value(arguments, point.parameters);
      for (double dbh = 2.0; dbh <= 80.0; dbh += 1.0) {
        arguments["dbh"] = dbh;
        const double value = model.value(arguments, point.parameters);
        CHECK(direction * (value - last) > 0.0);
        last = value;
      }
    }
  }
}

TEST_CASE("the parameters of reference points have the stated signs") {
  for (const BaseModel& model : catalogue().models()) {
    for (const study::BaseParameter& parameter : model.parameters) {
      for (const study::ReferencePoint& point : model.reference_points) {
        INFO(model.id << " " << parameter.name);
        const double value = point.parameters.at(parameter.name);
        if (parameter.sign == study::Sign::kPositive) CHECK(value > 0.0);
        if (parameter.sign == study::Sign::kNegative) CHECK(value < 0.0);
      }
    }
  }
}

TEST_CASE("the limits of base models are those of their formulas") {
  for (const BaseModel& model : catalogue().models()) {
    for (const study::ReferencePoint& point : model.reference_points) {
      INFO(model.id);
      Values known = point.arguments;
      known.insert(point.parameters.begin(), point.parameters.end());
      Values arguments = point.arguments;
      arguments["dbh"] = 1e-12;
      // Powers of DBH below one approach their limit slowly: (1e-12)^0.4 = 2e-5.
      CHECK(model.value(arguments, point.parameters) ==
            Approx(values_of({{"limit", model.at_zero}}, known).at("limit")).margin(1e-3));
      if (!model.at_infinity) continue;
      arguments["dbh"] = 1e12;
      CHECK(model.value(arguments, point.parameters) ==
            Approx(values_of({{"limit", *model.at_infinity}}, known).at("limit")).epsilon(1e-4));
    }
  }
}

TEST_CASE("the parameters of reference points are sensible") {
  for (const BaseModel& model : catalogue().models()) {
    for (const study::ReferencePoint& point : model.reference_points) {
      INFO(model.id);
      CHECK(model.violated_condition(point.parameters, 72.0).empty());
    }
  }
}

TEST_CASE("all sensible parameters give plausible curves") {
  constexpr double kTop = 72.0;
  Random random(5);
  for (const BaseModel& model : catalogue().models()) {
    std::set<std::string> broken;
    int sensible = 0;
    for (int draw = 0; draw < 2000; ++draw) {
      const auto& point = model.reference_points[draw % model.reference_points.size()];
      Values parameters = point.parameters;
      for (auto& [name, value] : parameters) value *= random.uniform(-1.0, 2.5);
      const std::string violated_condition = model.violated_condition(parameters, kTop);
      if (!violated_condition.empty()) {
        broken.insert(violated_condition);
        continue;
      }
      ++sensible;
      INFO(model.id << " " << nlohmann::json(parameters).dump());
      Values arguments = point.arguments;
      double last = 0.0;
      bool is_plausible = true;
      for (double dbh = 0.1; dbh <= kTop; dbh += 0.1) {
        arguments["dbh"] = dbh;
        const double value = model.value(arguments, parameters);
        is_plausible = is_plausible && std::isfinite(value) && value >= 0.0;
        // Rounding errors of a flat curve.
        if (model.response == "h") is_plausible = is_plausible && value >= last * (1.0 - 1e-12);
        if (model.response == "hcb") is_plausible = is_plausible && value <= arguments.at("h");
        last = value;
      }
      CHECK(is_plausible);
    }
    INFO(model.id);
    CHECK(sensible > 100);
    std::set<std::string> all;
    for (const study::SensibleCondition& each : model.sensible) all.insert(each.otherwise);
    CHECK(broken == all);  // each condition is violated by some parameters
  }
}

TEST_CASE("the derivatives of base models agree with differences") {
  for (const BaseModel& model : catalogue().models()) {
    for (const std::string& name : model.parameter_names()) {
      const data::Expression derivative = model.mean.derivative(name);
      for (const study::ReferencePoint& point : model.reference_points) {
        INFO(model.id << " " << name << ": " << derivative.text());
        Values all = point.arguments;
        all.insert(point.parameters.begin(), point.parameters.end());
        const double exact = values_of({{"d", derivative}}, all).at("d");
        // Five points: error of order step^4, with rounding of 1e-16 / step.
        const double step = 3e-4 * std::max(std::abs(point.parameters.at(name)), 1e-3);
        const auto shifted = [&](double steps) {
          Values parameters = point.parameters;
          parameters[name] += steps * step;
          return model.value(point.arguments, parameters);
        };
        const double difference =
            (8.0 * (shifted(1) - shifted(-1)) - (shifted(2) - shifted(-2))) / (12.0 * step);
        CHECK(exact == Approx(difference).epsilon(1e-7).margin(1e-9));
      }
    }
  }
}

TEST_CASE("start values have the stated signs and are finite") {
  data::Table table(5);
  table.set("dbh", {6.1, 12.0, 18.5, 27.0, data::kMissing});
  table.set("h", {5.0, 10.2, 15.1, 20.4, 12.0});
  table.set("hcb", {2.0, 4.4, 6.0, 8.1, 4.0});
  table.set("cw", {2.1, 3.3, 4.0, 5.2, 3.0});
  for (const BaseModel& model : catalogue().models()) {
    const std::vector<double> start = study::start_values(model, table);
    REQUIRE(start.size() == model.parameters.size());
    for (std::size_t i = 0; i < start.size(); ++i) {
      INFO(model.id << " " << model.parameters[i].name);
      CHECK(std::isfinite(start[i]));
      if (model.parameters[i].sign == study::Sign::kPositive) CHECK(start[i] > 0.0);
      if (model.parameters[i].sign == study::Sign::kNegative) CHECK(start[i] < 0.0);
    }
  }
}

TEST_CASE("start values explain data better than twice their mean", "[reference]") {
  const data::Table table = data::read_csv_table(test::reference_data("fir_mixed/inventory.csv"));
  for (const BaseModel& model : catalogue().models()) {
    const std::vector<double> start = study::start_values(model, table);
    const std::vector<std::string> names = model.parameter_names();
    Values parameters;
    for (std::size_t i = 0; i < names.size(); ++i) parameters[names[i]] = start[i];
    const auto observed = table.numbers(model.response);
    double error = 0.0;
    double about_zero = 0.0;
    for (std::size_t row = 0; row < table.rows(); ++row) {
      Values arguments;
      for (const auto& column : model.covariates) arguments[column] = table.numbers(column)[row];
      error += std::pow(observed[row] - model.value(arguments, parameters), 2);
      about_zero += observed[row] * observed[row];
    }
    INFO(model.id << ": " << error << " of " << about_zero);
    // The right order of magnitude: errors smaller than the response itself.
    CHECK(error < about_zero);
  }
}

TEST_CASE("an unknown model is an error that lists the available ones") {
  CHECK_THROWS_AS(catalogue().find("M99"), UsageError);
  CHECK_THROWS_WITH(catalogue().find("M99"),
                    Catch::Contains("M1 (Naslund), M2 (Curtis)") && Catch::Contains("M99"));
}

TEST_CASE("models are found by their names") {
  CHECK(catalogue().find("naslund").id == "M1");
  CHECK(catalogue().find("Näslund").id == "M1");
  CHECK(catalogue().find("chapman_richards").id == "M8");
  CHECK(catalogue().find("hossfeld iv").id == "M16");
  // Of heights and of crown widths.
  CHECK_THROWS_WITH(catalogue().find("power"), Catch::Contains("several models are called power"));
}

TEST_CASE("a wrong entry is an error with its file and key") {
  const TemporaryModels folder("wrong");
  nlohmann::json entry = meyer();
  std::string message;
  SECTION("a misspelled name in the formula") {
    entry["formula"] = "h ~ 1.3 + a*(1 - exp(-b*dhb))";
    message = "formula: unknown 'dhb'";
  }
  SECTION("a formula that cannot be read") {
    entry["formula"] = "h ~ 1.3 + a*(1 - exp(-b*dbh)";
    message = "formula: ";
  }
  SECTION("another response than the formula's") {
    entry["response"] = "cw";
    message = "formula: must begin with cw ~";
  }
  SECTION("a parameter that the formula does not use") {
    entry["formula"] = "h ~ 1.3 + a*dbh";
    message = "formula: does not use the parameter b";
  }
  SECTION("a start rule with an unknown summary") {
    entry["parameters"][1]["start"] = "1/average_dbh";
    message = "parameters[1].start: unknown 'average_dbh'";
  }
  SECTION("a key that is not known") {
    entry["parametres"] = 1;
    message = "unknown key \"parametres\"";
  }
  SECTION("a missing key") {
    entry.erase("source");
    message = "the key \"source\" is missing";
  }
  SECTION("a sensible condition on something else than parameters") {
    entry["sensible"][0]["condition"] = "a > top";
    message = "sensible[0].condition: unknown 'top'; available: a, b, top_dbh";
  }
  SECTION("a reference point without a parameter") {
    entry["reference_points"][0]["parameters"].erase("b");
    message = "reference_points[0].parameters: must name a, b";
  }
  folder.add("M04.json", entry);
  CHECK_THROWS_AS(Catalogue::load(folder.path()), InputError);
  CHECK_THROWS_WITH(Catalogue::load(folder.path()),
                    Catch::Contains("M04.json") && Catch::Contains(message));
}

TEST_CASE("two entries of one id, and a folder without entries, are errors") {
  const TemporaryModels folder("two");
  CHECK_THROWS_WITH(Catalogue::load(folder.path()), Catch::Contains("no base models were found"));
  folder.add("M04.json", meyer());
  folder.add("M4.json", meyer());
  CHECK_THROWS_WITH(Catalogue::load(folder.path()), Catch::Contains("has the same id M4"));
}

TEST_CASE("invalid JSON is an error with its line") {
  const TemporaryModels folder("broken");
  write_file(folder.path() / "base" / "M01.json", "{\n \"id\": \"M1\",\n \"name\" \"x\"\n}\n");
  CHECK_THROWS_WITH(Catalogue::load(folder.path()), Catch::Contains("M01.json:3: not valid JSON"));
}
