// SPDX-License-Identifier: MIT
// Workbooks of openpyxl and LibreOffice; tests/data/workbooks/make.py has what they contain.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "reference.hpp"
#include "scratch_file.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/source/open_table.hpp"
#include "silvafit/source/write_layers.hpp"
#include "workbook/excel_formats.hpp"
#include "workbook/sheet_text.hpp"
#include "workbook/write_workbook.hpp"

namespace silvafit::source {
namespace {

std::string book(const std::string& name) {
  return test::source_file("tests/data/workbooks/" + name).string();
}

std::vector<std::string> texts_of(const data::Table& table, const std::string& column) {
  std::vector<std::string> texts;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const data::TextColumn& own = table.text(column);
    texts.emplace_back(own.is_missing(row) ? "(missing)" : own[row]);
  }
  return texts;
}

using Texts = std::vector<std::string>;

bool has_note(const OpenedTable& opened, const std::string& words) {
  return std::ranges::any_of(opened.notes, [&words](const std::string& note) {
    return note.find(words) != std::string::npos;
  });
}

TEST_CASE("cells of each kind, as LibreOffice saves them in both formats") {
  for (const char* const name : {"computed.xlsx", "computed.ods"}) {
    CAPTURE(name);
    const OpenedTable opened = open_table(book(name), {});
    CHECK(data::file_of(opened.table) == book(name) + " (sheet Trees)");
    const data::Table table = data::read_csv_table(opened.table);
    REQUIRE(table.rows() == 3);
    CHECK(table.line(0) == 4);
    CHECK(texts_of(table, "plot") == Texts{"A", "(missing)", "07"});
    // 0.1 + 0.2 is shown as 0.3.
    CHECK(table.numbers("dbh")[0] == 0.3);
    CHECK(table.numbers("twice")[1] == 66.0);
    CHECK(texts_of(table, "day") == Texts{"2024-02-29", "2024-02-28", "2024-02-27"});
    CHECK(texts_of(table, "moment") ==
          Texts{"1999-12-31T23:59:58", "1999-12-31T23:59:59", "1999-12-31T23:59:58"});
    CHECK(texts_of(table, "clock") == Texts{"07:05:00", "07:06:00", "07:07:00"});
    CHECK(table.numbers("share")[1] == 0.25);
    CHECK(table.numbers("alive")[0] == 1.0);
    CHECK(table.numbers("alive")[1] == 0.0);
    CHECK(table.numbers("comma")[2] == 12.5);
    CHECK(std::isnan(table.numbers("ratio")[0]));
    CHECK(table.numbers("ratio")[2] == 0.5);
    CHECK(std::isnan(table.numbers("gone")[0]));
    CHECK(texts_of(table, "text") == Texts{R"(said "so"; twice)", "two lines", "_x0041_ é 木"});
    CHECK(has_note(opened, "hidden sheets are not read: 'Codes' (2 rows, hidden)"));
    CHECK(has_note(opened, "in column H, 3 numbers are formatted as percentages (first: H4)"));
    CHECK(has_note(opened, "1 cell with an error is treated as missing (first: #DIV/0! in K4)"));
    CHECK(has_note(opened, "1 row is hidden (first: 5)"));
    CHECK(opened.notes.size() == 4);
    const data::Table codes =
        data::read_csv_table(open_table(book(name), {.layer = "Codes"}).table);
    CHECK(texts_of(codes, "species") == Texts{"fir"});
  }
}

TEST_CASE("numbers are those that spreadsheets show, however their files spell them") {
  SheetBudget budget = sheet_budget(0);
  SheetText sheet("a", budget);
  std::size_t column = 0;
  for (const char* const number :
       {"1.0", "0.30000000000000004", "1E3", "2.50", "100", "12345678901234567890", "-.5"}) {
    sheet.add(1, column++, number, CellKind::kNumber);
  }
  CHECK(sheet.text()->text == "1;0.3;1000;2.5;100;12345678901234567890;-.5\n");
}

TEST_CASE("formulas without values, as openpyxl writes them, are refused") {
  CHECK_THROWS_WITH(open_table(book("kinds.xlsx"), {}),
                    Catch::Contains("9 cells have formulas without a stored value (first: D4)"));
  CHECK_NOTHROW(open_table(book("kinds.xlsx"), {.layer = "Codes"}));
}

TEST_CASE("days since 1904, as openpyxl writes them") {
  const data::Table days = data::read_csv_table(open_table(book("days-1904.xlsx"), {}).table);
  CHECK(texts_of(days, "day") == Texts{"1904-01-02", "2024-02-29"});
}

TEST_CASE("a logical value among other numbers is no number") {
  SheetBudget budget = sheet_budget(0);
  SheetText sheet("a", budget);
  const auto add = [&sheet](std::size_t row, const char* dbh, CellKind kind, const char* alive) {
    sheet.add(row, 0, dbh, kind);
    sheet.add(row, 1, alive, CellKind::kLogical);
  };
  sheet.add(1, 0, "dbh", CellKind::kText);
  sheet.add(1, 1, "2019", CellKind::kNumber);
  add(2, "20.5", CellKind::kNumber, "1");
  add(3, "1", CellKind::kLogical, "0");
  add(4, "31", CellKind::kNumber, "1");
  CHECK(sheet.text()->text == "dbh;2019\n20.5;1\nTRUE;0\n31;1\n");
}

TEST_CASE("number formats of Excel") {
  // ECMA-376 part 1, 18.8.30: 61 is 1 March 1900, because 60 is a day that did not exist.
  CHECK(date_text(61, NumberFormat::kDate, false) == "1900-03-01");
  CHECK(date_text(1, NumberFormat::kDate, false) == "1900-01-01");
  CHECK(date_text(45351.5, NumberFormat::kDate, false) == "2024-02-29T12:00:00");
  CHECK(date_text(2958465, NumberFormat::kDate, false) == "9999-12-31");
  CHECK_FALSE(date_text(2958466, NumberFormat::kDate, false));
  CHECK_FALSE(date_text(-1, NumberFormat::kDate, false));
  CHECK(date_text(1.5, NumberFormat::kTime, false) == "36:00:00");
  for (const char* const code : {"General",
                                 "0.00E+00",
                                 "#,##0.00\\ \"m\"",
                                 "0.0_m",
                                 "[Red]0",
                                 "@",
                                 "Standard",
                                 "[$-407]0.0",
                                 "0.00*d",
                                 ""}) {
    CAPTURE(code);
    CHECK(format_of_code(code) == NumberFormat::kNumber);
  }
  for (const char* const code :
       {"dd/mm/yyyy", "[$-F800]dddd\\,\\ mmmm\\ dd", "mmm", "yyyy\\-mm\\-dd"}) {
    CAPTURE(code);
    CHECK(format_of_code(code) == NumberFormat::kDate);
  }
  for (const char* const code : {"h:mm AM/PM", "[h]:mm", "mm:ss.0", "[mm]"}) {
    CAPTURE(code);
    CHECK(format_of_code(code) == NumberFormat::kTime);
  }
  CHECK(format_of_code("0.0%") == NumberFormat::kPercentage);
}

data::Table mixed_table() {
  data::Table table;
  table.set("n", std::vector<double>{0.1, data::kMissing, -1e300});
  data::TextColumn texts;
  texts.append("=1+1");
  texts.append_missing();
  texts.append(" a  <b> & \"c\"\n_x000D_");
  table.set("t", std::move(texts));
  return table;
}

TEST_CASE("a written workbook is read again") {
  for (const std::string ending : {".xlsx", ".ods"}) {
    CAPTURE(ending);
    const std::vector<Layer> sheets{{.name = "first", .table = mixed_table()},
                                    {.name = "first", .table = mixed_table()}};
    const test::ScratchFile file("", ending);
    write_layers(file.path(), sheets, std::nullopt);
    const OpenedTable opened = open_table(file.path().string(), {.layer = "first_2"});
    const data::Table table = data::read_csv_table(opened.table);
    // A row of missing values is an empty one, as in other sheets.
    REQUIRE(table.rows() == 2);
    CHECK(table.line(1) == 4);
    CHECK(table.numbers("n")[0] == 0.1);
    CHECK(table.numbers("n")[1] == -1e300);
    CHECK(texts_of(table, "t") == Texts{"=1+1", "a  <b> & \"c\" _x000D_"});
    CHECK(workbook_of(sheets, file.path()) == read_file(file.path()));
  }
}

TEST_CASE("every changed byte of a workbook is refused or changes nothing") {
  for (const char* const name : {"computed.xlsx", "computed.ods"}) {
    const std::string whole = read_file(book(name));
    const auto text_of = [&](const std::string& bytes) {
      const test::ScratchFile file(bytes, std::string(name).substr(8));
      const OpenedTable opened = open_table(file.path().string(), {});
      return std::get<std::shared_ptr<const data::TableText>>(opened.table)->text;
    };
    const std::string expected = text_of(whole);
    std::size_t refused = 0;
    for (std::size_t at = 0; at < whole.size(); at += 7) {
      std::string changed = whole;
      changed[at] = static_cast<char>(changed[at] ^ 0x10);
      try {
        const std::string text = text_of(changed);
        CHECK(text == expected);
      } catch (const InputError&) {
        ++refused;
      }
    }
    // Without those in times, attributes and other parts of the archive that no reader uses.
    CHECK(refused > whole.size() / 7 * 2 / 3);
    for (std::size_t size = 0; size < whole.size(); size += 97) {
      CHECK_THROWS_AS(text_of(whole.substr(0, size)), InputError);
    }
  }
}

TEST_CASE("tables that are larger than a sheet are refused") {
  data::Table table;
  table.set("n", std::vector<double>(1048576, 1.0));
  CHECK_THROWS_AS(workbook_of({{.name = "n", .table = table}}, "a.xlsx"), UsageError);
  data::TextColumn texts;
  texts.append(std::string(32768, 'a'));
  data::Table long_text;
  long_text.set("t", std::move(texts));
  CHECK_THROWS_AS(workbook_of({{.name = "t", .table = long_text}}, "a.ods"), UsageError);
}

}  // namespace
}  // namespace silvafit::source
