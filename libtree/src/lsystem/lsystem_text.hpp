// SPDX-License-Identifier: MIT
// Lexical level of a grammar's text: characters, lines and statements.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::tree {

/// An error at a position of a grammar's text.
struct GrammarProblem {
  std::size_t offset = 0;  ///< in the text
  std::string message{};
};

/// \throws GrammarProblem always
[[noreturn]] void refuse_grammar(std::size_t offset, std::string message);

// ASCII only, for any locale.
inline bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
inline bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
inline bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// A character as shown in a message.
std::string shown(char c);

/// A position in a text that advances with reading. All functions but next() skip spaces first.
class GrammarCursor {
 public:
  /// \param text  the text to read; it must outlive the cursor
  explicit GrammarCursor(std::string_view text = {}, std::size_t position = 0)
      : text_(text), position_(position) {}

  std::size_t position() const { return position_; }
  void move_to(std::size_t position) { position_ = position; }

  void skip_blanks();
  bool at_end();
  /// The current character; 0 at the end.
  char peek();
  bool at(std::string_view token);
  /// Skips the token if it is here.
  bool accept(std::string_view token);
  /// The arrow of a production, `->` or `-->`.
  bool at_arrow();
  bool accept_arrow();
  /// Skips letters, digits and underscores; none if a digit comes first.
  std::string_view word();

  /// The character exactly here, also a space; 0 at the end.
  char next() const { return position_ < text_.size() ? text_[position_] : '\0'; }
  /// Skips this number of characters.
  std::string_view take(std::size_t count);
  /// The text read since an offset.
  std::string_view since(std::size_t begin) const { return text_.substr(begin, position_ - begin); }
  /// The text not yet read.
  std::string_view rest() const { return text_.substr(position_); }

 private:
  std::string_view text_;
  std::size_t position_;
};

/// A grammar's text without its comments. Offsets are those of the original text.
class GrammarText {
 public:
  /// A definition, setting or production with the lines that continue it.
  struct Statement {
    std::size_t begin = 0;
    std::size_t end = 0;
  };

  explicit GrammarText(std::string_view text);

  /// In the order of the text. A line that begins with a space continues the previous one; empty
  /// lines are ignored.
  std::vector<Statement> statements() const;
  /// At the start of the statement, limited to its end.
  GrammarCursor at(const Statement& statement) const;

  std::size_t size() const { return clean_.size(); }
  /// Of an offset, from 1.
  std::size_t line_of(std::size_t offset) const;
  std::size_t column_of(std::size_t offset) const;

 private:
  std::string clean_;  ///< with spaces for comments
  std::vector<std::size_t> line_begins_{0};
};

}  // namespace silvafit::tree
