// SPDX-License-Identifier: MIT
// Results on standard output: checks that they were written, and JSON.
#pragma once

#include <fmt/format.h>

#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>
#include <utility>

#include "silvafit/base/json_values.hpp"

namespace silvafit::cli {

/// Prints a text with its control characters as escapes, as messages have them.
void print_visible(std::string_view text);

/// Formats as fmt::print does and prints the text with its control characters as escapes: names of
/// a file must not control the terminal.
template <typename... Values>
void print_text(fmt::format_string<Values...> format, Values&&... values) {
  print_visible(fmt::format(format, std::forward<Values>(values)...));
}

/// While it lives, tables that go to std::cout and so to a terminal have their control characters
/// as escapes. Files and pipes get them as they are.
class VisibleTables : private std::stringbuf {
 public:
  VisibleTables();
  ~VisibleTables() override;
  VisibleTables(const VisibleTables&) = delete;
  VisibleTables& operator=(const VisibleTables&) = delete;

 private:
  int sync() override;

  std::streambuf* replaced_ = nullptr;
};

/// Prints what the streams still hold. A result that did not arrive is no success, even where the
/// disk filled up in its last lines.
/// \throws IoError if standard output could not be written
void finish_standard_output();

/// Prints a value and a line end.
/// \param indent  blanks a level; -1: all in one line
void print_json_value(const nlohmann::ordered_json& value, int indent = 2);

}  // namespace silvafit::cli
