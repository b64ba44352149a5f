// SPDX-License-Identifier: MIT
#include "prediction_digits.hpp"

namespace silvafit::cli {
namespace {

constexpr int kAllDigits = 17;  // distinguish any two doubles

}  // namespace

void add_digits_option(CLI::App& command, int& digits) {
  command
      .add_option(
          "--digits", digits, "Significant digits of predictions; 17 writes all that there are")
      ->check(CLI::Range(1, kAllDigits))
      ->type_name("N")
      ->capture_default_str();
}

}  // namespace silvafit::cli
