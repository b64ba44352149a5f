// SPDX-License-Identifier: MIT
// The place of the table in a CSV file: spreadsheets write titles above it and units below names.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::data {

/// The positions of the header and of the lines around it.
struct TableStart {
  char separator = ',';
  std::size_t bytes_above = 0;  ///< of the text, before the header
  std::size_t lines_above = 0;  ///< line ends in these bytes
  std::size_t titles = 0;       ///< records with titles and comments among them
  /// Of each field, if the record below the header holds units; else none.
  std::vector<std::string> units{};
};

inline bool is_line_end(char c) { return c == '\n' || c == '\r'; }

/// Line ends in a text, \r\n being one.
std::size_t count_line_ends(std::string_view text);

/// Finds the header in the first bytes of a file.
///
/// The first record is the header unless it is a comment (#), or a title above a record of names
/// that fills more fields and has numbers below it.
/// \param text       the first bytes of a file, without byte order mark
/// \param is_whole   the file has no more bytes
/// \param separator  if the file names it; otherwise the header determines it
TableStart start_of_table(std::string_view text, bool is_whole, std::optional<char> separator);

}  // namespace silvafit::data
