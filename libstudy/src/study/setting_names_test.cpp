// SPDX-License-Identifier: MIT
#include "silvafit/study/setting_names.hpp"

#include <catch2/catch.hpp>

using namespace silvafit::study;

namespace {

/// The words of a message as the program, R and Python write them.
void check_words(const char* words, const char* program, const char* r, const char* python) {
  CAPTURE(words);
  const auto sentence = [](std::string_view text) {
    return "use " + std::string(text) + "; a `b`";
  };
  CHECK(with_setting_names(sentence(words), Front::kProgram) == sentence(program));
  CHECK(with_setting_names(sentence(words), Front::kR) == sentence(r));
  CHECK(with_setting_names(sentence(words), Front::kPython) == sentence(python));
}

}  // namespace

TEST_CASE("settings in messages have the names of the front end") {
  check_words("`fill_down`", "--fill-down", "`fill_down`", "`fill_down`");
  check_words("`method=focei`", "--method focei", "method = \"focei\"", "method=\"focei\"");
  check_words("`agq_points=15`", "--agq-points 15", "agq_points = 15", "agq_points=15");
  check_words("`trust_units=true`", "--trust-units", "trust_units = TRUE", "trust_units=True");
  check_words("`textures=false`", "--plain", "textures = FALSE", "textures=False");
  check_words("`parameters=a ~ x`",
              "--parameter \"a ~ x\"",
              "parameters = \"a ~ x\"",
              "parameters=\"a ~ x\"");
  check_words("`columns=x=xk/10,y=yk/10`",
              "--columns x=xk/10,y=yk/10",
              "columns = c(x = \"xk/10\", y = \"yk/10\")",
              "columns={\"x\": \"xk/10\", \"y\": \"yk/10\"}");
}

TEST_CASE("values with quotes and backquotes are written so that a shell and R read them") {
  check_words("`columns=h=`H (m)`/10`",
              "--columns 'h=`H (m)`/10'",
              "columns = c(h = '`H (m)`/10')",
              "columns={\"h\": '`H (m)`/10'}");
  check_words("`where=plot != \"7\"`",
              "--where 'plot != \"7\"'",
              "where = 'plot != \"7\"'",
              "where='plot != \"7\"'");
  // A column with a comma in its name, which is no mapping of two columns.
  check_words(
      "`columns=h=H, m`", "--columns \"h=H, m\"", "columns = \"h=H, m\"", "columns=\"h=H, m\"");
}

TEST_CASE("commands are functions where there is one") {
  check_words("`silvafit grow`", "`silvafit grow`", "`grow_trees()`", "`grow()`");
  check_words("`silvafit tiles`", "`silvafit tiles`", "`silvafit tiles`", "`silvafit tiles`");
}

TEST_CASE("other words in backquotes stay") {
  for (const char* words : {"`a + b | plot`", "`Height (m)`", "`", "`buffer", "buffer", "`=`x`"}) {
    check_words(words, words, words, words);
  }
}

TEST_CASE("the place of an error is the name of an argument") {
  CHECK(name_of_place("`fill_down`") == "fill_down");
  CHECK(name_of_place("dbh") == "dbh");
}
