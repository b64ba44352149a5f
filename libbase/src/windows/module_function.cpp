// SPDX-License-Identifier: MIT
#include "silvafit/base/module_function.hpp"

namespace silvafit {

std::optional<ModuleFunction> module_function(const std::string& /*file*/,
                                              const char* /*function*/,
                                              bool /*shares_symbols*/) {
  return std::nullopt;
}

}  // namespace silvafit
