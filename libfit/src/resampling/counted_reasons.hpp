// SPDX-License-Identifier: MIT
// How often each verdict occurs among many fits.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/fit/bootstrap.hpp"

namespace silvafit::fit {

class ReasonCounts {
 public:
  /// Counts a verdict; those that differ in their numbers only are one, which shows "#" for them.
  void add(std::string_view verdict) { ++counts_[without_numbers(verdict)]; }
  void add_exactly(const std::string& reason) { ++counts_[reason]; }

  /// Commonest first, equal ones by their text.
  std::vector<CountedReason> sorted() const;

 private:
  static std::string without_numbers(std::string_view text);

  std::map<std::string, std::size_t> counts_;
};

}  // namespace silvafit::fit
