// SPDX-License-Identifier: MIT
// The program silvafit: reads the command line, runs a subcommand, maps errors to exit statuses.
#include <fmt/format.h>

#include <exception>

#include "build_information.hpp"
#include "command.hpp"
#include "command_line_mistakes.hpp"
#include "interrupts.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "standard_output.hpp"
#include "standard_streams.hpp"

namespace silvafit::cli {
namespace {

int report(const char* kind, const std::exception& error, ExitStatus status) {
  write_to_standard_error(
      fmt::format("silvafit: {}{}\n", kind, with_visible_controls(error.what())));
  return status;
}

int run(int argc, char** argv) {
  CLI::App program("Turns a forest inventory into height and crown models and 3D trees.",
                   "silvafit");
  add_version_options(program);
  program.require_subcommand(1);
  program.failure_message(CLI::FailureMessage::simple);

  add_study_command(program);
  add_indices_command(program);
  add_stand_command(program);
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

  try {
    require_command(program, {argv + 1, argv + argc});
    program.parse(argc, argv);
    finish_standard_output();
    return kDone;
  } catch (const CLI::ExtrasError& error) {
    return report("", UsageError(unexpected_words(program)), kBadUsage);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);
    return report("", UsageError(unreadable_words(program, error)), kBadUsage);
  } catch (const NoConvergedFit& error) {
    return report("", error, kNoConvergedFit);
  } catch (const UsageError& error) {
    return report("", error, kBadUsage);
  } catch (const InputError& error) {
    return report("", error, kBadInput);
  } catch (const NumericalError& error) {
    return report("", error, kNoConvergedFit);
  } catch (const GeometryError& error) {
    return report("", error, kBadInput);
  } catch (const std::bad_alloc& error) {
    return report("out of memory: ", error, kInternalError);
  } catch (const std::exception& error) {
    return report("internal error, please report it: ", error, kInternalError);
  }
}

}  // namespace
}  // namespace silvafit::cli

int main(int argc, char** argv) {
  try {
    silvafit::cli::occupy_closed_streams();
    silvafit::cli::clean_up_on_interrupts();
    return silvafit::cli::run(argc, argv);
  } catch (...) {
    silvafit::cli::write_to_standard_error("silvafit: out of memory or threads\n");
    return silvafit::cli::kInternalError;
  }
}
