// SPDX-License-Identifier: MIT
#include "silvafit/data/text_formula.hpp"

#include <catch2/catch.hpp>

#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"

using Catch::Matchers::Contains;
using namespace silvafit;
using namespace silvafit::data;

namespace {

/// Three trees; the second has no epithet and no dbh in 2018.
Table trees() {
  Table table(3);
  TextColumn genus;
  TextColumn epithet;
  for (const char* text : {"Abies", "Abies", "Fagus"}) genus.append(text);
  epithet.append("alba");
  epithet.append_missing();
  epithet.append("sylvatica");
  table.set("genus", genus);
  table.set("epithet", epithet);
  table.set("DBH.2018", std::vector<double>{30.5, kMissing, -999.0});
  table.set("DBH.2013", std::vector<double>{28.0, 12.0, 40.0});
  return table;
}

std::vector<std::string> values_of(const char* text) {
  const Table table = trees();
  const auto formula = TextFormula::parse(text, table.names(), "trees.csv");
  REQUIRE(formula);
  const TextColumn values =
      formula->values(table, [](std::string_view value) { return value == "-999"; });
  std::vector<std::string> texts;
  for (std::size_t row = 0; row < values.size(); ++row) {
    texts.emplace_back(values.is_missing(row) ? "missing" : values[row]);
  }
  return texts;
}

using Texts = std::vector<std::string>;

}  // namespace

TEST_CASE("texts are joined, chosen and replaced where they are missing") {
  CHECK(values_of("genus + \" \" + epithet") == Texts{"Abies alba", "missing", "Fagus sylvatica"});
  CHECK(values_of("first(DBH.2018, DBH.2013)") == Texts{"30.5", "12", "40"});
  CHECK(values_of("first(epithet, \"sp.\")") == Texts{"alba", "sp.", "sylvatica"});
  CHECK(values_of("genus + \" \" + first(epithet, \"sp.\")") ==
        Texts{"Abies alba", "Abies sp.", "Fagus sylvatica"});
  CHECK(values_of("ifelse(DBH.2013 > 20, \"large\", \"small\")") ==
        Texts{"large", "small", "large"});
  CHECK(values_of("ifelse(genus == \"Fagus\", \"beech\", ifelse(DBH.2013 > 20, genus, NA))") ==
        Texts{"Abies", "missing", "beech"});
}

TEST_CASE("formulas of numbers and joined labels are no texts") {
  const Table table = trees();
  for (const char* text : {"genus",
                           "genus+epithet",
                           "`DBH.2013`/10",
                           "DBH.2018 - DBH.2013",
                           "ifelse(genus == \"Abies\", DBH.2018, DBH.2013)"}) {
    CHECK_FALSE(TextFormula::parse(text, table.names(), ""));
  }
}

TEST_CASE("a text that cannot be read is refused with the reason") {
  const Table table = trees();
  const auto parse = [&](const char* text) {
    return TextFormula::parse(text, table.names(), "trees.csv");
  };
  CHECK_THROWS_AS(parse("genus + \" \" + epitet"), InputError);
  CHECK_THROWS_WITH(parse("genus + \" \" + epitet"),
                    Contains("trees.csv: unknown column 'epitet' in genus") &&
                        Contains("available: genus, epithet"));
  CHECK_THROWS_WITH(parse("first(DBH.2018, DBH.2013)/10"), Contains("is a value of its own"));
}
