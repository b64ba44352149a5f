// SPDX-License-Identifier: MIT
// Names of sources, without GDAL.
#include "silvafit/source/open_table.hpp"

#include <catch2/catch.hpp>

#include "silvafit/base/error.hpp"
#include "silvafit/source/write_layers.hpp"

namespace silvafit::source {
namespace {

TEST_CASE("sources are recognized by their endings, in upper or lower case") {
  for (const char* const name :
       {"a.xlsx", "b.GPKG", "dir.csv/c.shp", "d.sqlite", "e.Ods", "PG:dbname=forest"}) {
    CHECK(is_layered(name));
  }
  for (const char* const name : {"a.csv", "b.txt", "gpkg", "a.xlsx.csv", "/dev/stdin", ""}) {
    CHECK_FALSE(is_layered(name));
  }
}

TEST_CASE("a CSV file is opened as it is, and has no layers") {
  const OpenedTable opened = open_table("trees.csv", {});
  CHECK(data::file_of(opened.table) == "trees.csv");
  CHECK_FALSE(opened.coordinates);
  CHECK_THROWS_AS(open_table("trees.csv", {.layer = "trees"}), UsageError);
  CHECK_THROWS_AS(open_table("trees.csv", {.sql = "select 1"}), UsageError);
}

TEST_CASE("names of networks and archives are distinguished from files and databases") {
  CHECK(is_network_name("/vsicurl/https://example.org/a.gpkg"));
  CHECK(is_network_name("/vsizip/a.zip/a.shp"));
  CHECK(is_network_name("https://example.org/a.gpkg"));
  CHECK_FALSE(is_network_name("PG:postgresql://host/forest"));
  CHECK_FALSE(is_network_name("vsi/a.gpkg"));
}

TEST_CASE("messages do not contain passwords") {
  CHECK(shown_name("PG:dbname=forest password=secret host=here") ==
        "PG:dbname=forest password=... host=here");
  CHECK(shown_name("PG:dbname=forest PASSWORD='my secret'") == "PG:dbname=forest PASSWORD=...");
  CHECK(shown_name("PG:password=secret") == "PG:password=...");
  CHECK(shown_name("PG:postgresql://me:secret@host/forest") ==
        "PG:postgresql://me:...@host/forest");
  CHECK(shown_name("PG:postgresql://me@host:5432/forest") == "PG:postgresql://me@host:5432/forest");
  CHECK(shown_name("password=1.gpkg") == "password=1.gpkg");
}

TEST_CASE("files are written as layers or sheets by their ending") {
  CHECK(is_written_as_layers("a.gpkg"));
  CHECK(is_written_as_layers("a.XLSX"));
  CHECK_FALSE(is_written_as_layers("a.csv"));
  CHECK_FALSE(is_written_as_layers(""));
  CHECK(has_geometries("a.fgb"));
  CHECK_FALSE(has_geometries("a.ods"));
}

}  // namespace
}  // namespace silvafit::source
