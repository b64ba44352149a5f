// SPDX-License-Identifier: MIT
#include "workflow/parts_of_files.hpp"

#include <filesystem>
#include <system_error>
#include <variant>

#include "silvafit/base/error.hpp"
#include "silvafit/study/tree_table.hpp"

namespace silvafit::study {

data::TableParts table_parts(
    const data::TableSource& source,
    const ReadingSettings& settings,
    const std::function<std::string(const std::vector<std::string>&)>& group,
    std::size_t rows) {
  const auto* const path = std::get_if<std::filesystem::path>(&source);
  if (path == nullptr)
    throw UsageError("only CSV files can be read in parts", {.column = "`stream`"});
  std::error_code ignored;
  if (std::filesystem::exists(*path, ignored) &&
      !std::filesystem::is_regular_file(*path, ignored)) {
    throw InputError("a pipe cannot be read twice; give a file", {.file = path->string()});
  }
  const data::CsvReader reader(source, settings.missing);
  data::TablePartsOptions options{.missing = settings.missing, .rows = rows};
  options.fill_down = filled_fields(reader.header(), settings, reader.file());
  const std::string name = group(reader.header());
  if (!name.empty()) options.group = field_of(name, reader.header(), settings, reader.file());
  return {*path, options};
}

}  // namespace silvafit::study
