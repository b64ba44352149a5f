// SPDX-License-Identifier: MIT
#include "silvafit/base/words.hpp"

#include <catch2/catch.hpp>

using namespace silvafit;

TEST_CASE("words are compared without regard to capitals") {
  CHECK(in_lower_case("DBH_cm Ä") == "dbh_cm Ä");
  CHECK(are_equal_words("StatusCD", "STATUSCD"));
  CHECK_FALSE(are_equal_words("status", "statuscd"));
}

TEST_CASE("a list has whole words only") {
  CHECK(has_word("dbh height cw", "dbh"));
  CHECK(has_word("dbh height cw", "height"));
  CHECK(has_word("dbh height cw", "cw"));
  CHECK_FALSE(has_word("dbh height cw", "heigh"));
  CHECK_FALSE(has_word("dbh height cw", "eight"));
  CHECK_FALSE(has_word("dbh height cw", "dbh height"));
  CHECK_FALSE(has_word("dbh height cw", ""));
  CHECK_FALSE(has_word("", "dbh"));
  CHECK_FALSE(has_word("", ""));
}
