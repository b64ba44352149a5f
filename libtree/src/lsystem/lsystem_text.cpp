// SPDX-License-Identifier: MIT
#include "lsystem/lsystem_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace silvafit::tree {
namespace {

constexpr std::string_view kArrow = "->";
constexpr std::string_view kLongArrow = "-->";

bool is_name(char c) { return is_letter(c) || is_digit(c) || c == '_'; }

/// Comments become spaces, so that offsets do not change.
std::string without_comments(std::string_view text) {
  std::string clean(text);
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (text.substr(0, kByteOrderMark.size()) == kByteOrderMark) clean.replace(0, 3, "   ");
  for (std::size_t i = 0; i < clean.size(); ++i) {
    if (clean[i] != '#') continue;
    const bool is_comment = i + 1 >= clean.size() || is_blank(clean[i + 1]) || clean[i + 1] == '#';
    if (!is_comment) continue;
    for (; i < clean.size() && clean[i] != '\n'; ++i) clean[i] = ' ';
  }
  return clean;
}

}  // namespace

void refuse_grammar(std::size_t offset, std::string message) {
  throw GrammarProblem{offset, std::move(message)};
}

std::string shown(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte > ' ' && byte < 0x7f ? fmt::format("'{}'", c) : fmt::format("byte 0x{:02x}", byte);
}

// ---- GrammarCursor ------------------------------------------------------------------------------

void GrammarCursor::skip_blanks() {
  while (position_ < text_.size() && is_blank(text_[position_])) ++position_;
}

bool GrammarCursor::at_end() {
  skip_blanks();
  return position_ >= text_.size();
}

char GrammarCursor::peek() {
  skip_blanks();
  return next();
}

bool GrammarCursor::at(std::string_view token) {
  skip_blanks();
  return text_.substr(position_, token.size()) == token;
}

bool GrammarCursor::accept(std::string_view token) {
  if (!at(token)) return false;
  position_ += token.size();
  return true;
}

bool GrammarCursor::at_arrow() { return at(kArrow) || at(kLongArrow); }

bool GrammarCursor::accept_arrow() { return accept(kLongArrow) || accept(kArrow); }

std::string_view GrammarCursor::word() {
  skip_blanks();
  const std::size_t begin = position_;
  if (is_digit(next())) return {};
  while (is_name(next())) ++position_;
  return since(begin);
}

std::string_view GrammarCursor::take(std::size_t count) {
  const std::string_view taken = text_.substr(position_, count);
  position_ += taken.size();
  return taken;
}

// ---- GrammarText --------------------------------------------------------------------------------

GrammarText::GrammarText(std::string_view text) : clean_(without_comments(text)) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\n') line_begins_.push_back(i + 1);
  }
}

std::vector<GrammarText::Statement> GrammarText::statements() const {
  const std::string_view text = clean_;
  std::vector<Statement> statements;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = text.substr(begin, end - begin);
    if (!std::all_of(line.begin(), line.end(), is_blank)) {
      if (is_blank(line.front()) && !statements.empty()) {
        statements.back().end = end;
      } else {
        statements.push_back({begin, end});
      }
    }
    begin = end + 1;
  }
  return statements;
}

GrammarCursor GrammarText::at(const Statement& statement) const {
  return GrammarCursor(std::string_view(clean_).substr(0, statement.end), statement.begin);
}

std::size_t GrammarText::line_of(std::size_t offset) const {
  return static_cast<std::size_t>(
      std::upper_bound(line_begins_.begin(), line_begins_.end(), offset) - line_begins_.begin());
}

std::size_t GrammarText::column_of(std::size_t offset) const {
  return offset - line_begins_[line_of(offset) - 1] + 1;
}

}  // namespace silvafit::tree
