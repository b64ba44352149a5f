// SPDX-License-Identifier: MIT
#include "help.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::cli {
namespace {

/// The options that most people need; commands that are not here have few options.
const std::map<std::string, std::string, std::less<>> kFirst{
    {"study", "columns species responses covariates group window per out config init"},
    {"indices", "columns window per edge buffer neighbors further plots out json"},
    {"stand", "columns window per plot-area plots class-width stratum equations growth out"},
    {"fit",
     "formula model parameter random variance correlation where method intervals columns json"},
    {"predict",
     "columns level interval interval-kind new-groups standard-errors role equations out json"},
    {"impute", "columns response by group model formula random minimum-trees add-residual out"},
    {"grow", "columns plot scene out format builder preset lod share use"},
    {"render", "out size samples camera eye look path sun date place"},
    {"view", "columns plot out title trees models lod plain no-open json"}};

bool is_first(const CLI::Option& option, const std::vector<std::string>& names) {
  return std::ranges::any_of(option.get_lnames(), [&names](const std::string& name) {
    return name.starts_with("help") || std::ranges::find(names, name) != names.end();
  });
}

class ShortHelp : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app,
                        std::string name,
                        CLI::AppFormatMode mode) const override {
    const auto first = kFirst.find(app->get_name());
    const bool is_short = mode == CLI::AppFormatMode::Normal && first != kFirst.end();
    // Commands below one have a help of their own.
    if (!is_short) return CLI::Formatter::make_help(app, name, CLI::AppFormatMode::Normal);
    return make_description(app) + make_usage(app, name) + make_positionals(app) +
           first_options(*app, CLI::detail::split(first->second, ' ')) + "\n" + make_footer(app);
  }

 private:
  std::string first_options(const CLI::App& app, const std::vector<std::string>& names) const {
    std::string text;
    std::size_t others = 0;
    for (const std::string& section : app.get_groups()) {
      const auto all = app.get_options([&section](const CLI::Option* option) {
        return option->get_group() == section && option->nonpositional();
      });
      std::vector<const CLI::Option*> shown;
      std::ranges::copy_if(all, std::back_inserter(shown), [&names](const CLI::Option* option) {
        return is_first(*option, names);
      });
      others += all.size() - shown.size();
      if (!shown.empty()) text += make_group(section, false, shown);
    }
    return fmt::format(
        "{}\n{} more options: silvafit {} --help-all\n", text, others, app.get_name());
  }
};

}  // namespace

void add_short_help(CLI::App& program) {
  program.formatter(std::make_shared<ShortHelp>());
  program.set_help_flag("-h,--help", "Print this help and exit");
  program.set_help_all_flag("--help-all", "Print all options and exit");
}

}  // namespace silvafit::cli
