// SPDX-License-Identifier: MIT
#include "text/text_parts.hpp"

namespace silvafit::fit {
namespace {

bool is_blank(char byte) { return byte == ' ' || byte == '\t' || byte == '\n' || byte == '\r'; }

}  // namespace

Part trimmed(std::string_view text, std::size_t begin, std::size_t end) {
  while (begin < end && is_blank(text[begin])) ++begin;
  while (end > begin && is_blank(text[end - 1])) --end;
  return {begin, end};
}

std::string_view of(std::string_view text, Part part) {
  return text.substr(part.begin, part.end - part.begin);
}

std::string column_name(std::string_view text, Part part) {
  const std::string_view name = of(text, part);
  const bool is_quoted =
      name.size() > 2 && name.front() == '`' && name.find('`', 1) + 1 == name.size();
  return std::string(is_quoted ? name.substr(1, name.size() - 2) : name);
}

std::string column_text(const std::string& name) {
  const bool is_plain = name.find_first_of("|/+:,;()~*=\"'") == std::string::npos;
  return is_plain ? name : "`" + name + "`";
}

bool Quotes::cover(char byte) {
  if (open_ != '\0') {
    if (byte == open_) open_ = '\0';
    return true;
  }
  if (byte == '`' || byte == '"' || byte == '\'') open_ = byte;
  return open_ != '\0';
}

std::size_t find_outside(std::string_view text, Part part, std::string_view characters) {
  int depth = 0;
  Quotes quotes;
  for (std::size_t i = part.begin; i < part.end; ++i) {
    if (quotes.cover(text[i])) continue;
    if (depth == 0 && characters.find(text[i]) != std::string_view::npos) return i;
    depth += static_cast<int>(text[i] == '(') - static_cast<int>(text[i] == ')');
  }
  return part.end;
}

bool is_enclosed(std::string_view text, Part part) {
  return part.begin < part.end && text[part.begin] == '(' &&
         find_outside(text, {part.begin + 1, part.end}, ")") + 1 == part.end;
}

std::vector<Part> split(std::string_view text, std::size_t begin, std::size_t end, char separator) {
  std::vector<Part> parts;
  int depth = 0;
  Quotes quotes;
  std::size_t start = begin;
  for (std::size_t i = begin; i < end; ++i) {
    if (quotes.cover(text[i])) continue;
    depth += static_cast<int>(text[i] == '(') - static_cast<int>(text[i] == ')');
    if (text[i] == separator && depth == 0) {
      parts.push_back(trimmed(text, start, i));
      start = i + 1;
    }
  }
  parts.push_back(trimmed(text, start, end));
  return parts;
}

}  // namespace silvafit::fit
