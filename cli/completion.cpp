// SPDX-License-Identifier: MIT
// silvafit completion SHELL: a script that asks the program itself what may be typed next.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "command.hpp"
#include "command_tree.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

/// Without offered words, or if none of them fits, shells complete the names of files.
constexpr char kBash[] = R"sh(# Completion for bash, written by `silvafit completion bash`.
_silvafit() {
  mapfile -t COMPREPLY < <(silvafit completion bash -- "${COMP_WORDS[@]:1:COMP_CWORD}" 2> /dev/null)
}
complete -o default -F _silvafit silvafit
)sh";

constexpr char kZsh[] = R"sh(#compdef silvafit
# Completion for zsh, written by `silvafit completion zsh`.
_silvafit() {
  local -a offered
  offered=(${(f)"$(silvafit completion zsh -- "${(@)words[2,CURRENT]}" 2> /dev/null)"})
  if (( $#offered )); then
    _describe silvafit offered
  else
    _files
  fi
}
if [ "$funcstack[1]" = "_silvafit" ]; then
  _silvafit "$@"
else
  compdef _silvafit silvafit
fi
)sh";

constexpr char kFish[] = R"sh(# Completion for fish, written by `silvafit completion fish`.
function __silvafit_offered
  set -l typed (commandline -opc) (commandline -ct)
  set -l offered (silvafit completion fish -- $typed[2..-1] 2> /dev/null)
  if test (count $offered) -gt 0
    printf '%s\n' $offered
  else
    __fish_complete_path (commandline -ct)
  end
end
complete -c silvafit -f -a '(__silvafit_offered)'
)sh";

/// A word that may be typed, and what it means.
struct Offer {
  std::string word{};
  std::string meaning{};
};

/// The values of an option by one of its names; none if it is no option with a value.
const CLI::Option* option_with_value(const CLI::App& command, const std::string& name) {
  const CLI::Option* const option =
      name.starts_with("-") ? command.get_option_no_throw(name) : nullptr;
  return option == nullptr || value_of(*option).empty() ? nullptr : option;
}

std::vector<Offer> choices_with(const std::string& before, const CLI::Option& option) {
  std::vector<Offer> offers;
  for (const std::string& choice : choices_of(option)) offers.push_back({before + choice});
  return offers;
}

/// What may follow these words; of the last one, which may be empty, all that is typed is at hand.
std::vector<Offer> offers_after(const CLI::App& program, std::vector<std::string>& words) {
  if (words.empty()) words.emplace_back();
  // Bash makes three words of --option=value.
  if (words.back() == "=") words.emplace_back();
  if (words.size() > 2 && words[words.size() - 2] == "=") words.erase(words.end() - 2);
  const CLI::App* command = &program;
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    const std::vector<const CLI::App*> below = commands_below(*command);
    const auto found = std::ranges::find(below, words[i], &CLI::App::get_name);
    if (found != below.end()) command = *found;
  }
  if (words.size() > 1) {
    const CLI::Option* const option = option_with_value(*command, words[words.size() - 2]);
    if (option != nullptr) return choices_with("", *option);
  }
  const std::size_t sign = words.back().find('=');
  if (sign != std::string::npos) {
    const CLI::Option* const option = option_with_value(*command, words.back().substr(0, sign));
    return option == nullptr ? std::vector<Offer>()
                             : choices_with(words.back().substr(0, sign + 1), *option);
  }
  std::vector<Offer> offers;
  for (const CLI::App* const below : commands_below(*command)) {
    offers.push_back({below->get_name(), below->get_description()});
  }
  if (!words.back().starts_with("-")) return offers;
  for (const CLI::Option* const option : command->get_options()) {
    if (option->get_group().empty()) continue;
    for (const std::string& name : names_of(*option)) {
      offers.push_back({name, option->get_description()});
    }
  }
  return offers;
}

void print_offers(const CLI::App& program,
                  std::vector<std::string> words,
                  const std::string& shell) {
  for (Offer& offer : offers_after(program, words)) {
    if (!offer.word.starts_with(words.back())) continue;
    if (shell == "fish") offer.word += "\t" + offer.meaning;
    // zsh reads the meaning after a colon.
    if (shell == "zsh") offer.word += ":" + offer.meaning;
    fmt::print("{}\n", offer.word);
  }
}

}  // namespace

void add_completion_command(CLI::App& program) {
  const auto shell = std::make_shared<std::string>();
  const auto words = std::make_shared<std::vector<std::string>>();
  const auto common = std::make_shared<CommonOptions>();
  CLI::App& command =
      *program.add_subcommand("completion", "Print the completion script for a shell");
  command.add_option("shell", *shell, "The shell")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  CLI::Option* const typed = command.add_option("words",
                                                *words,
                                                "After --: a command line, of which all words are "
                                                "printed that may come next; the scripts use "
                                                "this");
  typed->type_name("-- WORD ...");
  add_common_options(command, *common);
  add_example(command, "silvafit completion bash");
  command.callback([&program, shell, words, common, typed] {
    if (typed->count() > 0) return print_offers(program, *words, *shell);
    const std::string text = *shell == "bash" ? kBash : *shell == "zsh" ? kZsh : kFish;
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
