// SPDX-License-Identifier: MIT
// The program silvafit: reads the command line, runs a subcommand, maps errors to exit statuses.
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <ios>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "command.hpp"
#include "help.hpp"
#include "program.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/io_error.hpp"
#include "silvafit/base/ranks.hpp"
#include "silvafit/base/system.hpp"
#include "silvafit/base/text.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

/// The rank of this process in a job of several, with standard error redirected.
int kept_standard_error = -1;
bool has_joined_job = false;

constexpr const char* kTroubleshooting = "see docs/troubleshooting.md";

/// The first process of a job writes and prints; all others compute the same without output.
void silence_other_ranks() {
  if (Ranks::of_process().is_first()) return;
  system::silence(stdout);
  // Kept for the message of a single process that fails.
  kept_standard_error = system::silence(stderr);
}

int report(const std::string& message, ExitStatus status) {
  std::string text = fmt::format("silvafit: {}\n", with_visible_controls(message));
  if (has_joined_job) {
    Ranks& ranks = Ranks::of_process();
    // An error of all processes is reported once. An error of some processes ends the others,
    // because they wait for these.
    if (ranks.size() > 1 && !ranks.all_come_here()) {
      text = fmt::format("silvafit: process {} of {} ends the job: {}\n",
                         ranks.rank(),
                         ranks.size(),
                         with_visible_controls(message));
      if (kept_standard_error >= 0) system::restore(stderr, kept_standard_error);
      write_to_standard_error(text);
      discard_unfinished_files();
      ranks.end_job(status);
    }
  }
  write_to_standard_error(text);
  return status;
}

int report_lack(const std::string& reason) {
  return report(
      fmt::format(
          "the system has no more threads or other means ({}); {}", reason, kTroubleshooting),
      kInternalError);
}

int report(const std::exception& error, ExitStatus status) {
  return report(with_options(error.what()), status);
}

int run_command(const std::vector<std::string>& words) {
  CLI::App program("Turns a forest inventory into height and crown models and 3D trees.",
                   "silvafit");
  add_version_options(program);
  add_short_help(program);
  program.require_subcommand(1);
  // A slash begins a path on all systems.
  program.allow_windows_style_options(false);
  program.failure_message(CLI::FailureMessage::simple);

  add_study_command(program, shown_command(words));
  add_columns_command(program);
  add_indices_command(program);
  add_stand_command(program, shown_command(words));
  add_tiles_command(program);
  add_fit_command(program);
  add_compare_command(program);
  add_predict_command(program);
  add_library_command(program);
  add_impute_command(program);
  add_grow_command(program);
  add_render_command(program);
  add_view_command(program);
  add_simulate_command(program);
  add_models_command(program);
  add_completion_command(program);
  add_manual_command(program);
  add_version_to_commands(program);
  require_whole_numbers(program);
  // Added last, because commands inherit it otherwise.
  program.footer(
      "Where to begin:\n"
      "  silvafit study inventory.csv --out results   models, tables and a report, from an "
      "inventory\n"
      "  silvafit view results                        the stand in 3D, in a browser\n"
      "  silvafit COMMAND --help                      the options of a command, and an example");

  const VisibleTables visible_tables;
  try {
    add_built_in_files();
    Ranks::of_process();
    has_joined_job = true;
    silence_other_ranks();
    require_command(program, {words.begin() + 1, words.end()});
    require_filled({words.begin() + 1, words.end()});
    program.parse(std::vector<std::string>(words.rbegin(), words.rend() - 1));  // the last first
    finish_standard_output();
    return kDone;
  } catch (const CLI::ExtrasError& error) {
    return report(UsageError(unexpected_words(program)), kBadUsage);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);
    return report(UsageError(unreadable_words(program, error)), kBadUsage);
  } catch (const NoConvergedFit& error) {
    return report(error, kNoConvergedFit);
  } catch (const IoError& error) {
    return report(error, kIoError);
  } catch (const UsageError& error) {
    return report(error, kBadUsage);
  } catch (const InputError& error) {
    return report(error, kBadInput);
  } catch (const NumericalError& error) {
    return report(error, kNoConvergedFit);
  } catch (const GeometryError& error) {
    return report(error, kBadInput);
  } catch (const std::bad_alloc&) {
    return report(std::string("out of memory; ") + kTroubleshooting, kInternalError);
  } catch (const std::filesystem::filesystem_error& error) {
    return report(describe({.file = error.path1().string()}, error.code().message()), kIoError);
  } catch (const std::ios_base::failure&) {
    return report("a file could not be read or written", kIoError);
  } catch (const std::system_error& error) {
    return report_lack(error.code().message());
  } catch (const std::exception& error) {
    // TBB has no separate class for this error.
    if (std::string_view(error.what()).starts_with("pthread_create")) {
      return report_lack(error.what());
    }
    return report(std::string("internal error, please report it: ") + error.what(), kInternalError);
  }
}

/// Embree terminates the process, without an exception, where its threads find no memory.
[[noreturn]] void end_without_memory() {
  if (std::current_exception()) std::abort();
  discard_unfinished_files();
  write_to_standard_error("silvafit: out of memory or threads\n");
  std::_Exit(kInternalError);
}

}  // namespace
}  // namespace silvafit::cli

int main(int argc, char** argv) {
  try {
    silvafit::system::prepare_standard_streams();
    silvafit::system::keep_freed_memory();
    silvafit::system::clean_up_on_interrupts(silvafit::discard_unfinished_files);
    std::set_terminate(silvafit::cli::end_without_memory);
    return silvafit::cli::run_as_started(silvafit::system::command_line(argc, argv),
                                         silvafit::cli::run_command);
  } catch (...) {
    silvafit::cli::write_to_standard_error("silvafit: out of memory or threads\n");
    return silvafit::cli::kInternalError;
  }
}
