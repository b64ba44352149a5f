// SPDX-License-Identifier: MIT
#include "silvafit/base/module_function.hpp"

#ifndef SILVAFIT_STATIC
#include <dlfcn.h>
#endif

#include <filesystem>
#include <system_error>

namespace silvafit {

#ifdef SILVAFIT_STATIC

std::optional<ModuleFunction> module_function(const std::string& /*file*/,
                                              const char* /*function*/,
                                              bool /*shares_symbols*/) {
  return std::nullopt;
}

#else

std::optional<ModuleFunction> module_function(const std::string& file,
                                              const char* function,
                                              bool shares_symbols) {
  std::error_code unknown;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", unknown);
  const std::filesystem::path path =
      program.parent_path().parent_path() / "lib" / "silvafit" / file;
  if (unknown || !std::filesystem::exists(path, unknown)) return std::nullopt;
  void* const module = dlopen(path.c_str(), RTLD_NOW | (shares_symbols ? RTLD_GLOBAL : RTLD_LOCAL));
  void* const address = module == nullptr ? nullptr : dlsym(module, function);
  return ModuleFunction{.address = address, .problem = address == nullptr ? dlerror() : ""};
}

#endif

}  // namespace silvafit
