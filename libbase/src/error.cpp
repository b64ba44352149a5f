// SPDX-License-Identifier: MIT
#include "silvafit/base/error.hpp"

#include <fmt/format.h>

#include <utility>

#include "silvafit/base/text.hpp"

namespace silvafit {
namespace {

std::string subject_of(const Place& place) {
  std::string subject;
  const auto add = [&subject](std::string_view word, const std::string& name) {
    if (name.empty()) return;
    subject += fmt::format("{}{} {}", subject.empty() ? " (" : ", ", word, name);
  };
  add("plot", place.plot);
  add("tree", place.tree);
  add("model", place.model);
  return subject.empty() ? subject : subject + ")";
}

}  // namespace

std::string describe(const Place& place, std::string_view message) {
  std::string text = place.file;
  if (place.line) text += fmt::format("{}{}", text.empty() ? "line " : ":", *place.line);
  if (!text.empty()) text += ": ";
  if (!place.column.empty()) text += place.column + ": ";
  return with_visible_controls(text + std::string(message) + subject_of(place));
}

Error::Error(const std::string& message, Place place)
    : std::runtime_error(describe(place, message)), place_(std::move(place)), message_(message) {}

FormulaError::FormulaError(const std::string& message, std::string_view text, std::size_t position)
    : UsageError(
          fmt::format("column {}: {}\n  {}\n  {:>{}}", position, message, text, "^", position)),
      position_(position) {}

}  // namespace silvafit
