// SPDX-License-Identifier: MIT
#include "workbook/read_workbook.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <span>

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
std::string list_of(std::span<const Sheet> sheets) {
  constexpr std::size_t kMost = 40;
  std::vector<std::string> texts;
  for (const Sheet& sheet : sheets.first(std::min(kMost, sheets.size()))) {
    texts.push_back(fmt::format(
        "'{}' ({} rows{})", sheet.name, sheet.text.rows(), sheet.is_hidden ? ", hidden" : ""));
  }
  if (sheets.size() > kMost) texts.push_back(fmt::format("{} more", sheets.size() - kMost));
  return fmt::format("{}", fmt::join(texts, ", "));
}

/// Leaves the sheets with rows, first the only visible one.
void keep_only_sheet(std::vector<Sheet>& sheets, const std::string& file) {
  std::erase_if(sheets, [](const Sheet& sheet) { return sheet.text.rows() == 0; });
  if (sheets.empty()) throw InputError("contains no sheet with rows", {.file = file});
  const auto visible = std::ranges::count(sheets, false, &Sheet::is_hidden);
  if (visible != 1) {
    throw InputError(fmt::format("has {} sheets; choose one with `layer` NAME: {}",
                                 visible == 0 ? "only hidden" : "several",
                                 list_of(sheets)),
                     {.file = file});
  }
  std::ranges::stable_sort(sheets, {}, &Sheet::is_hidden);
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
  std::vector<Sheet> sheets = sheets_of(archive, kind, layer, budget);
  archive.check_unread_parts();
  if (layer.empty()) {
    keep_only_sheet(sheets, file);
  } else if (sheets.empty()) {
    throw InputError(fmt::format("unknown sheet '{}'; available: {}",
                                 layer,
                                 list_of(sheets_of(archive, kind, {}, budget))),
                     {.file = file});
  }
  OpenedTable opened{.table = sheets.front().text.text(), .notes = sheets.front().text.notes()};
  if (sheets.size() > 1) {
    if (!layer.empty()) archive.refuse(fmt::format("it has two sheets '{}'", layer));
    opened.notes.push_back(
        fmt::format("hidden sheets are not read: {}", list_of(std::span(sheets).subspan(1))));
  }
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
