// SPDX-License-Identifier: MIT
#include "standard_output.hpp"

#include <cstdio>
#include <iostream>

#include "silvafit/base/io_error.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/base/system.hpp"
#include "silvafit/base/text.hpp"

namespace silvafit::cli {

using nlohmann::ordered_json;

void print_visible(std::string_view text) { fmt::print("{}", with_visible_controls(text)); }

VisibleTables::VisibleTables() {
  if (system::is_terminal(stdout)) replaced_ = std::cout.rdbuf(this);
}

VisibleTables::~VisibleTables() {
  if (replaced_ != nullptr) std::cout.rdbuf(replaced_);
}

int VisibleTables::sync() {
  print_visible(view());
  str("");
  return 0;
}

void finish_standard_output() {
  std::cout.flush();
  if (!std::cout || std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    throw IoError("writing to standard output failed");
  }
}

void write_to_standard_error(std::string_view text) noexcept {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

void print_json_value(const ordered_json& value, int indent) {
  print_text("{}\n", json_text(value, indent));
}

}  // namespace silvafit::cli
