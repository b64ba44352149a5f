// SPDX-License-Identifier: MIT
// silvafit manual --out DIR: the manual pages, silvafit.1 and one for each command.
#include <fmt/format.h>

#include <cctype>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "command.hpp"
#include "outline.hpp"
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

std::string page_name(const CommandOutline& command) { return joined(command.words, "-"); }

std::string synopsis(const CommandOutline& command) {
  std::string text = ".B " + plain(joined(command.words)) + "\n[\\fIoptions\\fR]";
  if (!command.commands.empty()) text += " \\fIcommand\\fR ...";
  for (const OptionOutline& argument : command.arguments) {
    const std::string value = italic(argument.value);
    text += argument.required ? " " + value
                              : fmt::format(" [{}{}]", value, argument.repeatable ? " ..." : "");
  }
  return text + "\n";
}

std::string explained(const OptionOutline& option) {
  std::string text = plain(option.description);
  if (!option.choices.empty())
    text += fmt::format(". One of: {}", plain(joined(option.choices, ", ")));
  if (!option.default_value.empty())
    text += fmt::format(" (default: {})", plain(option.default_value));
  return text + "\n";
}

std::string list_of(const std::string& heading, const std::vector<OptionOutline>& options) {
  std::string text;
  for (const OptionOutline& option : options) {
    std::string tag;
    for (const std::string& name : option.names) tag += (tag.empty() ? "" : ", ") + bold(name);
    if (!option.value.empty()) tag += " " + italic(option.value);
    text += fmt::format(".TP\n{}\n{}", tag, explained(option));
  }
  return text.empty() ? text : fmt::format("{}\n{}", heading, text);
}

std::string example_of(const CommandOutline& command) {
  if (command.example.empty()) return "";
  return fmt::format(".SH EXAMPLE\n.nf\n{}.fi\n", plain(command.example));
}

// Each command of the program has a page; commands below a command have a section in its page.
std::string section_of(const CommandOutline& command) {
  return fmt::format(
      ".SH {}\n{}.PP\n{}.\n{}{}{}",
      plain(upper(joined(command.words))),
      synopsis(command),
      plain(command.description),
      list_of(".SS Arguments", command.arguments),
      list_of(".SS Options", command.options),
      command.example.empty() ? "" : ".SS Example\n.nf\n" + plain(command.example) + ".fi\n");
}

std::string table_of_commands(const CommandOutline& command) {
  std::string text;
  for (const CommandOutline& below : command.commands) {
    text += fmt::format(".TP\n{}\n{}\n", bold(joined(below.words)), plain(below.description));
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

std::string see_also(const CommandOutline& program, const CommandOutline& command) {
  std::string text;
  const auto add = [&](const CommandOutline& other) {
    if (&other == &command) return;
    text += fmt::format("{}.BR {} (1)", text.empty() ? "" : ",\n", plain(page_name(other)));
  };
  if (&program == &command) {
    for (const CommandOutline& below : program.commands) add(below);
  } else {
    add(program);
  }
  return ".SH SEE ALSO\n" + text + "\n";
}

std::string page(const CommandOutline& program, const CommandOutline& command) {
  std::string text = fmt::format(".TH {} 1 \"\" \"silvafit {}\" \"User Commands\"\n.nh\n",
                                 plain(upper(page_name(command))),
                                 version());
  std::string summary = command.description;
  if (summary.ends_with('.')) summary.pop_back();
  text += fmt::format(".SH NAME\n{} \\- {}\n.SH SYNOPSIS\n{}",
                      plain(page_name(command)),
                      plain(summary),
                      synopsis(command));
  text += fmt::format(".SH DESCRIPTION\n{}.\n", plain(summary));
  if (&program == &command) {
    text += ".PP\nResults go to standard output, notes to standard error.\n";
    text += table_of_commands(command);
  }
  text += list_of(".SH ARGUMENTS", command.arguments) + list_of(".SH OPTIONS", command.options);
  if (&program != &command) {
    for (const CommandOutline& below : command.commands) text += section_of(below);
  }
  return text + example_of(command) + exit_statuses() + kEnvironment + see_also(program, command);
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
    const CommandOutline whole = outline(program);
    require_writable_folder(*folder);
    std::vector<std::string> files;
    const auto write = [&](const CommandOutline& one) {
      files.push_back(page_name(one) + ".1");
      write_file(std::filesystem::path(*folder) / files.back(), page(whole, one));
    };
    write(whole);
    for (const CommandOutline& below : whole.commands) write(below);
    if (!common->json) return;
    print_json_value({{"schema", "silvafit-manual/1"},
                      {"silvafit", version()},
                      {"out", *folder},
                      {"files", files}});
  });
}

}  // namespace silvafit::cli
