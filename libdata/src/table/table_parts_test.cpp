// SPDX-License-Identifier: MIT
#include "silvafit/data/table_parts.hpp"

#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/ordered_rows.hpp"

namespace silvafit::data {
namespace {

class CsvFile {
 public:
  explicit CsvFile(const std::string& text) : path_(folder_.path() / "trees.csv") {
    std::ofstream(path_, std::ios::binary) << text;
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  TemporaryFolder folder_{"silvafit-parts-"};
  std::filesystem::path path_;
};

struct Row {
  std::size_t line = 0;
  std::vector<std::string> fields{};
  bool operator==(const Row&) const = default;
};

std::vector<Row> rows_of(CsvReader& reader) {
  std::vector<Row> rows;
  std::vector<std::string_view> fields;
  while (reader.next(fields)) {
    rows.push_back({reader.line(), std::vector<std::string>(fields.begin(), fields.end())});
  }
  return rows;
}

std::vector<std::vector<Row>> parts_of(const std::filesystem::path& path,
                                       const TablePartsOptions& options) {
  std::vector<std::vector<Row>> parts;
  TableParts file(path, options);
  while (const auto part = file.next()) {
    CsvReader reader{TableSource(part)};
    parts.push_back(rows_of(reader));
  }
  return parts;
}

TEST_CASE("parts have the records of the file, with their lines") {
  const CsvFile file(
      "A title\n\nplot,note\n1,\"a, "
      "\"\"b\"\"\"\n\n1,\"two\nlines\"\n2,'=x\n2,\"\"\n\"#3\",\n\"\",\"\"\n");
  CsvReader whole(file.path());
  const std::vector<Row> rows = rows_of(whole);
  REQUIRE(rows.size() == 6);
  CHECK(rows[1].line == 6);
  CHECK(rows[2].fields[1] == "=x");
  std::vector<Row> joined;
  for (const auto& part : parts_of(file.path(), {.rows = 2})) {
    CHECK(part.size() == 2);
    joined.insert(joined.end(), part.begin(), part.end());
  }
  CHECK(joined == rows);
}

TEST_CASE("groups are whole, and sorted by their first rows if they are not contiguous") {
  const CsvFile file("plot,tree\nb,1\nb,2\na,3\nc,4\na,5\n");
  TableParts parts(file.path(), {.group = {0}, .rows = 1});
  CHECK(parts.is_sorted());
  CHECK(parts.rows() == 5);
  const auto all = parts_of(file.path(), {.group = {0}, .rows = 1});
  REQUIRE(all.size() == 3);
  CHECK(all[0] == std::vector<Row>{{2, {"b", "1"}}, {3, {"b", "2"}}});
  CHECK(all[1] == std::vector<Row>{{4, {"a", "3"}}, {6, {"a", "5"}}});
  CHECK(all[2] == std::vector<Row>{{5, {"c", "4"}}});
  const CsvFile contiguous("plot,tree\nb,1\nb,2\na,3\n");
  CHECK_FALSE(TableParts(contiguous.path(), {.group = {0}}).is_sorted());
}

TEST_CASE("groups of several columns are those of equal values in all of them") {
  // 1-11 and 11-1 are two groups.
  const CsvFile file("stand,plot,tree\n1,11,a\n11,1,b\n1,11,c\n");
  const auto all = parts_of(file.path(), {.group = {0, 1}, .rows = 1});
  REQUIRE(all.size() == 2);
  CHECK(all[0] == std::vector<Row>{{2, {"1", "11", "a"}}, {4, {"1", "11", "c"}}});
  CHECK(all[1] == std::vector<Row>{{3, {"11", "1", "b"}}});
}

TEST_CASE(
    "rows that must not be sorted are in the order of the file, and their groups are refused "
    "if they come again after their part") {
  const CsvFile file("stand,plot\nN,1\nN,2\nN,1\nS,1\n");
  const TablePartsOptions options{
      .group = {0, 1}, .rows = 1, .refuse_group = [](std::size_t line, const std::string& label) {
        throw InputError(label, {.line = line});
      }};
  const auto check = [](TableParts parts, std::size_t before) {
    CHECK_FALSE(parts.is_sorted());
    for (std::size_t i = 0; i < before; ++i) CHECK(parts.next());
    try {
      parts.next();
      FAIL("the group was not refused");
    } catch (const InputError& error) {
      CHECK(error.message() == "N-1");
      CHECK(error.place().line == 4);
    }
  };
  check(TableParts(file.path(), options), 2);
  // A reader is read once, as a pipe is.
  check(TableParts(CsvReader(file.path()), options), 2);
  // Within a part the order is that of the file.
  TablePartsOptions large = options;
  large.rows = 3;
  TableParts parts(CsvReader(file.path()), large);
  CHECK(parts.next()->lines == std::vector<std::size_t>{2, 3, 4});
  CHECK(parts.next()->lines == std::vector<std::size_t>{5});
  CHECK(parts.next() == nullptr);
}

TEST_CASE("a column is text or numbers in each part as in the whole file") {
  const CsvFile file("id,h,code,none\n07,-,1,\n8,2.5,n/a,\nx,3,-,\n");
  const Table whole = read_csv_table(file.path());
  TableParts parts(file.path(), {.rows = 1});
  std::size_t row = 0;
  while (const auto part = parts.next()) {
    const Table table = read_csv_table(TableSource(part));
    for (const std::string& name : whole.names()) {
      INFO(name);
      REQUIRE(table.is_numeric(name) == whole.is_numeric(name));
      CHECK(std::string(table.labels(name)[0]) == std::string(whole.labels(name)[row]));
    }
    CHECK(table.line(0) == whole.line(row));
    ++row;
  }
  CHECK(row == 3);
}

TEST_CASE("decimal commas, and values filled down over parts and groups") {
  const CsvFile file("plot;dbh\nb;10,5\n;11,5\na;12,5\nb;13,5\n");
  const auto parts = parts_of(file.path(), {.group = {0}, .fill_down = {0}, .rows = 1});
  REQUIRE(parts.size() == 2);
  CHECK(parts[0] == std::vector<Row>{{2, {"b", "10,5"}}, {3, {"b", "11,5"}}, {5, {"b", "13,5"}}});
  TableParts tables(file.path(), {.rows = 100});
  const Table table = read_csv_table(TableSource(tables.next()));
  CHECK(table.numbers("dbh")[1] == 11.5);
}

TEST_CASE("a file without rows has one part, and a pipe has none") {
  const CsvFile file("plot,tree\n");
  CHECK(parts_of(file.path(), {}) == std::vector<std::vector<Row>>{{}});
  CHECK_THROWS_AS(TableParts("/dev/null", {}), InputError);
}

TEST_CASE("rows are written in the order of their lines") {
  std::ostringstream sorted;
  OrderedRows rows(sorted, true);
  rows.add(0, "header\n");
  rows.add(9, "c\n");
  rows.add(2, "a\n");
  rows.add(9, "d\n");
  rows.finish();
  CHECK(sorted.str() == "header\na\nc\nd\n");
  std::ostringstream unsorted;
  OrderedRows as_they_come(unsorted, false);
  as_they_come.add(9, "c\n");
  as_they_come.add(2, "a\n");
  as_they_come.finish();
  CHECK(unsorted.str() == "c\na\n");
}

}  // namespace
}  // namespace silvafit::data
