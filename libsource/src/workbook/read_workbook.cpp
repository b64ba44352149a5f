// SPDX-License-Identifier: MIT
#include "workbook/read_workbook.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "workbook/sheets.hpp"

namespace silvafit::source {
namespace {

/// Refuses what is no workbook, with the remedy.
void require_archive(std::string_view bytes, const std::string& file, const SourceKind& kind) {
  if (bytes.starts_with("\xD0\xCF\x11\xE0")) {
    throw InputError(
        "the workbook is encrypted, or in the format of Excel 97; open it, remove the password, "
        "and save it as .xlsx",
        {.file = file});
  }
  if (!bytes.starts_with("PK\x03\x04")) {
    throw InputError(
        fmt::format(
            "is not {}; save it again as .{}, or as CSV in UTF-8", kind.format, kind.ending),
        {.file = file});
  }
}

void refuse_encrypted(Archive& archive) {
  constexpr std::string_view kManifest = "META-INF/manifest.xml";
  if (!archive.has(kManifest)) return;
  std::string manifest;
  archive.read(kManifest, [&manifest](std::string_view block) { manifest += block; });
  if (manifest.find("encryption-data") == std::string::npos) return;
  throw InputError("the workbook is encrypted; open it and save it without a password",
                   {.file = archive.file()});
}

std::vector<Sheet> sheets_of(Archive& archive,
                             const SourceKind& kind,
                             const std::string& wanted,
                             SheetBudget& budget) {
  if (kind.ending != "ods") return sheets_of_excel(archive, wanted, budget);
  refuse_encrypted(archive);
  return sheets_of_open_document(archive, wanted, budget);
}

/// "'Trees' (49 rows), 'Codes' (12 rows, hidden)".
std::string list_of(const std::vector<Sheet>& sheets) {
  constexpr std::size_t kMost = 40;
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < std::min(kMost, sheets.size()); ++i) {
    texts.push_back(fmt::format("'{}' ({} rows{})",
                                sheets[i].name,
                                sheets[i].text.rows(),
                                sheets[i].is_hidden ? ", hidden" : ""));
  }
  if (sheets.size() > kMost) texts.push_back(fmt::format("{} more", sheets.size() - kMost));
  return fmt::format("{}", fmt::join(texts, ", "));
}

/// The only visible sheet with rows.
const Sheet& only_sheet(const std::vector<Sheet>& sheets,
                        const std::string& file,
                        std::vector<std::string>& notes) {
  std::vector<Sheet> with_rows = sheets;
  std::erase_if(with_rows, [](const Sheet& sheet) { return sheet.text.rows() == 0; });
  if (with_rows.empty()) throw InputError("contains no sheet with rows", {.file = file});
  const auto is_visible = [](const Sheet& sheet) {
    return !sheet.is_hidden && sheet.text.rows() > 0;
  };
  if (std::ranges::count_if(sheets, is_visible) != 1) {
    const bool are_hidden = std::ranges::none_of(sheets, is_visible);
    throw InputError(fmt::format("has {} sheets; choose one with `layer` NAME: {}",
                                 are_hidden ? "only hidden" : "several",
                                 list_of(with_rows)),
                     {.file = file});
  }
  std::erase_if(with_rows, is_visible);
  if (!with_rows.empty()) {
    notes.push_back(fmt::format("hidden sheets are not read: {}", list_of(with_rows)));
  }
  return *std::ranges::find_if(sheets, is_visible);
}

}  // namespace

std::string place_of_sheet(const std::string& file, const std::string& sheet) {
  return fmt::format("{} (sheet {})", file, sheet);
}

OpenedTable read_workbook(std::string_view bytes,
                          const std::string& file,
                          const SourceKind& kind,
                          const std::string& layer) {
  require_archive(bytes, file, kind);
  Archive archive(bytes, std::string(kind.format), file);
  SheetBudget budget = sheet_budget(archive.unpacked_bytes());
  const std::vector<Sheet> sheets = sheets_of(archive, kind, layer, budget);
  archive.check_unread_parts();
  if (!layer.empty() && sheets.empty()) {
    throw InputError(fmt::format("unknown sheet '{}'; available: {}",
                                 layer,
                                 list_of(sheets_of(archive, kind, {}, budget))),
                     {.file = file});
  }
  OpenedTable opened;
  const Sheet& sheet = layer.empty() ? only_sheet(sheets, file, opened.notes) : sheets.front();
  opened.table = sheet.text.text();
  for (std::string& note : sheet.text.notes()) opened.notes.push_back(std::move(note));
  return opened;
}

OpenedTable open_workbook(const std::string& name,
                          const SourceKind& kind,
                          const TableChoice& choice) {
  if (!choice.sql.empty()) {
    throw UsageError(
        "queries are for databases and GIS layers; choose a sheet of a workbook with "
        "`layer`",
        {.column = "`sql`"});
  }
  if (is_network_name(name)) {
    throw InputError("is a workbook of a network or an archive; save it on this computer",
                     {.file = name});
  }
  return read_workbook(read_file(name), name, kind, choice.layer);
}

}  // namespace silvafit::source
