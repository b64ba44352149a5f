// SPDX-License-Identifier: MIT
// Common parts of all subcommands: options, exit statuses, progress, and the table of commands.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "silvafit/study/callbacks.hpp"

namespace silvafit::cli {

/// Exit statuses, which other programs use.
enum ExitStatus : int {
  kDone = 0,
  kInternalError = 1,  ///< also if memory or threads are not sufficient
  kBadUsage = 2,
  kBadInput = 3,
  kNoConvergedFit = 4,
  kIoError = 5,  ///< a result could not be written, or reading failed
};

/// Thrown after the results are written when no fit has converged.
class NoConvergedFit : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Options of all subcommands.
struct CommonOptions {
  bool json = false;
  bool quiet = false;
  unsigned threads = 0;  ///< 0: as many as there are cores
  std::uint64_t seed = 1;
};

/// Adds --json, --quiet, --threads and --seed to a subcommand.
void add_common_options(CLI::App& command, CommonOptions& options);

/// Adds an option for a file or folder to write.
template <typename Path>
CLI::Option* add_output_option(
    CLI::App& command, const char* name, Path& path, const char* help, const char* type = "FILE") {
  return command.add_option(name, path, help)->type_name(type)->group("Output");
}

/// Appends a working example to the text of --help.
void add_example(CLI::App& command, const std::string& example);

/// Refuses an option that was given but has no effect.
/// \param needed  the option without which it has no effect
/// \throws UsageError
void refuse_idle(const CLI::App& command,
                 const std::string& option,
                 bool has_use,
                 const std::string& needed);

/// A message of the libraries with options in place of settings.
std::string with_options(std::string_view message);

/// A note: one line on stderr, nothing with --quiet.
void say(const CommonOptions& options, const std::string& message);

/// A progress line on stderr that is overwritten; nothing with --quiet or if stderr is not a
/// terminal.
class Progress {
 public:
  explicit Progress(const CommonOptions& options);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Shows a stage and its progress. May be called from several threads.
  void show(const std::string& stage, std::size_t done, std::size_t total);
  /// Removes the line.
  void clear();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Notes on stderr, and the progress line, for the calls of libstudy.
/// \param progress  must outlive the result
study::Callbacks callbacks(const CommonOptions& options, Progress& progress);

/// Adds the catalogue and the web pages, which are part of the program, to built_in_files().
void add_built_in_files();

/// Folder of models/ and of the web pages: SILVAFIT_DATA_DIR, or that of the built-in files.
std::filesystem::path data_directory();

/// A page of the viewer in the data directory, such as report.html.
/// \throws InputError with the remedy if silvafit was built without the viewer
std::filesystem::path bundled_page(const std::string& name);

/// The command line as reports show it, with words that contain blanks in quotes.
std::string shown_command(std::vector<std::string> words);

/// The version, `0.1.0`.
std::string version();

// One function per subcommand, each in a file of its own (study.cpp, indices.cpp, ...): it adds the
// subcommand with its options and the callback that runs it.
void add_columns_command(CLI::App& program);
void add_indices_command(CLI::App& program);
void add_tiles_command(CLI::App& program);
void add_fit_command(CLI::App& program);
void add_compare_command(CLI::App& program);
/// \param command_line  as the report shows it
void add_study_command(CLI::App& program, std::string command_line);
void add_stand_command(CLI::App& program, std::string command_line);
void add_predict_command(CLI::App& program);
void add_library_command(CLI::App& program);
void add_grow_command(CLI::App& program);
void add_impute_command(CLI::App& program);
void add_render_command(CLI::App& program);
void add_view_command(CLI::App& program);
void add_simulate_command(CLI::App& program);
void add_models_command(CLI::App& program);
void add_completion_command(CLI::App& program);
void add_manual_command(CLI::App& program);

}  // namespace silvafit::cli
