// SPDX-License-Identifier: MIT
#include "workflow/flow.hpp"

#include <filesystem>
#include <system_error>
#include <utility>
#include <variant>

#include "silvafit/base/error.hpp"
#include "silvafit/stand/prepared_table.hpp"

namespace silvafit::study {
namespace {

data::TableParts table_parts(
    const data::TableSource& source,
    const ReadingSettings& settings,
    std::size_t rows,
    const std::function<std::string(const std::vector<std::string>&)>& group) {
  const auto* const path = std::get_if<std::filesystem::path>(&source);
  if (path == nullptr)
    throw UsageError("only CSV files can be read in parts", {.column = "`stream`"});
  std::error_code ignored;
  if (std::filesystem::exists(*path, ignored) &&
      !std::filesystem::is_regular_file(*path, ignored)) {
    throw InputError("a pipe cannot be read twice; give a file", {.file = path->string()});
  }
  const data::CsvReader reader(source, settings.missing);
  const stand::InventoryOptions reading = inventory_options(settings);
  data::TablePartsOptions options{.missing = settings.missing, .rows = rows};
  options.fill_down = stand::filled_fields(reading, reader.header(), reader.file());
  const std::string name = group(reader.header());
  if (!name.empty()) {
    options.group = stand::fields_of(name, reader.header(), reading.columns, reader.file());
  }
  return {*path, options};
}

}  // namespace

stand::InventoryBatches inventory_flow(const data::TableSource& source,
                                       const ReadingSettings& settings,
                                       const stand::InventoryOptions& options,
                                       const FlowSettings& flow,
                                       const NoteCallback& note) {
  return stand::InventoryBatches(source,
                                 inventory_options(settings, options),
                                 flow.rows,
                                 flow.is_in_parts ? stand::BatchOf::kPlots : stand::BatchOf::kTable,
                                 flow.threads,
                                 note);
}

TableFlow::TableFlow(const data::TableSource& source,
                     const ReadingSettings& settings,
                     const FlowSettings& flow,
                     const std::function<std::string(const std::vector<std::string>&)>& group,
                     const NoteCallback& note)
    : ahead_([this] { return read(); }, flow.is_in_parts ? flow.threads : 1) {
  if (flow.is_in_parts) {
    parts_.emplace(table_parts(source, settings, flow.rows, group));
  } else {
    whole_ = source;
  }
  if (is_sorted() && note) note(stand::kSortedNote);
}

std::optional<data::TableSource> TableFlow::read() {
  if (!parts_) return std::exchange(whole_, std::nullopt);
  auto part = parts_->next();
  return part ? std::optional<data::TableSource>(std::move(part)) : std::nullopt;
}

}  // namespace silvafit::study
