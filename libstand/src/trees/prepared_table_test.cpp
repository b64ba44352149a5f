// SPDX-License-Identifier: MIT
#include "silvafit/stand/prepared_table.hpp"

#include <catch2/catch.hpp>
#include <memory>

#include "silvafit/base/error.hpp"
#include "silvafit/stand/described_columns.hpp"
#include "silvafit/stand/inventory.hpp"

using Catch::Matchers::Contains;
using namespace silvafit;
using namespace silvafit::stand;

namespace {

data::TableSource csv(std::string text) {
  return std::make_shared<const data::TableText>(
      data::TableText{.name = "trees.csv", .text = std::move(text), .separator = ','});
}

const char* const kWide =
    "plot,tree,genus,epithet,DBH_2019,DBH_2024,H_2024\n"
    "1,1,Abies,alba,20,22.5,18\n"
    "1,2,Fagus,sylvatica,30,,\n"
    "1,3,Abies,alba,,11,8\n";

std::vector<double> column(const data::TableSource& table, const char* name) {
  const data::Table read = data::read_csv_table(table);
  return {read.numbers(name).begin(), read.numbers(name).end()};
}

}  // namespace

TEST_CASE("columns of visits become a row for each time") {
  const PreparedTable prepared =
      prepared_table(csv(kWide), {.visits = parse_column_mappings("dbh=DBH_{year},h=H_{year}")});
  // Tree 2 was measured in 2019 only and tree 3 in 2024 only.
  CHECK(column(prepared.table, "tree") == std::vector<double>{1, 1, 2, 3});
  CHECK(column(prepared.table, "year") == std::vector<double>{2019, 2024, 2019, 2024});
  CHECK(column(prepared.table, "dbh") == std::vector<double>{20, 22.5, 30, 11});
  CHECK(data::read_csv_table(prepared.table).line(3) == 4);
  CHECK(prepared.note == "rows of 2 times are made of the columns of year: 2019, 2024");
  CHECK_THROWS_WITH(prepared_table(csv(kWide), {.visits = {{"dbh", "D_{year}"}}}),
                    Contains("no column fits the pattern D_{year}"));
  CHECK_THROWS_WITH(prepared_table(csv(kWide), {.visits = {{"dbh", "DBH_2019"}}}),
                    Contains("is not a pattern of columns such as DBH_{year}"));
}

TEST_CASE("the date of a visit makes no row of a tree that was not seen") {
  const char* const text =
      "tree,DBH_2019,DBH_2024,Date_2019,Date_2024\n1,20,21,2019-06-01,2024-06-02\n"
      "2,,11,2019-06-01,2024-06-02\n";
  const auto trees = [&](const char* visits) {
    return column(prepared_table(csv(text), {.visits = parse_column_mappings(visits)}).table,
                  "tree");
  };
  CHECK(trees("dbh=DBH_{year},date=Date_{year}") == std::vector<double>{1, 1, 2});
  CHECK(trees("dbh=DBH_{year},seen=Date_{year}") == std::vector<double>{1, 1, 2});
  CHECK_THAT(prepared_table(csv(text), {.visits = parse_column_mappings("dbh=DBH_{year}")}).note,
             Contains("`visits=dbh=DBH_{year},date=Date_{year}`"));
}

TEST_CASE("columns with the times of visits that are not read are named") {
  const auto visits = parse_column_mappings("dbh=DBH_{year}");
  CHECK_THAT(prepared_table(csv(kWide), {.visits = visits}).note,
             Contains("the columns H_{year}") && Contains("`visits=dbh=DBH_{year},h=H_{year}`"));
  const char* const text = "tree,DBH_2019,DBH_2024,Zustand_2019,Zustand_2024\n1,20,21,lebend,tot\n";
  InventoryOptions options{.visits = visits};
  CHECK_THAT(prepared_table(csv(text), options).note, Contains("Zustand_{year}"));
  options.keeps_measurements = true;
  CHECK_THROWS_WITH(prepared_table(csv(text), options),
                    Contains("`visits=dbh=DBH_{year},status=Zustand_{year}`"));
}

TEST_CASE("the unit of visits is that of their columns") {
  const char* const text = "tree,D_2019 (mm),D_2024 (mm)\n1,205,221\n";
  InventoryOptions options{.trust_units = true};
  options.visits = {{"dbh", "D_{year} (mm)"}};
  options.keeps_measurements = true;
  const Inventory inventory = read_inventory(csv(text), options).inventory;
  CHECK(inventory.dbh_cm == std::vector<double>{20.5, 22.1});
  CHECK(inventory.time[1] == "2024");
}

TEST_CASE("a code of missing values fulfils no condition, in any unit") {
  // -999 mm is a code and not -99.9 cm; -5 mm is a wrong number, which other checks name.
  const PreparedTable prepared =
      prepared_table(csv("tree,BHD [mm]\n1,205\n2,-999\n3,-5\n"), {.where = "dbh < 21"});
  CHECK(column(prepared.table, "tree") == std::vector<double>{1, 3});
}

TEST_CASE("a condition reads columns of the file and ours") {
  const auto trees_where = [](const char* where) {
    const InventoryOptions rows{.columns = parse_column_mappings("dbh=DBH_2019"), .where = where};
    return column(prepared_table(csv(kWide), rows).table, "tree");
  };
  CHECK(trees_where("genus == \"Abies\"") == std::vector<double>{1, 3});
  CHECK(trees_where("dbh >= 20") == std::vector<double>{1, 2});
  // The dbh of tree 3 is missing, which is neither above nor below.
  CHECK(trees_where("dbh < 25") == std::vector<double>{1});
  CHECK(trees_where("plot == \"1\" && H_2024 < 10") == std::vector<double>{3});
  CHECK_THROWS_WITH(trees_where("dbh > 99"), Contains("trees.csv: no row satisfies"));
  CHECK_THROWS_WITH(trees_where("DBH > 9"), Contains("unknown column 'DBH'"));
}

TEST_CASE("codes for missing values do not satisfy a condition") {
  const char* const text = "tree,BHD\n1,-999\n2,0\n3,15\n";
  const PreparedTable prepared = prepared_table(csv(text), {.where = "dbh < 20"});
  CHECK(column(prepared.table, "tree") == std::vector<double>{3});
  CHECK(prepared.note ==
        "1 of 3 rows are used, by the condition dbh < 20; 2 rows have no value of a column of the "
        "condition and are not used");
}

TEST_CASE("an inventory has species of joined texts and the first dbh that is present") {
  InventoryOptions options{.trust_units = true};
  options.columns =
      parse_column_mappings("species=genus + \" \" + epithet,dbh=first(DBH_2024, DBH_2019)");
  options.where = "species != \"Fagus sylvatica\" || dbh == 30";
  const CheckedInventory checked = read_inventory(csv(kWide), options);
  CHECK(checked.inventory.dbh_cm == std::vector<double>{22.5, 30, 11});
  CHECK(checked.inventory.species[1] == "Fagus sylvatica");
  CHECK(checked.inventory.lines == std::vector<std::uint32_t>{2, 3, 4});
  options.columns = parse_column_mappings("dbh=first(`D (mm)`, `D (cm)`)");
  CHECK_THROWS_WITH(read_inventory(csv("tree,D (mm),D (cm)\n1,205,\n"), options),
                    Contains("have several units"));
}

TEST_CASE("names of public tables, and measures that are converted") {
  const auto source_of = [](std::vector<std::string> header, const std::string& name) {
    const auto found = usual_columns(
        header, [&](const std::string& known) { return known == name; }, "trees.csv");
    return found.empty() ? std::string() : found.front().source;
  };
  CHECK(source_of({"TH", "DBH"}, "h") == "TH");
  CHECK(source_of({"tree_ht"}, "h") == "tree_ht");
  CHECK(source_of({"gx", "gy"}, "x") == "gx");
  CHECK(source_of({"Xfield", "Yfield"}, "y") == "Yfield");
  CHECK(source_of({"utm.east", "utm.north"}, "x") == "utm.east");
  CHECK(source_of({"hbase_m"}, "hcb") == "hbase_m");
  CHECK(source_of({"rn_m", "re_m", "rs_m", "rw_m"}, "cr_s") == "rs_m");
  CHECK(source_of({"tag"}, "tree") == "tag");
  CHECK(source_of({"treeID", "tag"}, "tree") == "treeID");
  CHECK(source_of({"subplot_id"}, "plot") == "subplot_id");
  // 31.4 cm around are 10 cm across; a width is two radii.
  CHECK(source_of({"CBH"}, "dbh") == "CBH/pi");
  CHECK(source_of({"girth (mm)"}, "dbh") == "`girth (mm)`/10/pi");
  CHECK(source_of({"crown_radius_m"}, "cw") == "crown_radius_m*2");
  CHECK(source_of({"DBH", "CBH"}, "dbh") == "DBH");
  CHECK(describe_usual_columns({{"dbh", "CBH/pi"}}) ==
        "dbh is read from column CBH/pi (a circumference)");
}

TEST_CASE("a table is described column by column") {
  const TableDescription described = describe_columns(csv("Plot_ID,BHD [mm],DBH.2013,note\n"
                                                          "1,205,19,old\n"
                                                          "1,-999,20,\n"
                                                          "2,-5,21,new\n"),
                                                      {});
  REQUIRE(described.columns.size() == 4);
  CHECK(described.rows == 3);
  const DescribedColumn& dbh = described.columns[1];
  CHECK(dbh.read_as == "dbh");
  CHECK(dbh.source == "`BHD [mm]`/10");
  CHECK(dbh.unit == "cm");
  CHECK(dbh.lowest == -0.5);
  CHECK(dbh.highest == 20.5);
  CHECK(dbh.missing == 1);
  CHECK(dbh.impossible == 1);
  CHECK(described.columns[0].read_as == "plot");
  CHECK(described.columns[2].read_as.empty());
  CHECK(described.columns[3].examples == std::vector<std::string>{"old", "new"});
  for (const LackingCommand& one : described.commands) {
    if (one.command == "stand") CHECK(one.lacks.empty());
    if (one.command == "indices") CHECK(one.lacks == std::vector<std::string>{"x", "y"});
  }
  // A column without a value is as good as none.
  const TableDescription empty = describe_columns(csv("tree,dbh,x,y\n1,20,,\n2,21,,\n"), {});
  for (const LackingCommand& one : empty.commands) {
    if (one.command == "indices") CHECK(one.lacks == std::vector<std::string>{"x", "y"});
  }
}

TEST_CASE("an error of a missing column names those that may be meant") {
  CHECK(likely_columns("dbh", {"plot", "DBH.2018", "DBH.2013", "x"}) ==
        std::vector<std::string>{"DBH.2018", "DBH.2013"});
  CHECK_THROWS_WITH(read_inventory(csv("plot,tree,DBH.2018\n1,1,20\n"), {}),
                    Contains("no column dbh (diameter at breast height in cm) was found; it may be "
                             "DBH.2018; name it with `columns=dbh=DBH.2018`"));
}
