// SPDX-License-Identifier: MIT
#include "gdal/workbook_file.hpp"

#include <cpl_minixml.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <string_view>

#include "gdal/session.hpp"
#include "gdal/workbook_grid.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::source {
namespace {

struct CloseFile {
  void operator()(VSILFILE* file) const { VSIFCloseL(file); }
};
using File = std::unique_ptr<VSILFILE, CloseFile>;

struct DestroyXml {
  void operator()(CPLXMLNode* node) const { CPLDestroyXMLNode(node); }
};
using Xml = std::unique_ptr<CPLXMLNode, DestroyXml>;

// The small parts of workbooks have a few kB.
constexpr std::size_t kLargestPart = std::size_t{16} << 20;

File open_file(const std::string& path) { return File(VSIFOpenL(path.c_str(), "rb")); }

/// A part of a ZIP archive; empty if there is none.
std::string part_of(const std::string& path, const std::string& part) {
  const KeptMessages no_messages;
  const File file = open_file(fmt::format("/vsizip/{{{}}}/{}", path, part));
  std::string text;
  if (!file) return text;
  std::array<char, 1 << 16> block{};
  while (text.size() < kLargestPart) {
    const std::size_t count = VSIFReadL(block.data(), 1, block.size(), file.get());
    if (count == 0) break;
    text.append(block.data(), count);
  }
  return text;
}

std::string first_bytes(const std::string& path) {
  std::string bytes(8, '\0');
  const File file = open_file(path);
  if (!file) return {};
  bytes.resize(VSIFReadL(bytes.data(), 1, bytes.size(), file.get()));
  return bytes;
}

Xml parse(const std::string& text) {
  Xml document(text.empty() ? nullptr : CPLParseXMLString(text.c_str()));
  if (document) CPLStripXMLNamespace(document.get(), nullptr, TRUE);
  return document;
}

/// The value of an attribute of the first element below a node whose other attribute has a value.
std::string attribute_where(const CPLXMLNode* parent,
                            const char* key,
                            const std::string& value,
                            const char* wanted) {
  if (parent == nullptr) return {};
  for (const CPLXMLNode* node = parent->psChild; node != nullptr; node = node->psNext) {
    if (node->eType != CXT_Element) continue;
    if (CPLGetXMLValue(node, key, "") == value) return CPLGetXMLValue(node, wanted, "");
  }
  return {};
}

/// The part of an Excel workbook that contains a sheet.
std::string part_of_sheet(const std::string& path, const std::string& sheet) {
  const KeptMessages no_messages;
  const Xml workbook = parse(part_of(path, "xl/workbook.xml"));
  const Xml relations = parse(part_of(path, "xl/_rels/workbook.xml.rels"));
  if (!workbook || !relations) return {};
  const std::string id =
      attribute_where(CPLGetXMLNode(workbook.get(), "=workbook.sheets"), "name", sheet, "id");
  std::string part =
      attribute_where(CPLGetXMLNode(relations.get(), "=Relationships"), "Id", id, "Target");
  if (part.empty()) return part;
  return part.starts_with('/') ? part.substr(1) : "xl/" + part;
}

/// Whether the XML of a cell has a formula and no value.
bool lacks_value(std::string_view cell) {
  const std::size_t formula = cell.find("<f");
  if (formula == std::string_view::npos) return false;
  const std::size_t value = cell.find("<v>");
  return cell.find("<is>") == std::string_view::npos &&
         (value == std::string_view::npos || cell.substr(value).starts_with("<v></v>"));
}

std::string name_of_cell(std::string_view cell) {
  const std::size_t begin = cell.find(" r=\"");
  if (begin == std::string_view::npos) return {};
  const std::string_view rest = cell.substr(begin + 4);
  return std::string(rest.substr(0, rest.find('"')));
}

/// Looks at each complete cell of a text; returns where the first incomplete one begins.
std::size_t look_at_cells(std::string_view text, FormulasWithoutValue& found) {
  std::size_t at = 0;
  for (;;) {
    const std::size_t begin = text.find("<c ", at);
    if (begin == std::string_view::npos) return at;
    const std::size_t tag_end = text.find('>', begin);
    if (tag_end == std::string_view::npos) return begin;
    at = tag_end + 1;
    if (text[tag_end - 1] == '/') continue;
    const std::size_t end = text.find("</c>", tag_end);
    if (end == std::string_view::npos) return begin;
    const std::string_view cell = text.substr(begin, end - begin);
    at = end;
    if (!lacks_value(cell)) continue;
    if (++found.count == 1) found.first = name_of_cell(cell);
  }
}

/// Whether a part has cells.
bool is_sheet(const std::string& part) {
  return part == "content.xml" || (part.starts_with("xl/worksheets/") && part.ends_with(".xml"));
}

/// The parts of real workbooks have up to about 50 times the bytes of their archive; those of zeros
/// have 1000 times as many.
void require_bounded_archive(const std::string& archive,
                             const CPLStringList& parts,
                             const std::string& path,
                             const std::string& place) {
  constexpr std::uintmax_t kFree = std::uintmax_t{64} << 20U;
  constexpr std::uintmax_t kMostRatio = 256;
  std::error_code unknown;
  const std::uintmax_t size = std::filesystem::file_size(path, unknown);
  std::uintmax_t total = 0;
  for (int i = 0; i < parts.size(); ++i) {
    VSIStatBufL status{};
    if (VSIStatL((archive + parts[i]).c_str(), &status) == 0) {
      total += static_cast<std::uintmax_t>(std::max<vsi_l_offset>(0, status.st_size));
    }
  }
  if (unknown || total <= kFree + kMostRatio * size) return;
  throw InputError(
      fmt::format("the workbook of {} bytes unpacks to {} bytes, more than {} times as "
                  "many; save its sheets as CSV in UTF-8",
                  size,
                  total,
                  kMostRatio),
      {.file = place});
}

bool is_folder(const std::string& name) {
  VSIStatBufL status{};
  return VSIStatL(name.c_str(), &status) == 0 && VSI_ISDIR(status.st_mode);
}

/// Reads a part of an archive to its end; false if it has another length or checksum than the
/// archive says.
bool is_read_whole(const std::string& name, GridScan* scan) {
  const KeptMessages messages;
  VSIStatBufL status{};
  const File file = open_file(name);
  if (!file || VSIStatL(name.c_str(), &status) != 0) return false;
  vsi_l_offset total = 0;
  std::vector<char> block(std::size_t{1} << 18);
  for (;;) {
    const std::size_t count = VSIFReadL(block.data(), 1, block.size(), file.get());
    if (count == 0) break;
    total += count;
    if (scan != nullptr) scan->add({block.data(), count});
  }
  return total == static_cast<vsi_l_offset>(status.st_size) && !messages.has_errors();
}

/// GDAL keeps a field of 16 bytes for each cell of the rectangle around all cells with content. In
/// a sheet without gaps each cell has more than 10 bytes of XML.
void require_bounded_sheet(const GridScan& scan, const std::string& place) {
  constexpr double kFree = 2e7;
  if (scan.is_unusual() && scan.bytes() > 0) {
    throw InputError(
        "the workbook is damaged, or has a form that spreadsheet programs do not write; open it in "
        "one and save it again",
        {.file = place});
  }
  if (scan.largest_grid() <= std::max(kFree, static_cast<double>(scan.bytes()))) return;
  throw InputError(
      fmt::format("a sheet has {} rows and {} columns, nearly all of them without content; delete "
                  "the cells that are far from the table, and save the workbook again",
                  scan.rows(),
                  scan.columns()),
      {.file = place});
}

}  // namespace

void require_readable_workbook(const std::string& path,
                               const SourceKind& kind,
                               const std::string& place) {
  const std::string bytes = first_bytes(path);
  const bool is_old_format = bytes.starts_with("\xD0\xCF\x11\xE0");
  const bool is_archive = bytes.starts_with("PK\x03\x04");
  if (kind.ending == "xls") return;
  if (is_old_format) {
    throw InputError(
        "the workbook is encrypted, or in the format of Excel 97; open it, remove the password, "
        "and save it as .xlsx",
        {.file = place});
  }
  if (!is_archive) {
    throw InputError(
        fmt::format(
            "is not {}; save it again as .{}, or as CSV in UTF-8", kind.format, kind.ending),
        {.file = place});
  }
  if (kind.ending == "ods" &&
      part_of(path, "META-INF/manifest.xml").find("encryption-data") != std::string::npos) {
    throw InputError("the workbook is encrypted; open it and save it without a password",
                     {.file = place});
  }
}

bool require_whole_workbook(const std::string& path,
                            const SourceKind& kind,
                            const std::string& place) {
  if (kind.ending == "xls") return false;
  const std::string archive = fmt::format("/vsizip/{{{}}}/", path);
  // With a slash at the end GDAL does not list the folders' content.
  const CPLStringList parts(VSIReadDirRecursive(archive.substr(0, archive.size() - 1).c_str()));
  require_bounded_archive(archive, parts, path, place);
  bool has_cells_behind_gap = false;
  for (int i = 0; i < parts.size(); ++i) {
    const std::string part = parts[i];
    if (is_folder(archive + part)) continue;
    GridScan scan;
    if (!is_read_whole(archive + part, is_sheet(part) ? &scan : nullptr)) {
      throw InputError(
          fmt::format("the workbook is damaged: {} cannot be read; restore it, or open it in the "
                      "program that made it and save it again",
                      part),
          {.file = place});
    }
    require_bounded_sheet(scan, place);
    has_cells_behind_gap = has_cells_behind_gap || scan.has_cells_behind_gap();
  }
  return has_cells_behind_gap;
}

FormulasWithoutValue formulas_without_value(const std::string& path, const std::string& sheet) {
  FormulasWithoutValue found;
  const std::string part = part_of_sheet(path, sheet);
  const File file = part.empty() ? File() : open_file(fmt::format("/vsizip/{{{}}}/{}", path, part));
  if (!file) return found;
  constexpr std::size_t kBlock = std::size_t{1} << 20;
  std::string text;
  for (;;) {
    const std::size_t kept = text.size();
    text.resize(kept + kBlock);
    const std::size_t count = VSIFReadL(text.data() + kept, 1, kBlock, file.get());
    text.resize(kept + count);
    text.erase(0, look_at_cells(text, found));
    // A cell has at most 32767 characters.
    if (count == 0 || text.size() > kLargestPart) return found;
  }
}

}  // namespace silvafit::source
