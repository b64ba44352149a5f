// SPDX-License-Identifier: MIT
#include "silvafit/data/csv.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "reference.hpp"
#include "scratch_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"

using namespace silvafit::data;
using Catch::Matchers::Contains;
using silvafit::InputError;
using silvafit::test::ScratchFile;

namespace {

using Records = std::vector<std::vector<std::string>>;

Records read_records(const std::filesystem::path& path) {
  CsvReader reader(path);
  Records records{reader.header()};
  std::vector<std::string_view> fields;
  while (reader.next(fields)) records.emplace_back(fields.begin(), fields.end());
  return records;
}

Records read_text(const std::string& bytes) { return read_records(ScratchFile(bytes).path()); }

std::string error_of(const std::string& bytes) {
  const ScratchFile file(bytes);
  try {
    read_records(file.path());
  } catch (const InputError& error) {
    CHECK(error.place().file == file.path().string());
    return silvafit::describe({.line = error.place().line}, error.message());
  }
  return "no error";
}

}  // namespace

TEST_CASE("a CSV file by Python's csv module reads as it was written") {
  const Records expected{{"id", "note, with comma", "say \"what\""},
                         {"07", "two\nlines", "a \"quoted\" word"},
                         {"8", "carriage\rreturn", "\"\""},
                         {"9", "", "杉木,\r\n\"火力楠\""},
                         {"\"10\"", " blanks ", "plain"}};
  CHECK(read_records(silvafit::test::source_file("tests/data/python_csv.csv")) == expected);
}

TEST_CASE("any line end, a byte order mark, blank lines and a last line without end are read") {
  const Records expected{{"a", "b"}, {"1", "x"}, {"2", "y"}};
  CHECK(read_text("a,b\n1,x\n2,y\n") == expected);
  CHECK(read_text("a,b\r\n1,x\r\n2,y") == expected);
  CHECK(read_text("a,b\r1,x\r2,y\r") == expected);
  CHECK(read_text("\xEF\xBB\xBF\n a ,\tb\n\n1,x\n  \n2,y\n\n") == expected);
  CHECK(read_text("a,b\n1,\"x\"\n\"2\",y") == expected);
}

TEST_CASE("a quote inside a plain field is a character like any other") {
  CHECK(read_text("a,b\n5\",6 \"x\"\n") == Records{{"a", "b"}, {"5\"", "6 \"x\""}});
}

TEST_CASE("the reader has the line on which a record begins") {
  const ScratchFile file("a,b\n\n1,\"x\r\ny\"\r\n2,z\n");
  CsvReader reader(file.path());
  std::vector<std::string_view> fields;
  REQUIRE(reader.next(fields));
  CHECK(reader.line() == 3);
  REQUIRE(reader.next(fields));
  CHECK(reader.line() == 5);
  CHECK_FALSE(reader.next(fields));
  CHECK_FALSE(reader.next(fields));
}

TEST_CASE("records and fields longer than a block are whole") {
  const std::string longest(700'001, 'q');
  std::string text = "a,b,c\n";
  Records expected{{"a", "b", "c"}};
  for (int i = 0; i < 20; ++i) {
    const std::string number = std::to_string(i);
    text.append(number).append(",\"").append(longest);
    text.append("\"\"\",").append(longest).append("\r\n");
    expected.push_back({number, longest + "\"", longest});
  }
  CHECK(read_text(text) == expected);
}

TEST_CASE("invalid CSV is refused with its line") {
  CHECK_THAT(error_of(""), Contains("the file is empty"));
  CHECK_THAT(error_of("\n\n"), Contains("the file is empty"));
  CHECK(error_of("a,b,a\n") == "line 1: columns 1 and 3 have the same name 'a'");
  CHECK(error_of("a,b\n1,2\n1,2,3\n") == "line 3: fields found: 3, columns in the header: 2");
  CHECK(error_of("a,b\n1\n") == "line 2: fields found: 1, columns in the header: 2");
  CHECK(error_of("a,b\n1,2\n3,\"x\ny\n") ==
        "line 3: the quoted field that starts here has no closing quote");
  CHECK_THAT(error_of("a,b\n\"x\ny\"z,2\n"), Contains("line 3: text follows a closing quote"));
  CHECK_THAT(error_of("a,b\n1,2\n\"\n\",\xE9t\xE9\n"), Contains("line 4: byte 0xE9 is not UTF-8"));
  CHECK_THAT(error_of("\xFF\xFE\x61"), Contains("UTF-16"));
}

TEST_CASE("semicolons and tabs imply decimal commas, and text keeps its spelling") {
  using Rows = std::vector<std::vector<std::string>>;
  CHECK(read_text("plot;dbh;note\r\n07;12,5;a, b\r\n08;-,5;\"x;y\"\r\n") ==
        Rows{{"plot", "dbh", "note"}, {"07", "12,5", "a, b"}, {"08", "-,5", "x;y"}});
  CHECK(read_text("\n\"Plot; old\";\"BHD\"\n1;1,5E-05\n") ==
        Rows{{"Plot; old", "BHD"}, {"1", "1,5E-05"}});
  // With a comma in the header, commas are the separators, unless others make more fields.
  CHECK(read_text("a;b,c\n1;2,5\n") == Rows{{"a;b", "c"}, {"1;2", "5"}});
  CHECK(read_text("plot;tree;dbh, cm;h, m\n1;7;12,1;11,1\n") ==
        Rows{{"plot", "tree", "dbh, cm", "h, m"}, {"1", "7", "12,1", "11,1"}});
  CHECK(read_text("a;b;c,d,e\n1;2;3,4,5\n") == Rows{{"a;b;c", "d", "e"}, {"1;2;3", "4", "5"}});
  CHECK_THAT(error_of("plot;dbh\n1,2\n"), Contains("fields found: 1, columns in the header: 2"));

  const ScratchFile semicolons("a;b\n1;2\n");
  const ScratchFile tabs("a\tb\n1\t2\n");
  const ScratchFile commas("a,b\n1,2\n");
  double value = 0.0;
  for (const ScratchFile* file : {&semicolons, &tabs}) {
    const CsvReader reader(file->path());
    CHECK(reader.has_decimal_commas());
    CHECK((reader.parse_number("12,5", value) && value == 12.5));
    CHECK((reader.parse_number(" -,5 ", value) && value == -0.5));
    CHECK((reader.parse_number("1,5E-05", value) && value == 1.5e-5));
    CHECK((reader.parse_number("12.5", value) && value == 12.5));
    // No numbers of such files: thousands, lists.
    CHECK_FALSE(reader.parse_number("1.234,5", value));
    CHECK_FALSE(reader.parse_number("1,2,3", value));
    CHECK_FALSE(reader.parse_number("a,5", value));
  }
  CHECK_FALSE(CsvReader(commas.path()).parse_number("12,5", value));
}

TEST_CASE("a table of a file with decimal commas has numbers, and unchanged labels") {
  const ScratchFile file(
      "plot;dbh;note;mixed\n1,2;12,5;\"3,1\";1,5\n1.2;13;NA;x\n\"1,2\";;4,0;2,5\n");
  const Table table = read_csv_table(file.path(), {.text_columns = {"plot"}});
  CHECK(table.text("plot").levels() == std::vector<std::string>{"1,2", "1.2"});
  REQUIRE(table.is_numeric("dbh"));
  CHECK(table.numbers("dbh")[0] == 12.5);
  REQUIRE(table.is_numeric("note"));
  CHECK(table.numbers("note")[0] == 3.1);
  CHECK(table.text("mixed").levels() == std::vector<std::string>{"1,5", "x", "2,5"});
}

TEST_CASE("points of thousands are asked about where no other column shows the decimal mark") {
  const auto error_in = [](const std::string& text) {
    const ScratchFile file(text);
    try {
      read_csv_table(file.path());
    } catch (const InputError& error) {
      return silvafit::describe({.line = error.place().line}, error.message());
    }
    return std::string();
  };
  CHECK_THAT(error_in("plot;mm\n1;987\n1;1.020\n"),
             Contains("line 3: '1.020' can be 1020 or a number with three decimals, because the "
                      "column has '987' on line 2"));
  // Numbers of other forms, and long ones without a mark, show that points are decimal ones.
  for (const char* text : {"plot;mm\n1;987\n1;1.02\n",
                           "plot;mm\n1;1987\n1;1.020\n",
                           "plot;mm\n1;1.987\n1;1.020\n",
                           "plot;mm\n1;0\n1;1.020\n",
                           "plot;mm\n1;0.987\n1;12\n",
                           "plot,mm\n1,987\n1,1.020\n"}) {
    CHECK(error_in(text).empty());
  }
}

TEST_CASE("a line may name the separator, and messages name other formats") {
  using Rows = std::vector<std::vector<std::string>>;
  for (const char* line : {"sep=;\r\n", "\xEF\xBB\xBFSEP=;\n", "\"sep=;\"\r"}) {
    CHECK(read_text(std::string(line) + "a;b, c\n1;2,5\n") == Rows{{"a", "b, c"}, {"1", "2,5"}});
  }
  CHECK(read_text("sep=,\na,b\n1,2\n") == Rows{{"a", "b"}, {"1", "2"}});
  CHECK(error_of("sep=;\na;b\n1\n") == "line 3: fields found: 1, columns in the header: 2");
  CHECK(read_text("sep=1,b\n1,2\n") == Rows{{"sep=1", "b"}, {"1", "2"}});
  CHECK_THAT(error_of("\x1F\x8B\x08 rest"), Contains("gunzip"));
  CHECK_THAT(error_of("PK\x03\x04 rest"), Contains("workbook"));
  CHECK_THAT(error_of("plot|dbh|h\n1|20|18\n"), Contains("separated by '|'"));
  CHECK_THAT(error_of("plot  dbh h\n1 20  18\n"), Contains("separated by blanks"));
  CHECK(read_text("height of trees\n20\n") == Rows{{"height of trees"}, {"20"}});
  CHECK_THAT(error_of(std::string("p\0l\0o\0t\0", 8)), Contains("UTF-16"));
  CHECK_THAT(error_of(std::string("plot,h\n1,1\0.5\n", 14)), Contains("line 2: a zero byte"));
}

TEST_CASE("values below no name are named, but not the row names of R") {
  const auto layout_of = [](const std::string& text) {
    const ScratchFile file(text);
    CsvReader reader(file.path());
    std::vector<std::string_view> fields;
    while (reader.next(fields)) {
    }
    return describe_layout(reader.layout());
  };
  CHECK(layout_of("\"\",plot,h,\n1,A,12,\n2,A,14,\n").empty());
  CHECK(layout_of("plot,,h,\nA,,12,\nA,dead,14,1\n") ==
        "column 2 ('dead' in line 3), column 4 ('1' in line 3) have no name and are not read");
}

TEST_CASE("titles and comments above the header and units below it are ignored") {
  const Records expected{{"plot", "dbh", "h"}, {"1", "20", "18"}, {"2", "30", ""}};
  const std::string table = "plot,dbh,h\n1,20,18\n2,30,\n";
  for (const char* above : {"",
                            "Inventory 2019\n",
                            "Inventory 2019,,\n\n",
                            "# made by hand, twice, in haste\n# again\n",
                            "\"Forest: X, Y\",,\r\nDate:,2019-05-01,\r\n"}) {
    CHECK(read_text(above + table) == expected);
  }
  CHECK(read_text("Inventory\nBlack Forest\nplot;dbh;h\n1;20;18\n2;30;\n") == expected);
  CHECK(read_text("plot,dbh,h\n,(cm),[m]\n1,20,18\n2,30,\n") == expected);
  CHECK(read_text("plot,dbh,h\n1,20,18\n# windthrow\n,,\n2,30,,,\n") == expected);
  const ScratchFile file("Inventory\nplot,dbh,h\n-,cm,m\n1,20,18\n");
  const CsvReader reader(file.path());
  CHECK(reader.layout().header_line == 2);
  CHECK(reader.layout().units == std::vector<std::string>{"-", "cm", "m"});
  CHECK(describe_layout(reader.layout()) ==
        "the header is on line 2, below 1 title or comment; the row below the header has units");
}

TEST_CASE("a table that begins on the first line is read unchanged") {
  // Row names of R, a column without values, text below the header, units that are values.
  CHECK(read_text("\"\",dbh\n\"1\",20\n")[0] == std::vector<std::string>{"", "dbh"});
  CHECK(read_text("a,b\n1,m\n2,m\n").size() == 3);
  CHECK(read_text("a,b,c\nm,m,x\nf,m,y\n").size() == 3);
  CHECK(read_text("#plot,dbh\n1,20\n")[0][0] == "#plot");
  CHECK(read_text("name\nA\nB\n").size() == 3);
  CHECK(read_text("a,,\n1,,\n")[0].size() == 3);
  CHECK(read_text("\"Höhe\n[m]\",b\n1,2\n")[0][0] == "Höhe [m]");
}

TEST_CASE("codes are missing values in columns of numbers, and text in others") {
  const ScratchFile file("h,grade,all,d\n-,-,-,1\n18,A,-,NaN\nn/a,?,-,-9\n#N/A,B,-,3\n");
  MissingCodes codes;
  const Table table = read_csv_table(file.path(), {.missing = {"-9"}}, &codes);
  REQUIRE(table.is_numeric("h"));
  CHECK(table.numbers("h")[1] == 18.0);
  CHECK(std::isnan(table.numbers("h")[3]));
  CHECK(std::isnan(table.numbers("d")[2]));
  CHECK(table.text("grade").levels() == std::vector<std::string>{"-", "A", "?", "B"});
  CHECK(table.text("all")[0] == "-");
  CHECK(codes.text() == "h 3 (-, n/a, #N/A), d 1 (-9)");
}

TEST_CASE("empty fields get the value above on request") {
  const ScratchFile file("plot,dbh\nA,1\n,2\n ,3\nB,4\n,5\n");
  const Table table = read_csv_table(file.path(), {.fill_down = {0}});
  CHECK(table.text("plot")[2] == "A");
  CHECK(table.text("plot")[4] == "B");
}

TEST_CASE("the likely encoding of a file is named with the command that converts it") {
  // Chinese by GB18030, German by Latin-1, and UTF-16 with and without its mark.
  CHECK_THAT(error_of("a,\xD0\xD8\xBE\xB6\n1,2\n"), Contains("iconv -f GB18030 -t UTF-8 "));
  CHECK_THAT(error_of("a,H\xF6he\n1,2\n"), Contains("iconv -f CP1252 -t UTF-8 "));
  CHECK_THAT(error_of("a,Gr\xF6\xDF"
                      "e\n1,2\n"),
             Contains("iconv -f CP1252 -t UTF-8 "));
  CHECK_THAT(error_of("\xFF\xFE\x61"), Contains("iconv -f UTF-16 -t UTF-8 "));
  CHECK_THAT(error_of(std::string("p\0l\0", 4)), Contains("iconv -f UTF-16LE -t UTF-8 "));
}

TEST_CASE("overlong forms, surrogates and cut sequences are not UTF-8") {
  for (const char* bytes :
       {"\xC0\xAF", "\xE0\x80\x80", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xE6\x9D"}) {
    CHECK_THAT(error_of(std::string("a\n") + bytes + "\n"), Contains("not UTF-8"));
  }
  CHECK(error_of("a\n\xF0\x9F\x8C\xB2 \xE6\x9D\x89\n") == "no error");
}

TEST_CASE("a folder or a file that is not there is refused") {
  CHECK_THROWS_WITH(CsvReader(std::filesystem::temp_directory_path()), Contains("is a folder"));
  CHECK_THROWS_WITH(CsvReader("/no/such/file.csv"),
                    Contains("/no/such/file.csv: cannot be read: No such file"));
}

TEST_CASE("numbers are whole fields, blanks around them allowed") {
  double value = 0.0;
  const auto number = [&value](std::string_view field) {
    value = 0.0;
    return parse_number(field, value);
  };
  CHECK((number(" 12.5\t") && value == 12.5));
  CHECK((number("+3e2") && value == 300.0));
  CHECK((number("-.5") && value == -0.5));
  CHECK((number("1e999") && std::isinf(value)));
  CHECK((number("1e-999") && value == 0.0));
  CHECK((number("inf") && std::isinf(value)));
  for (const char* text : {"", " ", "12,5", "12 5", "12m", "+-3", "++3", "0x10", "NA", "."}) {
    CHECK_FALSE(number(text));
  }
}

TEST_CASE("a column is numeric if all its values are, and text keeps its spelling") {
  const ScratchFile file("n,late,text,empty,id\n1,07,x,,01\nNA,7.50,NA,NA,02\n -2.5e0 ,b,z,,03\n");
  const Table table = read_csv_table(file.path(), {.text_columns = {"id"}});
  REQUIRE(table.rows() == 3);
  CHECK(table.numbers("n")[2] == -2.5);
  CHECK(std::isnan(table.numbers("n")[1]));
  CHECK(table.text("late").levels() == std::vector<std::string>{"07", "7.50", "b"});
  CHECK(table.text("text").is_missing(1));
  CHECK(table.text("text")[2] == "z");
  CHECK(table.is_numeric("empty"));
  CHECK(table.text("id")[0] == "01");
  CHECK(table.line(2) == 4);
  CHECK(table.file() == file.path().string());
}

TEST_CASE("only the requested columns are kept, in the requested order") {
  const ScratchFile file("a,b,c\n1,2,3\n");
  CHECK(read_csv_table(file.path(), {.columns = {"c", "a"}}).names() ==
        std::vector<std::string>{"c", "a"});
  CHECK_THROWS_WITH(read_csv_table(file.path(), {.columns = {"d"}}),
                    Contains("unknown column 'd'; available: a, b, c"));
}

TEST_CASE("blanks around text are no part of it") {
  const ScratchFile file("a,b\n x y ,1\n\" z\",2\n\t,3\n");
  const Table table = read_csv_table(file.path());
  CHECK(table.text("a")[0] == "x y");
  CHECK(table.text("a")[1] == "z");
  CHECK(table.text("a").is_missing(2));
}

TEST_CASE("a table of random content survives writing and reading bit by bit") {
  silvafit::Random random(20);
  const std::vector<std::string> pieces{",", "\"", "\n", "\r", "\r\n", " ", "a", "杉", "NA", "7"};
  for (int round = 0; round < 40; ++round) {
    const auto rows = static_cast<std::size_t>(random.uniform() * 30.0);
    std::vector<double> numbers;
    TextColumn text;
    for (std::size_t row = 0; row < rows; ++row) {
      const double size = std::pow(10.0, 40.0 * random.normal());
      numbers.push_back(random.uniform() < 0.1 ? kMissing : random.normal() * size);
      std::string value = "t";  // never missing, never a number
      while (random.uniform() < 0.7) {
        value += pieces[static_cast<std::size_t>(random.uniform() * 10.0)];
      }
      value += 't';  // blanks at the ends are no part of a text
      random.uniform() < 0.1 ? text.append_missing() : text.append(value);
    }
    Table table;
    table.set("x,\"y\"", numbers);
    if (round % 2 == 0) table.set("text", text);
    std::ostringstream stream;
    write_csv_table(table, stream);
    const ScratchFile file(stream.str());
    const Table back = read_csv_table(file.path(), {.text_columns = {"text"}});

    REQUIRE(back.names() == table.names());
    REQUIRE(back.rows() == rows);
    for (std::size_t row = 0; row < rows; ++row) {
      const double found = back.numbers("x,\"y\"")[row];
      CHECK((found == numbers[row] || (std::isnan(found) && std::isnan(numbers[row]))));
      if (round % 2 == 0) CHECK(back.text("text")[row] == text[row]);
    }
  }
}

TEST_CASE("a text that a spreadsheet would compute is written with an apostrophe") {
  CHECK(csv_field("=1+1") == "'=1+1");
  CHECK(csv_field("-2+3+cmd|' /C calc'!A0") == "'-2+3+cmd|' /C calc'!A0");
  CHECK(csv_field("@SUM(A1,B1)") == "\"'@SUM(A1,B1)\"");
  CHECK(csv_field(" +x") == "' +x");
  CHECK(csv_field("'=x") == "''=x");
  // A spreadsheet with other separators splits the field there.
  CHECK(csv_field("a;=x") == "\"a;'=x\"");
  CHECK(csv_field("a\t=x") == "\"a\t'=x\"");
  CHECK(csv_field("a\n=x") == "\"a\n'=x\"");
  for (const char* const harmless :
       {"", "a=1", "'oak'", "-0.5", "+5", "-1e-05", "-", "--", "-inf"}) {
    CHECK(csv_field(harmless) == harmless);
  }
  CHECK(csv_field("-1,5") == "\"-1,5\"");
}

TEST_CASE("names like formulas are read as they were written, also in the header") {
  Table table(5);
  const std::vector<std::string> names{"=1+1", "'=1", "''-x", "@oak", "+"};
  TextColumn column;
  for (const std::string& name : names) column.append(name);
  table.set("=name", std::move(column));
  table.set("n", std::vector<double>{-1, 2, -3e-9, 4, 5});
  const ScratchFile file("");
  write_csv_table(table, file.path());
  const Table read = read_csv_table(file.path());
  CHECK(read.names() == table.names());
  for (std::size_t i = 0; i < names.size(); ++i) CHECK(read.text("=name")[i] == names[i]);
  CHECK(read.numbers("n")[2] == -3e-9);
}

TEST_CASE("a table is written to its file whole") {
  const ScratchFile file("");
  Table table;
  table.set("dbh", {0.1, kMissing, 12.0});
  write_csv_table(table, file.path());
  std::ifstream stream(file.path());
  const std::string bytes((std::istreambuf_iterator<char>(stream)), {});
  CHECK(bytes == "dbh\n0.1\n\"\"\n12\n");
}
