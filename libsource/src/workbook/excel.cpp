// SPDX-License-Identifier: MIT
// Workbooks of Excel.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <optional>
#include <utility>

#include "silvafit/base/words.hpp"
#include "silvafit/data/csv.hpp"
#include "workbook/excel_formats.hpp"
#include "workbook/sheets.hpp"
#include "workbook/xml.hpp"

namespace silvafit::source {
namespace {

std::optional<std::size_t> whole_number(std::string_view text) {
  std::size_t value = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_whole = status == std::errc() && end == text.data() + text.size();
  return is_whole ? std::optional(value) : std::nullopt;
}

bool is_true(std::string_view text) { return text == "1" || text == "true"; }

/// A relation of a part to another one.
struct Relation {
  std::string id{};
  std::string type{};  ///< the last word of its address: worksheet, sharedStrings
  std::string part{};
};

/// The name of a part from its address in a folder, such as ../styles.xml.
std::string part_at(const std::string& folder, std::string_view address) {
  const std::filesystem::path part = std::filesystem::path(folder) / address;
  return part.relative_path().lexically_normal().generic_string();
}

class RelationReader : public XmlHandler {
 public:
  explicit RelationReader(std::string folder) : folder_(std::move(folder)) {}
  void begin(const XmlTag& tag) override {
    if (tag.name != "Relationship" || tag.attribute("TargetMode") == "External") return;
    const std::string_view type = tag.attribute("Type");
    relations.push_back({.id = std::string(tag.attribute("Id")),
                         .type = std::string(type.substr(type.rfind('/') + 1)),
                         .part = part_at(folder_, tag.attribute("Target"))});
  }

  std::vector<Relation> relations{};

 private:
  std::string folder_;
};

/// The relations of a part; those of the archive for an empty name.
std::vector<Relation> relations_of(Archive& archive, const std::string& part) {
  const std::size_t name = part.rfind('/') + 1;  // 0 without a folder
  const std::string folder = part.substr(0, name);
  RelationReader reader(folder);
  read_xml(archive, folder + "_rels/" + part.substr(name) + ".rels", reader);
  return std::move(reader.relations);
}

const Relation* relation_of_type(const std::vector<Relation>& relations, std::string_view type) {
  const auto found = std::ranges::find(relations, type, &Relation::type);
  return found == relations.end() ? nullptr : &*found;
}

struct ListedSheet {
  std::string name{};
  std::string relation{};
  bool is_hidden = false;
};

class WorkbookReader : public XmlHandler {
 public:
  void begin(const XmlTag& tag) override {
    if (tag.name == "workbookPr") is_since_1904 = is_true(tag.attribute("date1904"));
    if (tag.name != "sheet" || tag.parent != "sheets") return;
    const std::string_view state = tag.attribute("state");
    sheets.push_back({.name = std::string(tag.attribute("name")),
                      .relation = std::string(tag.attribute("relationships|id")),
                      .is_hidden = state == "hidden" || state == "veryHidden"});
  }

  std::vector<ListedSheet> sheets{};
  bool is_since_1904 = false;
};

/// The number formats of cells.
class StyleReader : public XmlHandler {
 public:
  void begin(const XmlTag& tag) override {
    const int number = static_cast<int>(whole_number(tag.attribute("numFmtId")).value_or(0));
    if (tag.name == "numFmt" && tag.parent == "numFmts") {
      own_.emplace_back(number, format_of_code(tag.attribute("formatCode")));
    } else if (tag.name == "xf" && tag.parent == "cellXfs") {
      const auto found = std::ranges::find(own_, number, &std::pair<int, NumberFormat>::first);
      formats.push_back(found == own_.end() ? format_of_number(number) : found->second);
    }
  }

  std::vector<NumberFormat> formats{};

 private:
  std::vector<std::pair<int, NumberFormat>> own_{};
};

/// A character that XML cannot contain is written as _x000D_, four digits of its code.
std::string without_escapes(std::string text) {
  for (std::size_t at = 0; (at = text.find("_x", at)) != std::string::npos; ++at) {
    unsigned code = 0;
    const char* const digits = text.data() + at + 2;
    if (at + 7 > text.size() || text[at + 6] != '_') continue;
    if (std::from_chars(digits, digits + 4, code, 16).ptr != digits + 4) continue;
    // Others are parts of names; Excel writes control characters and underscores in this way.
    if (code < 0x80) text.replace(at, 7, 1, static_cast<char>(code));
  }
  return text;
}

/// The text of a rich or plain string, without the pronunciation of Japanese.
class StringCollector {
 public:
  void begin(const XmlTag& tag) {
    if (tag.name == "rPh") ++pronunciations_;
    is_text_ = tag.name == "t" && pronunciations_ == 0;
  }
  void end(std::string_view name) {
    if (name == "rPh") pronunciations_ -= 1;
    is_text_ = false;
  }
  void add(std::string_view piece) {
    if (is_text_) text_ += piece;
  }
  std::string take() { return without_escapes(std::exchange(text_, {})); }

 private:
  std::string text_{};
  bool is_text_ = false;
  int pronunciations_ = 0;
};

/// The texts that cells share.
class SharedStringReader : public XmlHandler {
 public:
  void begin(const XmlTag& tag) override {
    if (tag.name == "sst") announced_ = whole_number(tag.attribute("uniqueCount")).value_or(0);
    text_.begin(tag);
  }
  void end(std::string_view name) override {
    text_.end(name);
    if (name == "si") strings.push_back(text_.take());
  }
  void text(std::string_view piece) override { text_.add(piece); }

  /// Cells refer to texts by their order: if one is lost, the others are those of other cells.
  void require_all(const Archive& archive, const std::string& part) const {
    if (strings.size() >= announced_) return;
    archive.refuse(fmt::format("{} has {} of {} texts", part, strings.size(), announced_));
  }

  std::vector<std::string> strings{};

 private:
  std::size_t announced_ = 0;
  StringCollector text_{};
};

/// What the cells of all sheets refer to.
struct Shared {
  std::vector<std::string> strings{};
  std::vector<NumberFormat> formats{};
  bool is_since_1904 = false;
};

/// The cells of a sheet.
class SheetReader : public XmlHandler {
 public:
  SheetReader(const Archive& archive,
              const Shared& shared,
              const std::string& part,
              SheetText& sheet)
      : archive_(archive), shared_(shared), part_(part), sheet_(sheet) {}

  void begin(const XmlTag& tag) override;
  void end(std::string_view name) override;
  void text(std::string_view piece) override {
    if (is_value_) value_ += piece;
    string_.add(piece);
    // Rows and cells hold elements only; text there is the rest of tags that are lost.
    if (is_row_ && !holds_text_ && !is_blank(piece)) refuse("has text outside of its value");
  }
  void require_sheet() const {
    if (!has_data_) archive_.refuse(part_ + " has no sheet");
  }

 private:
  void require_known(const XmlTag& tag) const;
  void begin_row(const XmlTag& tag);
  void begin_cell(const XmlTag& tag);
  void end_cell();
  void add_number();
  void add(std::string_view text, CellKind kind) { sheet_.add(row_, column_ - 1, text, kind); }
  [[noreturn]] void refuse(std::string_view what) const {
    archive_.refuse(fmt::format("the cell {} of {} {}",
                                name_of_cell(row_, std::max<std::size_t>(column_, 1) - 1),
                                part_,
                                what));
  }

  const Archive& archive_;
  const Shared& shared_;
  std::string part_;
  SheetText& sheet_;
  bool has_data_ = false;
  bool is_row_ = false;
  bool is_cell_ = false;
  bool holds_text_ = false;  ///< the innermost element is one within a cell
  bool is_hidden_row_ = false;
  std::size_t row_ = 0;
  std::size_t column_ = 0;  // from 1
  std::size_t rows_before_ = 0;
  std::string type_{};
  std::string style_{};
  bool has_formula_ = false;
  bool has_value_ = false;
  bool is_value_ = false;
  std::string value_{};
  StringCollector string_{};
};

/// The elements of the parts of a sheet by ECMA-376, 18.3.1; another one is the rest of a damaged
/// name, and with it a row or cell would be lost.
void SheetReader::require_known(const XmlTag& tag) const {
  struct Content {
    std::string_view element{};
    std::string_view holds{};
  };
  static constexpr std::array<Content, 3> kContents{
      {{"sheetData", "row"}, {"row", "c extLst"}, {"c", "f v is extLst"}}};
  const auto* const content = std::ranges::find(kContents, tag.parent, &Content::element);
  if (content == kContents.end() || has_word(content->holds, tag.name)) return;
  archive_.refuse(fmt::format(
      "{} has an unknown element '{}' after the cell {}",
      part_,
      tag.name,
      name_of_cell(std::max<std::size_t>(row_, 1), std::max<std::size_t>(column_, 1) - 1)));
}

void SheetReader::begin(const XmlTag& tag) {
  require_known(tag);
  if (tag.name == "sheetData") has_data_ = true;
  if (tag.name == "row" && tag.parent == "sheetData") return begin_row(tag);
  if (tag.name == "c" && tag.parent == "row") return begin_cell(tag);
  if (!is_cell_) return;
  holds_text_ = true;
  string_.begin(tag);
  is_value_ = tag.name == "v" && tag.parent == "c";
  has_value_ = has_value_ || is_value_ || tag.name == "is";
  has_formula_ = has_formula_ || tag.name == "f";
}

void SheetReader::end(std::string_view name) {
  holds_text_ = false;
  if (!is_cell_) {
    if (name == "row") is_row_ = false;
    if (name == "row" && is_hidden_row_ && sheet_.rows() > rows_before_) sheet_.note_hidden_row();
    return;
  }
  string_.end(name);
  is_value_ = false;
  if (name == "c") end_cell();
}

void SheetReader::begin_row(const XmlTag& tag) {
  const std::string_view number = tag.attribute("r");
  const std::size_t row = number.empty() ? row_ + 1 : whole_number(number).value_or(0);
  if (row <= row_ || row > kMostRows) {
    archive_.refuse(fmt::format("{} has a row '{}' after row {}", part_, number, row_));
  }
  row_ = row;
  column_ = 0;
  is_row_ = true;
  is_hidden_row_ = is_true(tag.attribute("hidden"));
  rows_before_ = sheet_.rows();
}

void SheetReader::begin_cell(const XmlTag& tag) {
  const std::string_view name = tag.attribute("r");
  const std::size_t before = column_;
  if (name.empty()) {
    ++column_;
  } else {
    column_ = 0;
    for (std::size_t i = 0; i < name.size() && name[i] >= 'A' && name[i] <= 'Z' && i < 4; ++i) {
      column_ = 26 * column_ + static_cast<std::size_t>(name[i] - 'A' + 1);
    }
  }
  const bool is_own = name.empty() || (column_ > 0 && name == name_of_cell(row_, column_ - 1));
  if (!is_own || column_ <= before || column_ > kMostColumns) {
    archive_.refuse(
        fmt::format("{} has a cell '{}' at the wrong place in row {}", part_, name, row_));
  }
  type_ = tag.attribute("t");
  style_ = tag.attribute("s");
  value_.clear();
  has_formula_ = has_value_ = is_value_ = false;
  is_cell_ = true;
}

void SheetReader::end_cell() {
  is_cell_ = false;
  const std::string inline_text = string_.take();
  const bool is_text = type_ == "str" || type_ == "inlineStr";
  if (value_.empty() && !is_text) {
    // Programs that do not compute, such as Python's openpyxl, write formulas alone.
    if (has_formula_) add({}, CellKind::kMissingFormula);
    return;
  }
  if (is_text) {
    if (has_formula_ && !has_value_) return add({}, CellKind::kMissingFormula);
    return add(type_ == "str" ? without_escapes(value_) : inline_text, CellKind::kText);
  }
  if (type_ == "s") {
    const auto index = whole_number(value_);
    if (!index || *index >= shared_.strings.size()) refuse("refers to a text that is missing");
    return add(shared_.strings[*index], CellKind::kText);
  }
  if (type_ == "b") {
    if (value_ != "0" && value_ != "1") refuse("has a logical value that is neither 0 nor 1");
    return add(value_, CellKind::kLogical);
  }
  if (type_ == "e") return add(value_, CellKind::kError);
  if (type_ == "d") return add(value_, CellKind::kDate);
  if (!type_.empty() && type_ != "n") refuse("has an unknown type");
  add_number();
}

void SheetReader::add_number() {
  double value = 0.0;
  if (!data::parse_number(value_, value)) refuse("has a value that is not a number");
  const auto style = style_.empty() ? 0 : whole_number(style_);
  const bool has_format = style && *style < shared_.formats.size();
  if (!has_format && !style_.empty() && style_ != "0") refuse("has a style that is missing");
  const NumberFormat format = has_format ? shared_.formats[*style] : NumberFormat::kNumber;
  if (format == NumberFormat::kPercentage) return add(value_, CellKind::kPercentage);
  if (format != NumberFormat::kNumber) {
    const auto date = date_text(value, format, shared_.is_since_1904);
    if (date) return add(*date, CellKind::kDate);
  }
  add(value_, CellKind::kNumber);
}

Shared shared_parts(Archive& archive, const std::vector<Relation>& relations, bool is_since_1904) {
  Shared shared{.is_since_1904 = is_since_1904};
  if (const Relation* const strings = relation_of_type(relations, "sharedStrings")) {
    SharedStringReader reader;
    read_xml(archive, strings->part, reader);
    reader.require_all(archive, strings->part);
    shared.strings = std::move(reader.strings);
  }
  if (const Relation* const styles = relation_of_type(relations, "styles")) {
    StyleReader reader;
    read_xml(archive, styles->part, reader);
    shared.formats = std::move(reader.formats);
  }
  return shared;
}

}  // namespace

std::vector<Sheet> sheets_of_excel(Archive& archive,
                                   const std::string& wanted,
                                   SheetBudget& budget) {
  const std::vector<Relation> of_archive = relations_of(archive, "");
  const Relation* const document = relation_of_type(of_archive, "officeDocument");
  if (document == nullptr) archive.refuse("it has no workbook");
  WorkbookReader workbook;
  read_xml(archive, document->part, workbook);
  const std::vector<Relation> relations = relations_of(archive, document->part);
  const Shared shared = shared_parts(archive, relations, workbook.is_since_1904);
  std::vector<Sheet> sheets;
  for (const ListedSheet& listed : workbook.sheets) {
    const auto relation = std::ranges::find(relations, listed.relation, &Relation::id);
    if (relation == relations.end()) {
      archive.refuse(fmt::format("the part of the sheet '{}' is missing", listed.name));
    }
    // Others have charts, dialogs or macros.
    if (relation->type != "worksheet" || (!wanted.empty() && wanted != listed.name)) continue;
    sheets.push_back({.name = listed.name,
                      .is_hidden = listed.is_hidden,
                      .text = SheetText(place_of_sheet(archive.file(), listed.name), budget)});
    SheetReader reader(archive, shared, relation->part, sheets.back().text);
    read_xml(archive, relation->part, reader);
    reader.require_sheet();
  }
  return sheets;
}

}  // namespace silvafit::source
