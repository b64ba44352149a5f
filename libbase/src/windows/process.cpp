// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <io.h>
// Before shellapi.h, which needs it.
#include <windows.h>
// Apart, because they are sorted.
#include <shellapi.h>

#include <array>
#include <cstdlib>

#include "silvafit/base/system.hpp"

namespace silvafit::system {
namespace {

void (*on_interrupt)() = nullptr;

/// Windows calls it on a thread of its own. Further handlers then end the process.
BOOL WINAPI handle_interrupt(DWORD /*kind*/) {
  on_interrupt();
  return FALSE;
}

HANDLE handle_of(std::FILE* stream) {
  return reinterpret_cast<HANDLE>(::_get_osfhandle(::_fileno(stream)));
}

}  // namespace

std::vector<std::string> command_line(int argc, char** argv) {
  int count = 0;
  wchar_t** const words = ::CommandLineToArgvW(::GetCommandLineW(), &count);
  if (words == nullptr) return {argv, argv + argc};
  std::vector<std::string> texts;
  // Paths are converted to UTF-8, and a path may be any text.
  for (int i = 0; i < count; ++i) texts.push_back(std::filesystem::path(words[i]).string());
  ::LocalFree(words);
  return texts;
}

void prepare_standard_streams() {
  ::SetConsoleOutputCP(CP_UTF8);
  for (std::FILE* const stream : {stdin, stdout, stderr}) {
    // Without a console, as in scheduled jobs, streams have no descriptor.
    if (::_fileno(stream) >= 0) ::_setmode(::_fileno(stream), _O_BINARY);
    DWORD mode = 0;
    if (stream == stdin || ::GetConsoleMode(handle_of(stream), &mode) == 0) continue;
    ::SetConsoleMode(handle_of(stream), mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING);
  }
}

bool is_terminal(std::FILE* stream) {
  DWORD mode = 0;
  return ::GetConsoleMode(handle_of(stream), &mode) != 0;
}

// Jobs of several processes, which need these two, do not exist here.
int silence(std::FILE* /*stream*/) { return -1; }
void restore(std::FILE* /*stream*/, int /*descriptor*/) {}

void clean_up_on_interrupts(void (*clean_up)()) {
  on_interrupt = clean_up;
  ::SetConsoleCtrlHandler(handle_interrupt, TRUE);
}

// Threads of the C library start with a lower precision of the x87, with which it computes powers
// and logarithms, than the first thread has.
void prepare_thread() { __asm__ volatile("fninit"); }

// The heap keeps it.
void keep_freed_memory() {}

std::filesystem::path program_file() {
  std::array<wchar_t, 32768> name{};  // the longest path
  const DWORD length = ::GetModuleFileNameW(nullptr, name.data(), name.size());
  return std::wstring(name.data(), length);
}

bool has_desktop() { return true; }

bool takes_dropped_files() { return true; }

bool has_own_console() {
  std::array<DWORD, 2> processes{};
  return ::GetConsoleProcessList(processes.data(), processes.size()) == 1;
}

bool open_in_browser(const std::filesystem::path& page) {
  constexpr std::intptr_t kLargestError = 32;
  const HINSTANCE result =
      ::ShellExecuteW(nullptr, L"open", page.c_str(), nullptr, nullptr, SW_SHOWNORMAL);
  return reinterpret_cast<std::intptr_t>(result) > kLargestError;
}

}  // namespace silvafit::system
