// SPDX-License-Identifier: MIT
// Bytes of an archive; or the XML of content.xml; or of a sheet, shared strings and styles, with
// zero bytes between them, because changes of packed bytes end at their checksums.
#include <algorithm>
#include <string>

#include "fuzz_target.hpp"
#include "silvafit/data/csv.hpp"
#include "workbook/archive.hpp"
#include "workbook/read_workbook.hpp"

namespace silvafit::fuzz {
namespace {

constexpr const char* kRelations =
    "<Relationships xmlns=\"r\"><Relationship Id=\"1\" Type=\"/officeDocument\" Target=\"w\"/>"
    "<Relationship Id=\"2\" Type=\"/worksheet\" Target=\"sheet\"/>"
    "<Relationship Id=\"3\" Type=\"/sharedStrings\" Target=\"strings\"/>"
    "<Relationship Id=\"4\" Type=\"/styles\" Target=\"styles\"/></Relationships>";
constexpr const char* kWorkbook =
    "<workbook xmlns:r=\"/relationships\"><sheets><sheet name=\"S\" "
    "r:id=\"2\"/></sheets></workbook>";

std::string excel_with(std::string_view bytes) {
  source::ArchiveParts parts{
      {"_rels/.rels", kRelations}, {"_rels/w.rels", kRelations}, {"w", kWorkbook}};
  for (const char* const part : {"sheet", "strings", "styles"}) {
    const std::size_t end = std::min(bytes.find('\0'), bytes.size());
    parts.emplace_back(part, end == 0 ? "<empty/>" : bytes.substr(0, end));
    bytes.remove_prefix(std::min(end + 1, bytes.size()));
  }
  return source::packed(parts);
}

}  // namespace

void read(std::string_view bytes) {
  const bool is_archive = bytes.starts_with("PK");
  const bool is_open_document = bytes.find("spreadsheet>") != std::string_view::npos;
  const source::SourceKind* const kind =
      source::kind_of_source(is_open_document ? "a.ods" : "a.xlsx");
  const std::string book = is_archive ? std::string(bytes)
                           : is_open_document
                               ? source::packed({{"content.xml", std::string(bytes)}})
                               : excel_with(bytes);
  data::read_csv_table(source::read_workbook(book, "a", *kind, {}).table);
}

}  // namespace silvafit::fuzz
