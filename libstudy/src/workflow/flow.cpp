// SPDX-License-Identifier: MIT
#include "workflow/flow.hpp"

#include <filesystem>
#include <system_error>
#include <utility>
#include <variant>

#include "silvafit/base/error.hpp"
#include "silvafit/study/tree_table.hpp"

namespace silvafit::study {
namespace {

void note_sorting(bool is_sorted, const NoteCallback& note) {
  if (is_sorted && note) note(kSortedNote);
}

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
  data::TablePartsOptions options{.missing = settings.missing, .rows = rows};
  options.fill_down =
      stand::filled_fields(inventory_options(settings), reader.header(), reader.file());
  const std::string name = group(reader.header());
  if (!name.empty()) options.group = fields_of(name, reader.header(), settings, reader.file());
  return {*path, options};
}

}  // namespace

InventoryFlow::InventoryFlow(const data::TableSource& source,
                             const ReadingSettings& settings,
                             const stand::InventoryOptions& options,
                             const FlowSettings& flow,
                             NoteCallback note)
    : batches_(source,
               inventory_options(settings, options),
               flow.rows,
               flow.is_in_parts ? stand::BatchOf::kPlots : stand::BatchOf::kTable),
      is_in_parts_(flow.is_in_parts),
      note_(std::move(note)),
      ahead_([this] { return batches_.next(); }, flow.is_in_parts ? flow.threads : 1) {
  if (batches_.is_sorted()) notes_.emplace_back(kSortedNote);
  note_sorting(batches_.is_sorted(), note_);
}

std::optional<stand::CheckedInventory> InventoryFlow::next() {
  std::optional<stand::CheckedInventory> part = ahead_.next();
  const bool is_complete = is_in_parts_ ? !part : part.has_value();
  if (!is_complete || std::exchange(is_finished_, true)) return part;
  const std::vector<std::string> notes = is_in_parts_ ? batches_.notes() : part->notes;
  recognized_ = is_in_parts_ ? batches_.recognized() : part->recognized;
  give_notes(notes, note_);
  notes_.insert(notes_.end(), notes.begin(), notes.end());
  const std::string excluded = batches_.excluded();
  if (!excluded.empty() && note_) note_(excluded);
  return part;
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
  note_sorting(is_sorted(), note);
}

std::optional<data::TableSource> TableFlow::read() {
  if (!parts_) return std::exchange(whole_, std::nullopt);
  auto part = parts_->next();
  return part ? std::optional<data::TableSource>(std::move(part)) : std::nullopt;
}

}  // namespace silvafit::study
