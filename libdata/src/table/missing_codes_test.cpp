// SPDX-License-Identifier: MIT
#include "silvafit/data/missing_codes.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace silvafit::data;

TEST_CASE("values that may be codes are found") {
  std::vector<double> values;
  for (int k = 0; k < 40; ++k) values.push_back(15.0 + 0.37 * k);
  const auto with = [&values](std::vector<double> more) {
    more.insert(more.end(), values.begin(), values.end());
    return more;
  };
  CHECK_FALSE(possible_code(values));
  CHECK_FALSE(possible_code({}));
  CHECK(possible_code(with({-99.0})) == -99.0);
  CHECK(possible_code(with({kMissing, -999.0, -999.0})) == -999.0);
  CHECK_FALSE(possible_code(with({-99.0, -3.0})));  // other values are negative, too
  CHECK(possible_code(with({99.9, 99.9, 99.9})) == 99.9);
  CHECK_FALSE(possible_code(with({99.9, 99.9})));
  CHECK(possible_code(with({9999.0})) == 9999.0);
  CHECK_FALSE(possible_code(with({999.0})));
  CHECK_FALSE(possible_code(with({98.0, 98.0, 98.0})));
  CHECK_FALSE(possible_code(with({29.9, 29.9, 29.9})));
  CHECK_FALSE(possible_code(with({-9.9, -9.9, -9.9})));
  CHECK_FALSE(possible_code(with({-10.0, -10.0, -10.0})));
  CHECK(possible_code(with({0.0, 0.0, 0.0}), true) == 0.0);
  CHECK_FALSE(possible_code(with({0.0, 0.0, 0.0})));
}

TEST_CASE("codes -9999 and -99999 are missing in columns of numbers, and counted") {
  Table table;
  table.set("h", std::vector<double>{1.0, -9999.0, -99999.0, -999.0, -9.0});
  table.set("t", std::vector<double>{-9999.0, -4.0, 0.0, 1.0, 2.0});
  TextColumn text;
  for (const char* const label : {"-9999", "a", "b", "c", "d"}) text.append(label);
  table.set("plot", text);
  MissingCodes found;
  take_missing_codes(table, found);
  CHECK(found.note() == "codes read as missing values: h 2 (-9999, -99999), t 1 (-9999)");
  CHECK(std::isnan(table.numbers("h")[1]));
  CHECK(std::isnan(table.numbers("h")[2]));
  CHECK(table.numbers("h")[3] == -999.0);
  CHECK(std::isnan(table.numbers("t")[0]));
  CHECK(table.text("plot")[0] == "-9999");
  MissingCodes none;
  take_missing_codes(table, none);
  CHECK(none.note().empty());
}
