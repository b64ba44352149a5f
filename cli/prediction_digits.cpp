// SPDX-License-Identifier: MIT
#include "prediction_digits.hpp"

#include <fmt/format.h>

#include <charconv>

#include "silvafit/data/csv.hpp"

namespace silvafit::cli {
namespace {

constexpr int kAllDigits = 17;  // tell any two doubles apart

}  // namespace

void add_digits_option(CLI::App& command, int& digits) {
  command
      .add_option(
          "--digits", digits, "Significant digits of predictions; 17 writes all that there are")
      ->check(CLI::Range(1, kAllDigits))
      ->type_name("N")
      ->capture_default_str();
}

std::string with_digits(double value, int digits) {
  if (digits >= kAllDigits) return data::shortest(value);
  const std::string text = fmt::format("{:.{}e}", value, digits - 1);
  double rounded = value;
  std::from_chars(text.data(), text.data() + text.size(), rounded);
  return data::shortest(rounded);
}

}  // namespace silvafit::cli
