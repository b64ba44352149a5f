// SPDX-License-Identifier: MIT
#include "silvafit/stand/unread_columns.hpp"

#include <catch2/catch.hpp>

using namespace silvafit;
using namespace silvafit::stand;

TEST_CASE("Columns with the name of one that is read and a number are named") {
  const auto unread = [](const std::vector<std::string>& header,
                         const std::vector<ColumnMapping>& mapped = {}) {
    return describe_unread_columns(header, mapped, "trees.csv");
  };
  CHECK(
      unread({"plot", "dbh", "dbh2", "h", "DBH 2022 (cm)", "H_1"}) ==
      "dbh is read from dbh, not from dbh2, DBH 2022 (cm); if that is another visit, read it with "
      "`columns=dbh=`DBH 2022 (cm)``; if it is another stem of the tree, "
      "`columns=dbh=sqrt((dbh)^2 + (dbh2)^2)` has the basal area of both, with 0 for trees that "
      "have none; h is read from h, not "
      "from H_1; if that is another visit, read it with `columns=h=H_1`");
  // Circumferences.
  CHECK_THAT(unread({"plot", "CAP", "CAP2"}),
             Catch::Matchers::Contains("dbh is read from CAP, not from CAP2") &&
                 Catch::Matchers::Contains("`columns=dbh=sqrt((CAP/pi)^2 + (CAP2/pi)^2)`"));
  // Names of heights of measurement, and columns that the user reads.
  CHECK(unread({"plot", "DBH130", "h"}).empty());
  CHECK(unread({"dbh", "dbh2", "h"}, {{.name = "d2", .source = "dbh2"}}).empty());
  CHECK(unread({"dbh", "dbh2"}, {{.name = "dbh", .source = "(dbh + dbh2)/2"}}).empty());
  CHECK(unread({"plot", "plot2", "tree", "year2"}).empty());
}

TEST_CASE("Crown radii between the four directions are named") {
  const std::vector<std::string> header{
      "cr_n_m", "cr_ne_m", "cr_e_m", "cr_se_m", "cr_s_m", "cr_sw_m", "cr_w_m", "cr_nw_m"};
  CHECK(describe_unread_columns(header, {}, "trees.csv") ==
        "crowns have the radii to the north, east, south and west; cr_ne_m, cr_se_m, cr_sw_m, "
        "cr_nw_m are not read");
  CHECK(describe_unread_columns({"cr_n", "cr_e", "cr_s", "cr_w", "crown"}, {}, "").empty());
}

TEST_CASE("Words of dead and cut trees are counted in columns that are no status") {
  data::TextColumn species;
  for (const char* const label : {"Fichte", "snag", "D", "Douglasie", "stump", "snag", "tot"}) {
    species.append(label);
  }
  species.append_missing();
  StatusWords words("species");
  words.add(species);
  words.add(species);
  CHECK(words.note() ==
        "8 rows have a word of dead or cut trees in column species (snag) and count as living; to "
        "read it as their status, use `columns=status=species`");
  StatusWords none("remark");
  none.add("healthy");
  none.add("d");
  CHECK(none.note().empty());
}
