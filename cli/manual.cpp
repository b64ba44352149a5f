// SPDX-License-Identifier: MIT
// silvafit manual --out DIR: the manual pages, silvafit.1 and one for each command.
#include <fmt/format.h>

#include <cctype>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "command.hpp"
#include "command_tree.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

// Text for man(7): backslashes and hyphens are escaped, and no line is read as a request.
std::string plain(const std::string& text) {
  std::string result;
  for (const char letter : text) {
    if (letter == '\\') {
      result += "\\e";
    } else if (letter == '-') {
      result += "\\-";
    } else if ((letter == '.' || letter == '\'') && (result.empty() || result.back() == '\n')) {
      result += std::string("\\&") + letter;
    } else {
      result += letter;
    }
  }
  return result;
}

std::string bold(const std::string& text) { return "\\fB" + plain(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + plain(text) + "\\fR"; }

std::string upper(std::string text) {
  for (char& letter : text)
    letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
  return text;
}

std::string page_name(const CLI::App& command) { return words_of(command, "-"); }

/// The options, or the arguments without names of their own, of a command.
std::vector<const CLI::Option*> listed(const CLI::App& command, bool are_arguments) {
  return command.get_options([are_arguments](const CLI::Option* option) {
    return !option->get_group().empty() && option->get_positional() == are_arguments;
  });
}

std::string synopsis(const CLI::App& command) {
  std::string text = ".B " + plain(words_of(command)) + "\n[\\fIoptions\\fR]";
  if (!commands_below(command).empty()) text += " \\fIcommand\\fR ...";
  for (const CLI::Option* argument : listed(command, true)) {
    const std::string value = italic(value_of(*argument));
    const bool is_repeatable = argument->get_items_expected_max() > 1;
    text += argument->get_required() ? " " + value
                                     : fmt::format(" [{}{}]", value, is_repeatable ? " ..." : "");
  }
  return text + "\n";
}

std::string explained(const CLI::Option& option) {
  std::string text = plain(option.get_description());
  const std::vector<std::string> choices = choices_of(option);
  if (!choices.empty()) text += ". One of: " + plain(fmt::format("{}", fmt::join(choices, ", ")));
  const std::string otherwise = option.get_default_str();
  if (!otherwise.empty()) text += fmt::format(" (default: {})", plain(otherwise));
  return text + "\n";
}

std::string list_of(const std::string& heading, const std::vector<const CLI::Option*>& options) {
  std::string text;
  for (const CLI::Option* option : options) {
    std::vector<std::string> names = names_of(*option);
    if (option->get_positional()) names = {option->get_name(true)};
    std::string tag;
    for (const std::string& name : names) tag += (tag.empty() ? "" : ", ") + bold(name);
    const std::string value = value_of(*option);
    if (!value.empty()) tag += " " + italic(value);
    text += fmt::format(".TP\n{}\n{}", tag, explained(*option));
  }
  return text.empty() ? text : fmt::format("{}\n{}", heading, text);
}

std::string example_of(const CLI::App& command, const char* heading) {
  const std::string footer = command.get_footer();
  const std::string before = "Example:\n";
  if (!footer.starts_with(before)) return "";
  std::string text = fmt::format("{}\n.nf\n", heading);
  for (std::string& line : CLI::detail::split(footer.substr(before.size()), '\n')) {
    text += plain(CLI::detail::ltrim(line) + "\n");
  }
  return text + ".fi\n";
}

// Each command of the program has a page; commands below a command have a section in its page.
std::string section_of(const CLI::App& command) {
  return fmt::format(".SH {}\n{}.PP\n{}.\n{}{}{}",
                     plain(upper(words_of(command))),
                     synopsis(command),
                     plain(command.get_description()),
                     list_of(".SS Arguments", listed(command, true)),
                     list_of(".SS Options", listed(command, false)),
                     example_of(command, ".SS Example"));
}

std::string table_of_commands(const CLI::App& command) {
  std::string text;
  for (const CLI::App* below : commands_below(command)) {
    text += fmt::format(".TP\n{}\n{}\n", bold(words_of(*below)), plain(below->get_description()));
  }
  return text.empty() ? text : ".SH COMMANDS\n" + text;
}

std::string exit_statuses() {
  std::string text = ".SH EXIT STATUS\n";
  const auto add = [&](ExitStatus status, const char* meaning) {
    text += fmt::format(".TP\n.B {}\n{}\n", static_cast<int>(status), meaning);
  };
  add(kDone, "done");
  add(kInternalError, "internal error, or too little memory or threads");
  add(kBadUsage, "wrong usage");
  add(kBadInput, "bad input");
  add(kNoConvergedFit, "no fit has converged; the results are still written");
  add(kIoError, "a result could not be written (a full disk, no permission), or reading failed");
  return text;
}

const char* const kEnvironment =
    ".SH ENVIRONMENT\n.TP\n.B SILVAFIT_DATA_DIR\n"
    "A folder with a catalogue of models (models/) and the report page (viewer/), to be used "
    "instead "
    "of those in the program\n";

std::string see_also(const CLI::App& command) {
  const CLI::App* const program = command.get_parent();
  const std::vector<const CLI::App*> others =
      program == nullptr ? commands_below(command) : std::vector{program};
  std::string text;
  for (const CLI::App* other : others) {
    text += fmt::format("{}.BR {} (1)", text.empty() ? "" : ",\n", plain(page_name(*other)));
  }
  return ".SH SEE ALSO\n" + text + "\n";
}

std::string page(const CLI::App& command) {
  std::string summary = command.get_description();
  if (summary.ends_with('.')) summary.pop_back();
  const std::string name = page_name(command);
  std::string text = fmt::format(
      ".TH {0} 1 \"\" \"silvafit {1}\" \"User Commands\"\n.nh\n.SH NAME\n{2} \\- {3}\n"
      ".SH SYNOPSIS\n{4}.SH DESCRIPTION\n{3}.\n",
      plain(upper(name)),
      version(),
      plain(name),
      plain(summary),
      synopsis(command));
  const bool is_program = command.get_parent() == nullptr;
  if (is_program) {
    text += ".PP\nResults go to standard output, notes to standard error.\n";
    text += table_of_commands(command);
  }
  text += list_of(".SH ARGUMENTS", listed(command, true));
  text += list_of(".SH OPTIONS", listed(command, false));
  if (!is_program) {
    for (const CLI::App* below : commands_below(command)) text += section_of(*below);
  }
  return text + example_of(command, ".SH EXAMPLE") + exit_statuses() + kEnvironment +
         see_also(command);
}

}  // namespace

void add_manual_command(CLI::App& program) {
  const auto folder = std::make_shared<std::string>();
  const auto common = std::make_shared<CommonOptions>();
  CLI::App& command = *program.add_subcommand("manual", "Write the manual pages");
  command.add_option("--out", *folder, "Folder for silvafit.1, silvafit-fit.1 and so on")
      ->type_name("DIR")
      ->required();
  add_common_options(command, *common);
  add_example(command, "silvafit manual --out man/man1");
  command.callback([&program, folder, common] {
    require_writable_folder(*folder);
    std::vector<std::string> files;
    std::vector<const CLI::App*> documented = commands_below(program);
    documented.insert(documented.begin(), &program);
    for (const CLI::App* one : documented) {
      files.push_back(page_name(*one) + ".1");
      write_file(std::filesystem::path(*folder) / files.back(), page(*one));
    }
    if (!common->json) return;
    print_json_value({{"schema", "silvafit-manual/1"},
                      {"silvafit", version()},
                      {"out", *folder},
                      {"files", files}});
  });
}

}  // namespace silvafit::cli
