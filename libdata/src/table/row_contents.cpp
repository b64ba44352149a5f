// SPDX-License-Identifier: MIT
#include "silvafit/data/row_contents.hpp"

#include <bit>
#include <cmath>
#include <functional>
#include <string>

namespace silvafit::data {
namespace {

std::uint64_t mixed(std::uint64_t content, std::uint64_t value) {
  // The odd number next to 2^64 divided by the golden ratio; see Knuth, vol. 3, section 6.4.
  constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15U;
  return (std::rotl(content, 29) ^ value) * kGolden;
}

std::uint64_t bits_of(double value) {
  return std::bit_cast<std::uint64_t>(std::isnan(value) ? kMissing : value + 0.0);
}

}  // namespace

std::uint64_t content_with(std::uint64_t content, std::string_view field) {
  return mixed(content, std::hash<std::string_view>()(field));
}

std::vector<std::uint64_t> row_contents(const Table& table) {
  std::vector<std::uint64_t> contents(table.rows());
  for (const std::string& name : table.names()) {
    if (table.is_numeric(name)) {
      const auto values = table.numbers(name);
      for (std::size_t i = 0; i < values.size(); ++i) {
        contents[i] = mixed(contents[i], bits_of(values[i]));
      }
    } else {
      const TextColumn& texts = table.text(name);
      for (std::size_t i = 0; i < texts.size(); ++i) {
        contents[i] = mixed(contents[i], texts.code(i));
      }
    }
  }
  return contents;
}

}  // namespace silvafit::data
