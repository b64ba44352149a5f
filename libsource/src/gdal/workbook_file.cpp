// SPDX-License-Identifier: MIT
#include "gdal/workbook_file.hpp"

#include <cpl_minixml.h>
#include <cpl_vsi.h>
#include <fmt/format.h>

#include <array>
#include <memory>
#include <string_view>

#include "gdal/session.hpp"
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
