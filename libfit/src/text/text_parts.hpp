// SPDX-License-Identifier: MIT
// Parts of model texts with their positions.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::fit {

/// A part of a text, without the blanks around it.
struct Part {
  std::size_t begin = 0;
  std::size_t end = 0;
};

Part trimmed(std::string_view text, std::size_t begin, std::size_t end);

std::string_view of(std::string_view text, Part part);

/// The name of a column: the part without backquotes around it.
std::string column_name(std::string_view text, Part part);

/// A name as column_name() reads it: in backquotes where a character has a meaning in model texts.
std::string column_text(const std::string& name);

/// Determines byte by byte what is quoted: by backquotes, or single or double quotation marks.
class Quotes {
 public:
  /// Whether the next byte of the text is quoted, the marks included.
  bool cover(char byte);

 private:
  char open_ = '\0';  ///< the mark that ends the quotation; 0 outside
};

/// The position of the first of some characters outside parentheses and quotes, or the end.
std::size_t find_outside(std::string_view text, Part part, std::string_view characters);

/// Whether one pair of parentheses is around the whole part.
bool is_enclosed(std::string_view text, Part part);

/// Parts between separators outside parentheses and quotes.
std::vector<Part> split(std::string_view text, std::size_t begin, std::size_t end, char separator);

}  // namespace silvafit::fit
