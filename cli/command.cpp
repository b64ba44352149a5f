// SPDX-License-Identifier: MIT
#include "command.hpp"

#include <fmt/format.h>
#include <sys/auxv.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <mutex>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/base/text.hpp"
#include "standard_streams.hpp"

namespace silvafit::cli {

void add_common_options(CLI::App& command, CommonOptions& options) {
  command.add_flag("--json", options.json, "Print the result as JSON");
  command.add_flag("--quiet", options.quiet, "No progress and no notes");
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

void say(const CommonOptions& options, const std::string& message) {
  if (!options.quiet) write_to_standard_error(with_visible_controls(message) + "\n");
}

struct Progress::State {
  bool visible = false;
  std::mutex mutex;
  std::chrono::steady_clock::time_point last{};
};

Progress::Progress(const CommonOptions& options) : state_(std::make_unique<State>()) {
  state_->visible = !options.quiet && ::isatty(STDERR_FILENO) == 1;
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

namespace {

/// The file of this program.
std::filesystem::path program_file() {
  std::error_code unknown;
  std::filesystem::path file = std::filesystem::read_symlink("/proc/self/exe", unknown);
  if (!unknown) return file;
  // Without /proc: the name in the command line.
  // NOLINTNEXTLINE(performance-no-int-to-ptr): the kernel returns pointers as numbers
  const auto* const name = reinterpret_cast<const char*>(::getauxval(AT_EXECFN));
  return name == nullptr ? file : followed(name);
}

}  // namespace

std::filesystem::path data_directory() {
  namespace fs = std::filesystem;
  if (const char* named = std::getenv("SILVAFIT_DATA_DIR")) return named;
  fs::path directory = program_file().parent_path().parent_path() / "share" / "silvafit";
  if (!is_there(directory / "models")) {
    throw InputError(
        "the model catalogue was not found; set SILVAFIT_DATA_DIR to the folder that contains "
        "models/",
        {.file = directory.string()});
  }
  return directory;
}

std::filesystem::path bundled_page(const std::string& name) {
  std::filesystem::path page = data_directory() / "viewer" / name;
  if (is_there(page)) return page;
  throw InputError(
      "the page template was not found: this silvafit was built without the viewer; build it with "
      "-DSILVAFIT_BUILD_VIEWER=ON, which needs npm, and install it again",
      {.file = page.string()});
}

std::string command_line() {
  constexpr const char* kWords = "/proc/self/cmdline";
  if (!is_there(kWords)) return "silvafit";
  const std::string words = read_file(kWords);
  std::string line;
  for (std::size_t begin = 0; begin < words.size();) {
    const std::size_t end = words.find('\0', begin);
    std::string word = words.substr(begin, end - begin);
    if (begin == 0) word = std::filesystem::path(word).filename().string();
    const bool is_plain = word.find_first_of(" \t'\"$*?;&|<>()") == std::string::npos;
    line += (line.empty() ? "" : " ") + (is_plain ? word : fmt::format("'{}'", word));
    begin = end == std::string::npos ? words.size() : end + 1;
  }
  return line;
}

std::string version() { return SILVAFIT_VERSION; }

}  // namespace silvafit::cli
