// SPDX-License-Identifier: MIT
#include "files/json_spool.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "silvafit/base/json_text.hpp"

namespace silvafit::tree {

std::string json_quoted(const std::string& text) { return json_text(nlohmann::json(text)); }

std::string json_triple(const std::array<double, 3>& values) {
  return fmt::format("[{},{},{}]", values[0], values[1], values[2]);
}

std::size_t ArraySpool::add(const std::string& item) {
  if (count_ > 0) spool_.append(",");
  spool_.append(item);
  return count_++;
}

std::size_t Pieces::size() const {
  std::size_t sum = 0;
  for (const auto& [text, spool] : pieces_) sum += spool != nullptr ? spool->size() : text.size();
  return sum;
}

void Pieces::write_to(std::ostream& to) const {
  for (const auto& [text, spool] : pieces_) {
    if (spool != nullptr) {
      spool->copy_to(to);
    } else {
      to << text;
    }
  }
}

}  // namespace silvafit::tree
