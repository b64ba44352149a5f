// SPDX-License-Identifier: MIT
// silvafit completion SHELL: completion scripts for commands, options and their values.
#include <fmt/format.h>

#include <memory>
#include <string>

#include "command.hpp"
#include "outline.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

// The words of a command without the program's name.
std::string path_of(const CommandOutline& command) {
  return joined({command.words.begin() + 1, command.words.end()});
}

void replace_all(std::string& text, const std::string& what, const std::string& with) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += with.size()) {
    text.replace(at, what.size(), with);
  }
}

// ---------------------------------------------------------------- bash

std::string bash_words(const CommandOutline& command) {
  std::vector<std::string> words;
  for (const CommandOutline& below : command.commands) words.push_back(below.words.back());
  for (const OptionOutline& option : command.options) {
    words.insert(words.end(), option.names.begin(), option.names.end());
  }
  return joined(words);
}

// The patterns of `case` for all names of an option: "fit -o"|"fit --out"
std::string bash_pattern(const CommandOutline& command, const OptionOutline& option) {
  std::vector<std::string> patterns;
  for (const std::string& name : option.names) {
    patterns.push_back(fmt::format("\"{} {}\"", path_of(command), name));
  }
  return joined(patterns, "|");
}

std::string bash_completion(const CommandOutline& program) {
  std::string paths;
  std::string values;
  std::string words;
  for (const CommandOutline* command : all_commands(program)) {
    if (command != &program) {
      const std::vector<std::string> above(command->words.begin() + 1, command->words.end() - 1);
      paths += fmt::format(
          "{}\"{} {}\"", paths.empty() ? "" : "|", joined(above), command->words.back());
    }
    words += fmt::format("    \"{}\") words=\"{}\" ;;\n", path_of(*command), bash_words(*command));
    for (const OptionOutline& option : command->options) {
      if (option.value.empty()) continue;
      values += fmt::format(
          "    {}) words=\"{}\" ;;\n", bash_pattern(*command, option), joined(option.choices));
    }
  }
  return fmt::format(R"(# Completion for bash, written by `silvafit completion bash`.
_silvafit() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD - 1]}} command= words= i
  COMPREPLY=()
  # Bash splits --option=value into three words.
  if [[ $word == "=" ]]; then
    word=
  elif [[ $previous == "=" ]]; then
    previous=${{COMP_WORDS[COMP_CWORD - 2]}}
  fi
  for ((i = 1; i < COMP_CWORD; i++)); do
    case "$command ${{COMP_WORDS[i]}}" in
    {}) command="${{command:+$command }}${{COMP_WORDS[i]}}" ;;
    esac
  done
  # The value of an option: one of these words, or a file where there are none.
  case "$command $previous" in
{}    *)
  case "$command" in
{}  esac ;;
  esac
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
}}
complete -o default -F _silvafit silvafit
)",
                     paths,
                     values,
                     words);
}

// ---------------------------------------------------------------- zsh

std::string in_single_quotes(std::string text) {
  replace_all(text, "'", "'\\''");
  return "'" + text + "'";
}

std::string zsh_escaped(std::string text) {
  for (const char* special : {"\\", "[", "]", ":"}) {
    replace_all(text, special, std::string("\\") + special);
  }
  return text;
}

// The value of an option or argument: `:VALUE:(wald profile)` or `:VALUE:_files`.
std::string zsh_value(const OptionOutline& option) {
  const std::string action =
      option.choices.empty() ? "_files" : fmt::format("({})", joined(option.choices));
  return fmt::format(":{}:{}", zsh_escaped(option.value), action);
}

std::string zsh_function(const CommandOutline& command) {
  std::string specifications;
  for (const OptionOutline& option : command.options) {
    for (const std::string& name : option.names) {
      const std::string text = fmt::format("{}{}[{}]{}",
                                           option.repeatable ? "*" : "",
                                           name,
                                           zsh_escaped(option.description),
                                           option.value.empty() ? "" : zsh_value(option));
      specifications += " \\\n    " + in_single_quotes(text);
    }
  }
  const std::string name = joined(command.words, "_");
  if (command.commands.empty()) {
    return fmt::format(
        "_{}() {{\n  _arguments{} \\\n    '*:file:_files'\n}}\n", name, specifications);
  }
  std::string commands;
  std::string branches;
  for (const CommandOutline& below : command.commands) {
    const std::string& word = below.words.back();
    commands += "    " + in_single_quotes(word + ":" + below.description) + "\n";
    branches += fmt::format("      {}) _{}_{} ;;\n", word, name, word);
  }
  return fmt::format(R"(_{0}() {{
  local context state line
  local -a commands
  commands=(
{1}  )
  _arguments -C{2} \
    '1: :->command' '*:: :->rest'
  case $state in
    command) _describe command commands ;;
    rest)
      case $words[1] in
{3}      esac ;;
  esac
}}
)",
                     name,
                     commands,
                     specifications,
                     branches);
}

std::string zsh_completion(const CommandOutline& program) {
  std::string text =
      "#compdef silvafit\n# Completion for zsh, written by `silvafit completion zsh`.\n";
  for (const CommandOutline* command : all_commands(program)) text += zsh_function(*command);
  return text + R"(if [ "$funcstack[1]" = "_silvafit" ]; then
  _silvafit "$@"
else
  compdef _silvafit silvafit
fi
)";
}

// ---------------------------------------------------------------- fish

// The condition under which words of a command are offered.
std::string fish_condition(const CommandOutline& command) {
  std::string condition;
  for (std::size_t i = 1; i < command.words.size(); ++i) {
    condition += fmt::format(
        "{}__fish_seen_subcommand_from {}", condition.empty() ? "" : "; and ", command.words[i]);
  }
  if (command.commands.empty()) return condition;
  std::vector<std::string> below;
  for (const CommandOutline& next : command.commands) below.push_back(next.words.back());
  return fmt::format("{}{}__fish_seen_subcommand_from {}",
                     condition,
                     condition.empty() ? "not " : "; and not ",
                     joined(below));
}

std::string fish_option(const OptionOutline& option) {
  std::string text;
  for (const std::string& name : option.names) {
    const bool is_long = name.rfind("--", 0) == 0;
    text += is_long ? " -l " + name.substr(2) : " -s " + name.substr(1);
  }
  if (!option.value.empty()) text += option.choices.empty() ? " -r -F" : " -x";
  if (!option.choices.empty()) text += fmt::format(" -a '{}'", joined(option.choices));
  return text;
}

// Within single quotes, fish needs a backslash only before quotes and backslashes.
std::string in_fish_quotes(std::string text) {
  replace_all(text, "\\", "\\\\");
  replace_all(text, "'", "\\'");
  return "'" + text + "'";
}

std::string fish_completion(const CommandOutline& program) {
  std::string text = "# Completion for fish, written by `silvafit completion fish`.\n";
  for (const CommandOutline* command : all_commands(program)) {
    const std::string start = fmt::format("complete -c silvafit -n '{}'", fish_condition(*command));
    for (const CommandOutline& below : command->commands) {
      text += fmt::format(
          "{} -f -a {} -d {}\n", start, below.words.back(), in_fish_quotes(below.description));
    }
    for (const OptionOutline& option : command->options) {
      text += fmt::format(
          "{}{} -d {}\n", start, fish_option(option), in_fish_quotes(option.description));
    }
  }
  return text;
}

}  // namespace

void add_completion_command(CLI::App& program) {
  const auto shell = std::make_shared<std::string>();
  const auto common = std::make_shared<CommonOptions>();
  CLI::App& command =
      *program.add_subcommand("completion", "Print the completion script for a shell");
  command.add_option("shell", *shell, "The shell")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  add_common_options(command, *common);
  add_example(command, "silvafit completion bash");
  command.callback([&program, shell, common] {
    const CommandOutline whole = outline(program);
    const std::string text = *shell == "bash"  ? bash_completion(whole)
                             : *shell == "zsh" ? zsh_completion(whole)
                                               : fish_completion(whole);
    if (common->json) {
      print_json_value({{"schema", "silvafit-completion/1"},
                        {"silvafit", version()},
                        {"shell", *shell},
                        {"script", text}});
    } else {
      fmt::print("{}", text);
    }
  });
}

}  // namespace silvafit::cli
