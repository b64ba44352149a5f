// SPDX-License-Identifier: MIT
// A grammar's text as it is read: its characters, its lines and its statements.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::tree {

/// Something is wrong at a place of a grammar's text.
struct GrammarProblem {
  std::size_t offset = 0;  ///< in the text
  std::string message{};
};

/// \throws GrammarProblem always
[[noreturn]] void refuse_grammar(std::size_t offset, std::string message);

// Plain ASCII, whatever the locale.
inline bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
inline bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
inline bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// How a character is spoken of in a message.
std::string shown(char c);

/// A place in a text that moves on as the text is read. All but next() pass over blanks first.
class GrammarCursor {
 public:
  /// \param text  up to the end of what may be read; it must outlive the cursor
  explicit GrammarCursor(std::string_view text = {}, std::size_t position = 0)
      : text_(text), position_(position) {}

  std::size_t position() const { return position_; }
  void move_to(std::size_t position) { position_ = position; }

  void skip_blanks();
  bool at_end();
  /// The character that stands here; 0 at the end.
  char peek();
  bool at(std::string_view token);
  /// Passes the token if it stands here.
  bool accept(std::string_view token);
  /// The arrow of a production, `->` or `-->`.
  bool at_arrow();
  bool accept_arrow();
  /// Passes letters, digits and underscores; none where a digit comes first.
  std::string_view word();

  /// The character right here, be it a blank; 0 at the end.
  char next() const { return position_ < text_.size() ? text_[position_] : '\0'; }
  /// Passes so many characters from right here.
  std::string_view take(std::size_t count);
  /// What was read since an offset.
  std::string_view since(std::size_t begin) const { return text_.substr(begin, position_ - begin); }
  /// What has not been read.
  std::string_view rest() const { return text_.substr(position_); }

 private:
  std::string_view text_;
  std::size_t position_;
};

/// A grammar's text without its comments. Offsets are those of the text as it was given.
class GrammarText {
 public:
  /// A definition, setting or production with the lines that continue it.
  struct Statement {
    std::size_t begin = 0;
    std::size_t end = 0;
  };

  explicit GrammarText(std::string_view text);

  /// In the order of the text. A line that begins with a blank continues the one before; empty
  /// lines count for nothing.
  std::vector<Statement> statements() const;
  /// At the statement's begin, and not to go beyond its end.
  GrammarCursor at(const Statement& statement) const;

  std::size_t size() const { return clean_.size(); }
  /// Of an offset, from 1.
  std::size_t line_of(std::size_t offset) const;
  std::size_t column_of(std::size_t offset) const;

 private:
  std::string clean_;  ///< with blanks for comments
  std::vector<std::size_t> line_begins_{0};
};

}  // namespace silvafit::tree
