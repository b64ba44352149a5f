// SPDX-License-Identifier: MIT
#include "name_list.hpp"

namespace silvafit::cli {

std::vector<std::string> split_names(std::string_view text) {
  std::vector<std::string> names(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool is_quote = text[i] == '"';
    if (is_quote && is_quoted && i + 1 < text.size() && text[i + 1] == '"') {
      names.back() += '"';
      ++i;
    } else if (is_quote && (is_quoted || names.back().empty())) {
      is_quoted = !is_quoted;
    } else if (text[i] == ',' && !is_quoted) {
      names.emplace_back();
    } else {
      names.back() += text[i];
    }
  }
  return names;
}

CLI::Option* add_names_option(CLI::App& command,
                              const std::string& name,
                              std::vector<std::string>& names,
                              const std::string& description) {
  const auto take = [&names](const std::vector<std::string>& texts) {
    names.clear();
    for (const std::string& text : texts) {
      const std::vector<std::string> part = split_names(text);
      names.insert(names.end(), part.begin(), part.end());
    }
  };
  return command.add_option_function<std::vector<std::string>>(name, take, description)
      ->type_name("NAME,...");
}

}  // namespace silvafit::cli
