// SPDX-License-Identifier: MIT
#include "silvafit/base/text.hpp"

#include <catch2/catch.hpp>
#include <string>

using silvafit::enumerated;
using silvafit::with_visible_controls;

TEST_CASE("control characters are seen and do nothing", "[base]") {
  CHECK(with_visible_controls("\x1b[2J\x1b]0;title\x07") == "\\x1b[2J\\x1b]0;title\\x07");
  CHECK(with_visible_controls("back\rto the start\x7f") == "back\\x0dto the start\\u007f");
  CHECK(with_visible_controls(std::string("\0", 1)) == "\\x00");
  // U+009B opens the same sequences as ESC [.
  CHECK(with_visible_controls("\xC2\x9B"
                              "2J") == "\\u009b2J");
}

TEST_CASE("controls of the direction of text are seen and do nothing", "[base]") {
  CHECK(with_visible_controls("oak\u202Etxt.exe\u202C") == "oak\\u202etxt.exe\\u202c");
  CHECK(with_visible_controls("\u2066a\u2069\u061C\u200F") == "\\u2066a\\u2069\\u061c\\u200f");
}

TEST_CASE("text without control characters is unchanged", "[base]") {
  // U+00A0 and U+00E9 share a first byte with controls or have a second byte of their range.
  for (const std::string text : {"",
                                 "one\n\ttwo",
                                 "Pic\303\251a",
                                 "\xC2\xA0",
                                 "\xE4\xBA\x91\xE6\x9D\x89",
                                 "\u2013\u2065\u206A\u200D",
                                 "\U0001F332",
                                 "\xE2\x80",
                                 "\xE2\x80z",
                                 "n\xFF.csv",
                                 "\xC2"}) {
    CHECK(with_visible_controls(text) == text);
  }
}

TEST_CASE("counts agree with their nouns and verbs") {
  CHECK(silvafit::counted(0, "tree has", "trees have") == "0 trees have");
  CHECK(silvafit::counted(1, "tree has", "trees have") == "1 tree has");
  CHECK(silvafit::counted(131, "tree has", "trees have") == "131 trees have");
}

TEST_CASE("names are enumerated with a word before the last") {
  CHECK(enumerated({}).empty());
  CHECK(enumerated({"a"}) == "a");
  CHECK(enumerated({"a", "b"}) == "a and b");
  CHECK(enumerated({"a", "b", "c"}, "or") == "a, b or c");
}
