// SPDX-License-Identifier: MIT
// The columns of sub-models compared with R 4.2.2: model.matrix(~ right side, d) with
//   d <- expand.grid(f = c("A", "B", "C"), g = c("u", "v"), r = 1:2, stringsAsFactors = TRUE)
//   d$x <- seq_len(nrow(d)); d$z <- sqrt(d$x)
#include "model/factor_columns.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "silvafit/base/error.hpp"
#include "silvafit/data/program.hpp"

using namespace silvafit::fit;
using Catch::Matchers::Contains;
using silvafit::FormulaError;
using silvafit::InputError;
using silvafit::data::Table;
using silvafit::data::TextColumn;

namespace {

using Names = std::vector<std::string>;

TextColumn text_column(const Names& values) {
  TextColumn column;
  for (const std::string& value : values) {
    if (value.empty()) {
      column.append_missing();
    } else {
      column.append(value);
    }
  }
  return column;
}

/// The data of R above, with a response.
Table crossed() {
  Table table(12);
  TextColumn f;
  TextColumn g;
  std::vector<double> x;
  std::vector<double> z;
  std::vector<double> r;
  for (int i = 0; i < 12; ++i) {
    f.append(std::string(1, "ABC"[i % 3]));
    g.append(std::string(1, "uv"[i / 3 % 2]));
    x.push_back(i + 1.0);
    z.push_back(std::sqrt(i + 1.0));
    r.push_back(1.0 + i / 6);
  }
  table.set("f", f);
  table.set("g", g);
  table.set("x", x);
  table.set("z", z);
  table.set("r", r);
  table.set("y", x);
  return table;
}

ParameterModel model_of(const std::string& right_side, const Table& table) {
  return specify_model("y ~ b", {"b ~ " + right_side}, table).parameters.front();
}

Names labels_of(const ParameterModel& model) {
  Names labels;
  for (const Covariate& covariate : model.covariates) labels.push_back(covariate.label);
  return labels;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from)) {
    text.replace(at, from.size(), to);
  }
  return text;
}

/// R's names: fB for (f == "B").
std::string columns_as_in_r(const ParameterModel& model) {
  std::string names = model.has_intercept ? "1" : "";
  for (const std::string& label : labels_of(model)) {
    names += (names.empty() ? "" : " ") + label;
  }
  for (const char* remove : {"(", " == ", "\"", ")"}) names = replaced(names, remove, "");
  return names;
}

}  // namespace

TEST_CASE("sub-models have the columns of R's model.matrix") {
  struct Expected {
    const char* right_side = nullptr;
    const char* columns = nullptr;
  };
  const Table table = crossed();
  for (const auto& [right_side, columns] : {
           Expected{"x", "1 x"},
           Expected{"x*z", "1 x z x:z"},
           Expected{"x + x", "1 x"},
           Expected{"z:x + x", "1 x z:x"},
           Expected{"x*z - z", "1 x x:z"},
           Expected{"x + z - 1", "x z"},
           Expected{"0 + x + 1", "1 x"},
           Expected{"(x + z)^2 - x:z", "1 x z"},
           Expected{"x*(z + r)", "1 x z r x:z x:r"},
           Expected{"f", "1 fB fC"},
           Expected{"0 + f", "fA fB fC"},
           Expected{"x*f", "1 x fB fC x:fB x:fC"},
           Expected{"0 + x*f", "x fA fB fC x:fB x:fC"},
           Expected{"f:x", "1 fA:x fB:x fC:x"},
           Expected{"x + f:x", "1 x fB:x fC:x"},
           Expected{"0 + f:x", "fA:x fB:x fC:x"},
           Expected{"0 + f + f:x", "fA fB fC fA:x fB:x fC:x"},
           Expected{"0 + x + f + g", "x fA fB fC gv"},
           Expected{"f + g:x", "1 fB fC gu:x gv:x"},
           Expected{"x:f + z:g", "1 x:fA x:fB x:fC z:gu z:gv"},
           Expected{"0 + x:f + g", "gu gv x:fA x:fB x:fC"},
           Expected{"x:z + x:f", "1 x:z x:fB x:fC"},
           Expected{"f*g", "1 fB fC gv fB:gv fC:gv"},
           Expected{"f + f:g", "1 fB fC fA:gv fB:gv fC:gv"},
           Expected{"f*g - f", "1 gv fB:gu fC:gu fB:gv fC:gv"},
           Expected{"f*g - 1", "fA fB fC gv fB:gv fC:gv"},
           Expected{"0 + f:g", "fA:gu fB:gu fC:gu fA:gv fB:gv fC:gv"},
           Expected{"g + f:g:x", "1 gv fA:gu:x fB:gu:x fC:gu:x fA:gv:x fB:gv:x fC:gv:x"},
           Expected{"(f + g + x)^2", "1 fB fC gv x fB:gv fC:gv fB:x fC:x gv:x"},
           Expected{"f*g*x - f:g:x", "1 fB fC gv x fB:gv fC:gv fB:x fC:x gv:x"},
           Expected{"f*g*x", "1 fB fC gv x fB:gv fC:gv fB:x fC:x gv:x fB:gv:x fC:gv:x"},
           Expected{"factor(r)*x", "1 r2 x r2:x"},
       }) {
    INFO(right_side);
    const ParameterModel model = model_of(right_side, table);
    CHECK(columns_as_in_r(model) == columns);
    // The stored text is read as the same columns.
    const ParameterModel stored = parse_stored_parameter_model("b", model.text());
    CHECK(stored.coefficient_names() == model.coefficient_names());
    REQUIRE(stored.covariates.size() == model.covariates.size());
    for (std::size_t k = 0; k < stored.covariates.size(); ++k) {
      CHECK(stored.covariates[k].value.text() == model.covariates[k].value.text());
    }
  }
}

TEST_CASE("the columns of factors and products have the values of R") {
  const Table table = crossed();
  const ParameterModel model = model_of("x + f:x + f:g", table);
  // Row 5 is f = B, g = v, x = 5; R: 1, 5, 5, 0 of x:f, and one of the levels of f:g.
  std::vector<double> row;
  for (const Covariate& covariate : model_of("x*f*g", table).covariates) {
    row.push_back(silvafit::data::evaluate(covariate.value, table)[4]);
  }
  // x fB fC gv x:fB x:fC x:gv fB:gv fC:gv x:fB:gv x:fC:gv
  CHECK(row == std::vector<double>{5, 1, 0, 1, 5, 0, 5, 1, 0, 5, 0});
  CHECK(labels_of(model_of("I(x^2) + log(x):z", table)) == Names{"I(x^2)", "log(x):z"});
  CHECK(silvafit::data::evaluate(model_of("I(x^2):z", table).covariates[0].value, table)[3] == 32);
}

TEST_CASE("levels are sorted: numbers by value, text without regard to case") {
  Table table(6);
  table.set("y", std::vector<double>{1, 2, 3, 4, 5, 6});
  table.set("year", std::vector<double>{10, 9, 100, 9, 10, 100});
  table.set("code", text_column({"10", "9", "100", "9", "10", "100"}));
  table.set("tree", text_column({"Oak", "beech", "oak", "Beech", "fir 2", "fir-1"}));
  CHECK(labels_of(model_of("factor(year)", table)) ==
        Names{R"((year == "10"))", R"((year == "100"))"});
  CHECK(labels_of(model_of("factor(code)", table)) ==
        Names{R"((code == "10"))", R"((code == "100"))"});
  // R's sort() in en_US.UTF-8: beech Beech fir-1 fir 2 oak Oak, except for blanks.
  CHECK(labels_of(model_of("tree", table)) == Names{R"((tree == "Beech"))",
                                                    R"((tree == "fir 2"))",
                                                    R"((tree == "fir-1"))",
                                                    R"((tree == "oak"))",
                                                    R"((tree == "Oak"))"});
}

TEST_CASE("names with blanks and quotes can be levels") {
  Table table(3);
  table.set("y", std::vector<double>{1, 2, 3});
  table.set("the kind", text_column({"a + b", "it's", R"(5" pipe)"}));
  const ParameterModel model = model_of("0 + `the kind`", table);
  CHECK(labels_of(model) == Names{R"((`the kind` == '5" pipe'))",
                                  R"((`the kind` == "a + b"))",
                                  R"((`the kind` == "it's"))"});
  const ParameterModel stored = parse_stored_parameter_model("b", model.text());
  for (std::size_t k = 0; k < 3; ++k) {
    const auto values = silvafit::data::evaluate(stored.covariates[k].value, table);
    CHECK(values == silvafit::data::evaluate(model.covariates[k].value, table));
    CHECK(values[k == 0 ? 2 : k - 1] == 1.0);
  }
}

TEST_CASE("levels of incomplete rows are ignored") {
  Table table(5);
  const double missing = silvafit::data::kMissing;
  table.set("y", std::vector<double>{1, 2, 3, 4, missing});
  table.set("x", std::vector<double>{1, 2, 3, missing, 5});
  table.set("f", text_column({"A", "B", "", "C", "D"}));
  ModelSpecification model = specify_model("y ~ b + c*x", {"b ~ f"}, table);
  CHECK(model.coefficient_names() == Names{"b", R"(b:(f == "B"))", "c"});
  CHECK(model.factors == Names{"f"});
  CHECK(model.label_columns() == Names{"f"});
  CHECK(specify_model("y ~ b", {"b ~ (f == \"B\")"}, table).factors.empty());
}

TEST_CASE("levels of removed rows are ignored") {
  Table table(5);
  table.set("y", std::vector<double>{1, 2, 3, 4, 5});
  table.set("f", text_column({"B", "12", "A", "13", "B"}));
  table.set_origin("trees.csv", {2, 3, 4, 5, 6});
  const std::vector<std::size_t> letters{0, 2, 4};
  const std::vector<std::size_t> numbers{1, 3};
  CHECK(labels_of(model_of("f", table.select(letters))) == Names{R"((f == "B"))"});
  CHECK_THROWS_WITH(model_of("f", table.select(numbers)), Contains("'12' is text that looks"));
}

TEST_CASE("factors that cannot be coded are refused") {
  Table table(4);
  table.set("y", std::vector<double>{1, 2, 3, 4});
  table.set("x", std::vector<double>{1, 2, 3, 4});
  table.set("one", text_column({"A", "A", "A", "A"}));
  table.set("typing", text_column({"1.5", "2", "2,5", "x3"}));
  table.set("code", text_column({"01", "02", "01", "02"}));
  table.set("f", text_column({"A", "B", "A", "B"}));
  table.set("g", text_column({"u", "u", "v", "u"}));
  table.set("quoted", text_column({R"(5' 6")", "B", "A", "B"}));
  table.set_origin("trees.csv", {2, 3, 4, 5});
  CHECK_THROWS_WITH(model_of("one", table), Contains("only 'A'") && Contains("remove one from"));
  CHECK_THROWS_WITH(
      model_of("typing", table),
      Contains("trees.csv:5: typing: 'x3' is not a number") && Contains("factor(typing)"));
  CHECK_THROWS_WITH(model_of("code", table), Contains("looks like a number"));
  CHECK(labels_of(model_of("factor(code)", table)) == Names{R"((code == "02"))"});
  CHECK_THROWS_WITH(model_of("f*g", table), Contains("no row has a value of (f == \"B\"):(g"));
  CHECK_THROWS_WITH(model_of("quoted", table), Contains("both kinds of quotes"));
  CHECK_THROWS_AS(model_of("one", table), InputError);
}

TEST_CASE("texts of digits in a table without a file are names") {
  Table table(4);
  table.set("y", std::vector<double>{1, 2, 3, 4});
  table.set("x", std::vector<double>{1, 2, 3, 4});
  table.set("code", text_column({"1", "2", "1", "2"}));
  CHECK(labels_of(model_of("code", table)) == Names{R"((code == "2"))"});
}

TEST_CASE("more coefficients than rows are refused before their columns are computed") {
  Table table(150);
  Names f;
  Names g;
  for (int i = 0; i < 150; ++i) {
    f.push_back("f" + std::to_string(i % 30));
    g.push_back("g" + std::to_string(i / 30));
  }
  g.back() = "";  // not complete
  table.set("f", text_column(f));
  table.set("g", text_column(g));
  table.set("y", std::vector<double>(150, 1.0));
  table.set("x", std::vector<double>(150, 1.0));
  table.set_origin("trees.csv", std::vector<std::uint32_t>(150, 1));
  CHECK_THROWS_WITH(model_of("f*g", table),
                    Contains("trees.csv: 150 coefficients of") && Contains("149 rows"));
}

TEST_CASE("columns that R would give no coefficient are refused") {
  // R 4.2.2: rank 6 of 7, 7 of 8 and 3 of 4.
  const Table table = crossed();
  for (const char* right_side : {"f:g", "x + f:g", "0 + x + x:f"}) {
    INFO(right_side);
    CHECK_THROWS_WITH(model_of(right_side, table), Contains("are linearly dependent"));
  }
  CHECK_THROWS_WITH(model_of("f:g", table), Contains("write f*g or begin with 0 +"));
}

TEST_CASE("without data there are no factors") {
  CHECK(parse_parameter_model("b ~ C*U").coefficient_names() == Names{"b", "b:C", "b:U", "b:C:U"});
  CHECK_THROWS_WITH(parse_parameter_model("b ~ factor(C)"), Contains("factors need data"));
}
