// SPDX-License-Identifier: MIT
// What Linux has beyond POSIX.
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <system_error>

#include "silvafit/base/system.hpp"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace silvafit::system {
namespace {

bool is_set(const char* name) {
  const char* const value = std::getenv(name);
  return value != nullptr && *value != '\0';
}

}  // namespace

void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 512 << 20);
  mallopt(M_TOP_PAD, 16 << 20);
#endif
}

std::filesystem::path program_file() {
  std::error_code unknown;
  return std::filesystem::read_symlink("/proc/self/exe", unknown);
}

bool has_desktop() { return is_set("DISPLAY") || is_set("WAYLAND_DISPLAY"); }

bool open_in_browser(const std::filesystem::path& page) {
  std::string program = "xdg-open";
  std::string file = page.string();
  const std::array<char*, 3> words{program.data(), file.data(), nullptr};
  pid_t child = 0;
  if (::posix_spawnp(&child, program.c_str(), nullptr, nullptr, words.data(), environ) != 0) {
    return false;
  }
  int status = 0;
  return ::waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace silvafit::system
