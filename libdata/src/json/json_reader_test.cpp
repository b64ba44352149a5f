// SPDX-License-Identifier: MIT
#include "silvafit/data/json_reader.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "silvafit/base/error.hpp"

using Catch::Contains;
using silvafit::InputError;
using silvafit::data::JsonReader;

namespace {

JsonReader of(const char* text) { return JsonReader::parse(text, "a.json"); }

std::vector<std::string> names_of(const std::vector<std::pair<std::string, JsonReader>>& members) {
  std::vector<std::string> names;
  names.reserve(members.size());
  for (const auto& [name, value] : members) names.push_back(name);
  return names;
}

}  // namespace

TEST_CASE("complaints name the file and the way to the value") {
  const JsonReader json = of(R"({"species": [{}, {"dbh": {"sd": "wide"}}]})");
  CHECK_THROWS_WITH(json.at("species").items()[1].at("dbh").at("sd").number(),
                    "a.json: species[1].dbh.sd: must be a number, not \"wide\"");
  CHECK_THROWS_WITH(json.at("trees"), "a.json: the key \"trees\" is missing");
  CHECK_THROWS_WITH(json.at("species").text(), "a.json: species: must be a text, not a list of 2");
  CHECK_THROWS_WITH(json.items(), "a.json: must be a list, not an object");
  CHECK_THROWS_AS(json.at("trees"), InputError);
}

TEST_CASE("a text that is no JSON is refused with its line") {
  CHECK_THROWS_WITH(of("{\n\"a\": 1\n\"b\": 2}"),
                    Contains("a.json:3: not valid JSON; look for a missing comma"));
  CHECK_THROWS_WITH(of("[1e999]"), "a.json: a number is too large");
  CHECK_THROWS_WITH(of(R"({"b": {"a": 1, "c": 2, "a": 3}})"),
                    "a.json: the key \"a\" occurs twice in an object");
  CHECK_THROWS_AS(of("{} // nothing"), InputError);
  CHECK(JsonReader::parse("{} // nothing", "a.json", true).is_object());
}

TEST_CASE("what people write is read strictly, what programs write may lack values") {
  const JsonReader json = of(R"({"text": "", "number": null, "count": 0, "list": [1, null]})");
  CHECK_THROWS_WITH(json.at("text").text(), Contains("text: must be a text, not \"\""));
  CHECK(json.at("text").any_text().empty());
  CHECK_THROWS_WITH(json.at("number").number(), Contains("must be a number, not null"));
  CHECK(std::isnan(json.at("number").number_or_missing()));
  CHECK_THROWS_WITH(json.at("count").count(), Contains("must be a whole number above 0, not 0"));
  CHECK(json.at("count").count_or_zero() == 0);
  CHECK_THROWS_WITH(json.at("list").numbers(), Contains("list[1]: must be a number"));
  CHECK(json.at("list").vector(2)[0] == 1.0);
  CHECK(std::isnan(json.at("list").vector(2)[1]));
  CHECK_THROWS_WITH(json.at("list").vector(3), "a.json: list: must have 3 numbers, not 2");
  CHECK_THROWS_WITH(json.at("number").count_or_zero(), Contains("must be a whole number of 0 or"));
}

TEST_CASE("a matrix has as many rows and columns as it must") {
  const JsonReader json = of(R"({"square": [[1, 2], [3, null]], "ragged": [[1, 2], [3]]})");
  const Eigen::MatrixXd square = json.at("square").square_matrix(2);
  CHECK(square(0, 1) == 2.0);
  CHECK(square(1, 0) == 3.0);
  CHECK(std::isnan(square(1, 1)));
  CHECK_THROWS_WITH(json.at("square").square_matrix(3), "a.json: square: must have 3 rows, not 2");
  CHECK_THROWS_WITH(json.at("ragged").square_matrix(2),
                    "a.json: ragged[1]: must have 2 numbers, not 1");
}

TEST_CASE("members are in the order of the document, or by name") {
  const JsonReader json = of(R"({"b": 1, "c": 2, "a": 3})");
  CHECK(names_of(json.members()) == std::vector<std::string>{"b", "c", "a"});
  CHECK(names_of(json.members_by_name()) == std::vector<std::string>{"a", "b", "c"});
  CHECK(json.numbers_by_name().at("c") == 2.0);
}

TEST_CASE("unknown keys and values are refused with the known ones") {
  const JsonReader json = of(R"({"per": "plot", "edge": "round"})");
  CHECK_THROWS_WITH(json.allow_only({"per", "window"}),
                    "a.json: unknown key \"edge\"; available: per, window");
  CHECK(json.at("per").one_of({"stand", "plot"}) == 1);
  CHECK_THROWS_WITH(json.at("edge").one_of({"buffer", "torus"}),
                    "a.json: edge: must be one of buffer, torus, not \"round\"");
}

TEST_CASE("ranges of numbers are held to") {
  const JsonReader json = of(R"({"share": 1.5, "least": -1, "none": 0})");
  CHECK_THROWS_WITH(json.at("share").number_between(0.0, 1.0),
                    Contains("must be between 0 and 1, not 1.5"));
  CHECK_THROWS_WITH(json.at("least").not_negative(), Contains("must be 0 or more, not -1"));
  CHECK_THROWS_WITH(json.at("none").positive(), Contains("must be above 0, not 0"));
  CHECK(json.at("none").not_negative() == 0.0);
}

TEST_CASE("formulas in JSON keep the place of their faults") {
  const JsonReader json = of(R"({"mean": "a*dbh +", "rules": {"a": "1/mean_dbh"}})");
  CHECK_THROWS_WITH(json.at("mean").expression(), Contains("a.json: mean:"));
  CHECK(json.at("rules").expressions_by_name().at("a").text() == "1/mean_dbh");
}
