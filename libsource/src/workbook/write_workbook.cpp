// SPDX-License-Identifier: MIT
#include "workbook/write_workbook.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "silvafit/base/error.hpp"
#include "source_kind.hpp"
#include "workbook/archive.hpp"
#include "workbook/sheet_text.hpp"
#include "workbook/xml.hpp"

namespace silvafit::source {
namespace {

constexpr std::string_view kXml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

/// The first bytes of a text, without a part of a character of UTF-8.
std::string beginning_of(const std::string& text, std::size_t bytes) {
  std::size_t length = std::min(text.size(), bytes);
  while (length < text.size() && (text[length] & 0xC0) == 0x80) --length;
  return text.substr(0, length);
}

/// Names of sheets that Excel accepts: at most 31 characters without some signs, no two alike.
std::vector<std::string> names_of(const std::vector<Layer>& sheets) {
  constexpr std::size_t kLongest = 31;
  std::vector<std::string> names;
  for (const Layer& sheet : sheets) {
    std::string name = beginning_of(sheet.name, kLongest);
    const auto is_reserved = [](char c) {
      return std::string_view("[]:*?/\\").find(c) != std::string_view::npos;
    };
    std::ranges::replace_if(name, is_reserved, '_');
    const std::string whole = name;
    for (int number = 2; std::ranges::find(names, name) != names.end(); ++number) {
      const std::string end = fmt::format("_{}", number);
      name = beginning_of(whole, kLongest - end.size()).append(end);
    }
    names.push_back(name);
  }
  return names;
}

/// How a format writes rows and cells.
struct SheetFormat {
  void (*begin_row)(std::string& xml, std::size_t row);
  std::string_view end_row{};
  std::string_view empty_cell{};
  void (*number)(std::string& xml, const std::string& cell, double value);
  void (*text)(std::string& xml, const std::string& cell, std::string_view text);
};

/// A column of a table.
struct SheetColumn {
  std::span<const double> numbers{};
  const data::TextColumn* texts = nullptr;  ///< null for numbers
};

/// Appends the rows of a table, first its header.
void append_rows(std::string& xml, const data::Table& table, const SheetFormat& format) {
  const std::vector<std::string>& names = table.names();
  std::vector<SheetColumn> columns;
  format.begin_row(xml, 1);
  for (std::size_t i = 0; i < names.size(); ++i) {
    format.text(xml, name_of_cell(1, i), names[i]);
    table.is_numeric(names[i]) ? columns.push_back({.numbers = table.numbers(names[i])})
                               : columns.push_back({.texts = &table.text(names[i])});
  }
  xml += format.end_row;
  const auto append_cell =
      [&](const SheetColumn& column, const std::string& cell, std::size_t row) {
        if (column.texts == nullptr) {
          const double value = column.numbers[row];
          if (std::isfinite(value)) return format.number(xml, cell, value);
          if (!std::isnan(value)) return format.text(xml, cell, data::shortest(value));
        } else if (!column.texts->is_missing(row)) {
          return format.text(xml, cell, (*column.texts)[row]);
        }
        xml += format.empty_cell;
      };
  for (std::size_t row = 0; row < table.rows(); ++row) {
    format.begin_row(xml, row + 2);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      append_cell(columns[i], name_of_cell(row + 2, i), row);
    }
    xml += format.end_row;
  }
}

/// A text that looks like an escaped character, such as _x000D_, has its first sign escaped.
std::string with_escaped_escapes(std::string_view text) {
  std::string result(text);
  for (std::size_t i = 0; (i = result.find("_x", i)) != std::string::npos; ++i) {
    constexpr std::string_view kUnderscore = "x005F_";
    if (i + 6 >= result.size() || result[i + 6] != '_') continue;
    result.insert(i + 1, kUnderscore);
    i += kUnderscore.size();
  }
  return result;
}

constexpr SheetFormat kExcel{
    .begin_row = [](std::string& xml,
                    std::size_t row) { xml += fmt::format("<row r=\"{}\">", row); },
    .end_row = "</row>\n",
    .number =
        [](std::string& xml, const std::string& cell, double value) {
          xml += fmt::format("<c r=\"{}\"><v>{}</v></c>", cell, data::shortest(value));
        },
    .text =
        [](std::string& xml, const std::string& cell, std::string_view text) {
          xml += fmt::format(
              "<c r=\"{}\" t=\"inlineStr\"><is><t xml:space=\"preserve\">{}</t></is></c>",
              cell,
              xml_text(with_escaped_escapes(text)));
        }};

/// Readers take adjacent blanks of OpenDocument for one.
std::string with_blanks(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool is_kept = i > 0 && i + 1 < text.size() && text[i - 1] != ' ';
    if (text[i] == ' ' && !is_kept) {
      result += "<text:s/>";
    } else if (text[i] == '\n') {
      result += "<text:line-break/>";
    } else if (text[i] == '\t') {
      result += "<text:tab/>";
    } else {
      result += text[i];
    }
  }
  return result;
}

constexpr SheetFormat kOpenDocument{
    .begin_row = [](std::string& xml, std::size_t /*row*/) { xml += "<table:table-row>"; },
    .end_row = "</table:table-row>\n",
    .empty_cell = "<table:table-cell/>",
    .number =
        [](std::string& xml, const std::string& /*cell*/, double value) {
          xml += fmt::format(
              "<table:table-cell office:value-type=\"float\" office:value=\"{0}\"><text:p>{0}"
              "</text:p></table:table-cell>",
              data::shortest(value));
        },
    .text =
        [](std::string& xml, const std::string& /*cell*/, std::string_view text) {
          xml += fmt::format(
              "<table:table-cell office:value-type=\"string\"><text:p>{}</text:p>"
              "</table:table-cell>",
              with_blanks(xml_text(text)));
        }};

ArchiveParts parts_of_excel(const std::vector<Layer>& sheets) {
  constexpr std::string_view kPackage = "http://schemas.openxmlformats.org/package/2006/";
  constexpr std::string_view kRelations =
      "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
  constexpr std::string_view kMain = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
  constexpr std::string_view kType = "application/vnd.openxmlformats-officedocument.spreadsheetml";
  std::string types;
  std::string list;
  std::string relations;
  ArchiveParts parts(4);
  const std::vector<std::string> names = names_of(sheets);
  for (std::size_t i = 0; i < sheets.size(); ++i) {
    const std::string part = fmt::format("worksheets/sheet{}.xml", i + 1);
    types += fmt::format(
        "<Override PartName=\"/xl/{}\" ContentType=\"{}.worksheet+xml\"/>", part, kType);
    list += fmt::format(
        "<sheet name=\"{}\" sheetId=\"{}\" r:id=\"r{}\"/>", xml_text(names[i]), i + 1, i + 1);
    relations += fmt::format(
        "<Relationship Id=\"r{}\" Type=\"{}/worksheet\" Target=\"{}\"/>", i + 1, kRelations, part);
    std::string xml = fmt::format("{}<worksheet xmlns=\"{}\"><sheetData>\n", kXml, kMain);
    append_rows(xml, sheets[i].table, kExcel);
    parts.emplace_back("xl/" + part, xml + "</sheetData></worksheet>\n");
  }
  parts[0] = {
      "[Content_Types].xml",
      fmt::format("{}<Types xmlns=\"{}content-types\"><Default Extension=\"rels\" "
                  "ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>"
                  "<Override PartName=\"/xl/workbook.xml\" ContentType=\"{}.sheet.main+xml\"/>"
                  "{}</Types>\n",
                  kXml,
                  kPackage,
                  kType,
                  types)};
  parts[1] = {
      "_rels/.rels",
      fmt::format("{}<Relationships xmlns=\"{}relationships\"><Relationship Id=\"r1\" "
                  "Type=\"{}/officeDocument\" Target=\"xl/workbook.xml\"/></Relationships>\n",
                  kXml,
                  kPackage,
                  kRelations)};
  parts[2] = {
      "xl/workbook.xml",
      fmt::format("{}<workbook xmlns=\"{}\" xmlns:r=\"{}\"><sheets>{}</sheets></workbook>\n",
                  kXml,
                  kMain,
                  kRelations,
                  list)};
  parts[3] = {"xl/_rels/workbook.xml.rels",
              fmt::format("{}<Relationships xmlns=\"{}relationships\">{}</Relationships>\n",
                          kXml,
                          kPackage,
                          relations)};
  return parts;
}

ArchiveParts parts_of_open_document(const std::vector<Layer>& sheets) {
  constexpr std::string_view kNames = "urn:oasis:names:tc:opendocument:xmlns:";
  constexpr std::string_view kType = "application/vnd.oasis.opendocument.spreadsheet";
  std::string content = fmt::format(
      "{0}<office:document-content xmlns:office=\"{1}office:1.0\" xmlns:table=\"{1}table:1.0\" "
      "xmlns:text=\"{1}text:1.0\" office:version=\"1.3\"><office:body><office:spreadsheet>\n",
      kXml,
      kNames);
  const std::vector<std::string> names = names_of(sheets);
  for (std::size_t i = 0; i < sheets.size(); ++i) {
    content += fmt::format(
        "<table:table table:name=\"{}\"><table:table-column "
        "table:number-columns-repeated=\"{}\"/>\n",
        xml_text(names[i]),
        std::max<std::size_t>(1, sheets[i].table.names().size()));
    append_rows(content, sheets[i].table, kOpenDocument);
    content += "</table:table>\n";
  }
  content += "</office:spreadsheet></office:body></office:document-content>\n";
  return {{"mimetype", std::string(kType)},
          {"META-INF/manifest.xml",
           fmt::format("{0}<manifest:manifest xmlns:manifest=\"{1}manifest:1.0\" "
                       "manifest:version=\"1.3\"><manifest:file-entry manifest:full-path=\"/\" "
                       "manifest:media-type=\"{2}\"/><manifest:file-entry "
                       "manifest:full-path=\"content.xml\" manifest:media-type=\"text/xml\"/>"
                       "</manifest:manifest>\n",
                       kXml,
                       kNames,
                       kType)},
          {"content.xml", std::move(content)}};
}

void require_size(const Layer& sheet, const std::filesystem::path& file) {
  // Of a cell, in characters.
  constexpr std::size_t kLongestText = 32767;
  const auto refuse = [&](const std::string& what) {
    throw UsageError(
        fmt::format("the table {} has {}, more than a sheet can have; write CSV", sheet.name, what),
        {.file = file.string()});
  };
  if (sheet.table.rows() >= kMostRows) refuse(fmt::format("{} rows", sheet.table.rows()));
  const std::vector<std::string>& names = sheet.table.names();
  if (names.size() > kMostColumns) refuse(fmt::format("{} columns", names.size()));
  for (const std::string& name : names) {
    if (sheet.table.is_numeric(name)) continue;
    for (const std::string& text : sheet.table.text(name).levels()) {
      if (text.size() <= kLongestText) continue;
      refuse(fmt::format("a text of {} bytes in its column {}", text.size(), name));
    }
  }
}

}  // namespace

std::string workbook_of(const std::vector<Layer>& sheets, const std::filesystem::path& file) {
  for (const Layer& sheet : sheets) require_size(sheet, file);
  const bool is_excel = ending_of(file.string()) == "xlsx";
  return packed(is_excel ? parts_of_excel(sheets) : parts_of_open_document(sheets));
}

}  // namespace silvafit::source
