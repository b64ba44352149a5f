// SPDX-License-Identifier: MIT
// The exception hierarchy of silvafit, and the position that a message refers to.
#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace silvafit {

/// The position of an error. Every part is optional; `describe` writes the known parts.
struct Place {
  std::string file{};
  std::optional<std::size_t> line{};  ///< line in the file, from 1
  std::string column{};               ///< column name, or name of an option
  std::string plot{};
  std::string tree{};
  std::string model{};
};

/// The text of a position before its message, with control characters as escapes:
/// `trees.csv:118: hcb: 14.2 m exceeds h 12.9 m (plot 07, tree 31)`.
std::string describe(const Place& place, std::string_view message);

/// Base class of all errors. A message says what is wrong, where, and what to do.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message, Place place = {});

  const Place& place() const { return place_; }
  /// The message without its position.
  const std::string& message() const { return message_; }

 private:
  Place place_;
  std::string message_;
};

/// A wrong call: sizes that do not match, an option out of range, an unknown name.
class UsageError : public Error {
  using Error::Error;
};

/// The content of a file cannot be used.
class InputError : public Error {
  using Error::Error;
};

/// A value is outside the range where a model is defined.
class DomainError : public InputError {
  using InputError::InputError;
};

/// No result exists, or it cannot be computed with the required precision.
class NumericalError : public Error {
  using Error::Error;
};

/// A tree or mesh cannot be built.
class GeometryError : public Error {
  using Error::Error;
};

/// A formula cannot be read. `position` is the column in the text, from 1.
class FormulaError : public UsageError {
 public:
  /// \param text      the whole formula
  /// \param position  column of the offending character, from 1
  FormulaError(const std::string& message, std::string_view text, std::size_t position);

  std::size_t position() const { return position_; }

 private:
  std::size_t position_;
};

}  // namespace silvafit
