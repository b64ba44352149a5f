// SPDX-License-Identifier: MIT
#include "silvafit/base/near_names.hpp"

#include <catch2/catch.hpp>

using namespace silvafit;
using Names = std::vector<std::string>;

TEST_CASE("slips are letters to insert, delete, replace or swap") {
  CHECK(slips_between("dbh", "dbh") == 0);
  CHECK(slips_between("dhb", "dbh") == 1);   // swapped
  CHECK(slips_between("dbhh", "dbh") == 1);  // inserted
  CHECK(slips_between("db", "dbh") == 1);    // missing
  CHECK(slips_between("dbj", "dbh") == 1);   // replaced
  CHECK(slips_between("kitten", "sitting") == 3);
}

TEST_CASE("a slip is one typing error, or another case or punctuation") {
  CHECK(is_slip_of("dhb", "dbh"));
  CHECK(is_slip_of("DBH", "dbh"));
  CHECK(is_slip_of("dbh_cm", "dbh.cm"));
  CHECK(is_slip_of("d.b.h.", "dbh"));
  CHECK_FALSE(is_slip_of("dbh", "dbh"));
  // Parameters of one letter stand beside columns of one letter.
  CHECK_FALSE(is_slip_of("c", "C"));
  CHECK_FALSE(is_slip_of("b1", "b2"));
}

TEST_CASE("an abbreviation has the letters of the longer name in their order, from the first on") {
  CHECK(is_abbreviation("ht", "height"));
  CHECK(is_abbreviation("diam", "Diameter_cm"));
  CHECK(is_abbreviation("dbh_cm", "dbh"));
  CHECK_FALSE(is_abbreviation("a", "age"));
  CHECK_FALSE(is_abbreviation("lrc", "height"));
  CHECK_FALSE(is_abbreviation("xmid", "plot"));
}

TEST_CASE("near names are those of the closest kind") {
  const Names columns{"plot", "dbh", "height", "age"};
  CHECK(names_near("dhb", columns) == Names{"dbh"});
  CHECK(names_near("ht", columns) == Names{"height"});
  CHECK(names_near("heihgtt", columns) == Names{"height"});
  CHECK(names_near("Asym", columns).empty());
  CHECK(names_near("k", columns).empty());
}

TEST_CASE("suggestions name the nearest of the names, or all") {
  CHECK(did_you_mean("levle", {"level", "interval"}) == "; did you mean level?");
  CHECK(did_you_mean("newton", {"level", "interval"}) == "; available: level, interval");
}
