// SPDX-License-Identifier: MIT
// Parts of the program that are loaded when they are needed.
#pragma once

#include <optional>
#include <string>

namespace silvafit {

/// A function of a module, or the reason why it cannot be loaded.
struct ModuleFunction {
  void* address = nullptr;
  std::string problem{};
};

/// Loads a module, which is never unloaded.
/// \param file  its file in lib/silvafit beside the folder of the program, without the ending
/// \param shares_symbols  whether libraries that are loaded later use the symbols of its libraries
/// \return nothing if there is no such file, or the program is static and cannot load any
std::optional<ModuleFunction> module_function(const std::string& file,
                                              const char* function,
                                              bool shares_symbols);

}  // namespace silvafit
