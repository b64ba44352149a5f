// SPDX-License-Identifier: MIT
#include "silvafit/base/module_function.hpp"

#ifndef SILVAFIT_STATIC
#include <dlfcn.h>
#endif

#include <filesystem>
#include <system_error>

#include "silvafit/base/system.hpp"

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
  const std::filesystem::path program = system::program_file();
  const std::filesystem::path path =
      program.parent_path().parent_path() / "lib" / "silvafit" / (file + ".so");
  std::error_code unknown;
  if (program.empty() || !std::filesystem::exists(path, unknown)) return std::nullopt;
  void* const module = dlopen(path.c_str(), RTLD_NOW | (shares_symbols ? RTLD_GLOBAL : RTLD_LOCAL));
  void* const address = module == nullptr ? nullptr : dlsym(module, function);
  return ModuleFunction{.address = address, .problem = address == nullptr ? dlerror() : ""};
}

#endif

}  // namespace silvafit
