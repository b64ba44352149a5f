// SPDX-License-Identifier: MIT
// Results on standard output: checks that they were written, and JSON; notes on standard error.
#pragma once

#include <fmt/format.h>

#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>
#include <utility>

#include "silvafit/base/json_values.hpp"

namespace silvafit::cli {

/// Prints a text with control characters as escapes, as in messages.
void print_visible(std::string_view text);

/// Formats as fmt::print does and prints the text with its control characters as escapes: names of
/// a file must not control the terminal.
template <typename... Values>
void print_text(fmt::format_string<Values...> format, Values&&... values) {
  print_visible(fmt::format(format, std::forward<Values>(values)...));
}

/// During its lifetime, control characters of tables on std::cout are printed as escapes if it is a
/// terminal. Files and pipes get them unchanged.
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

/// Flushes the streams. A result that could not be written completely is an error, also if the
/// disk was full only at its last lines.
/// \throws IoError if standard output could not be written
void finish_standard_output();

/// Writes a text unchanged to standard error. A failure is ignored: it does not stop the work or
/// change the exit status.
void write_to_standard_error(std::string_view text) noexcept;

/// Prints a value and a line end.
/// \param indent  blanks per level; -1: all in one line
void print_json_value(const nlohmann::ordered_json& value, int indent = 2);

}  // namespace silvafit::cli
