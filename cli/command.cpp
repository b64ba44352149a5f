// SPDX-License-Identifier: MIT
#include "command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <mutex>

#include "help.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/built_in_files.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/base/system.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/study/setting_names.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

const std::filesystem::path kBuiltInFolder = "silvafit:";

}  // namespace

void add_common_options(CLI::App& command, CommonOptions& options) {
  command.add_flag("--json", options.json, "Print the result as JSON")->group(kOutputSection);
  command.add_flag("--quiet", options.quiet, "No progress and no notes")->group(kOutputSection);
  command.add_option("--threads", options.threads, "Number of threads (default: all cores)");
  command.add_option("--seed", options.seed, "Seed of the random numbers")->capture_default_str();
}

void add_example(CLI::App& command, const std::string& example) {
  command.footer("Example:\n  " + example);
}

void refuse_idle(const CLI::App& command,
                 const std::string& option,
                 bool has_use,
                 const std::string& needed) {
  if (command.count(option) == 0 || has_use) return;
  throw UsageError(fmt::format("has no effect without {}", needed), {.column = option});
}

std::string with_options(std::string_view message) {
  return study::with_setting_names(message, study::Front::kProgram);
}

void say(const CommonOptions& options, const std::string& message) {
  if (!options.quiet) write_to_standard_error(with_visible_controls(with_options(message)) + "\n");
}

struct Progress::State {
  bool visible = false;
  std::mutex mutex;
  std::chrono::steady_clock::time_point last{};
};

Progress::Progress(const CommonOptions& options) : state_(std::make_unique<State>()) {
  state_->visible = !options.quiet && system::is_terminal(stderr);
}

Progress::~Progress() { clear(); }

void Progress::show(const std::string& stage, std::size_t done, std::size_t total) {
  if (!state_->visible) return;
  const std::lock_guard lock(state_->mutex);
  const auto now = std::chrono::steady_clock::now();
  constexpr auto kInterval = std::chrono::milliseconds(50);
  if (done < total && now - state_->last < kInterval) return;
  state_->last = now;
  constexpr std::size_t kWidth = 24;
  const std::size_t filled = total == 0 ? kWidth : kWidth * done / total;
  write_to_standard_error(fmt::format("\r\x1b[K{:<28} [{}{}] {}/{}",
                                      stage,
                                      std::string(filled, '#'),
                                      std::string(kWidth - filled, '.'),
                                      done,
                                      total));
}

void Progress::clear() {
  if (!state_->visible) return;
  write_to_standard_error("\r\x1b[K");
}

study::Callbacks callbacks(const CommonOptions& options, Progress& progress) {
  return {.note =
              [&options, &progress](const std::string& note) {
                progress.clear();
                say(options, "note: " + note);
              },
          .progress = [&progress](const std::string& stage,
                                  std::size_t done,
                                  std::size_t total) { progress.show(stage, done, total); }};
}

/// Of each built-in file its name with a zero, its size in 8 bytes and its bytes; at the end a
/// zero.
extern "C" const char silvafit_built_in_files[];

void add_built_in_files() {
  const char* next = silvafit_built_in_files;
  while (*next != '\0') {
    const std::string_view name = next;
    std::uint64_t size = 0;
    next += name.size() + 1;
    std::memcpy(&size, next, sizeof size);
    next += sizeof size;
    built_in_files().emplace(kBuiltInFolder / name, std::string_view(next, size));
    next += size;
  }
}

std::filesystem::path data_directory() {
  const char* const named = std::getenv("SILVAFIT_DATA_DIR");
  return named != nullptr ? named : kBuiltInFolder;
}

std::filesystem::path bundled_page(const std::string& name) {
  std::filesystem::path page = data_directory() / "viewer" / name;
  if (is_there(page)) return page;
  throw InputError(
      "the page template was not found: this silvafit was built without the viewer; build it with "
      "-DSILVAFIT_BUILD_VIEWER=ON, which needs npm, and install it again",
      {.file = page.string()});
}

std::string shown_command(std::vector<std::string> words) {
  words.front() = std::filesystem::path(words.front()).filename().string();
  for (std::string& word : words) {
    const bool is_plain = word.find_first_of(" \t'\"$*?;&|<>()") == std::string::npos;
    if (!is_plain) word = fmt::format("'{}'", word);
  }
  return fmt::format("{}", fmt::join(words, " "));
}

std::string version() { return SILVAFIT_VERSION; }

}  // namespace silvafit::cli
