// SPDX-License-Identifier: MIT
// Workbooks of OpenDocument, which LibreOffice writes.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <set>

#include "silvafit/data/csv.hpp"
#include "workbook/sheets.hpp"
#include "workbook/xml.hpp"

namespace silvafit::source {
namespace {

constexpr const char* kContent = "content.xml";
constexpr std::size_t kMostRepeats = std::size_t{1} << 40U;  // so that sums cannot overflow

/// How often a row, cell or blank is repeated.
std::size_t repeats(std::string_view text) {
  if (text.empty()) return 1;
  std::size_t value = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status == std::errc::result_out_of_range) return kMostRepeats;
  return status == std::errc() && end == text.data() + text.size() ? std::min(value, kMostRepeats)
                                                                   : 0;
}

/// A time of day such as PT12H30M05S as 12:30:05; none for another duration.
std::optional<std::string> clock_time(std::string_view duration) {
  if (!duration.starts_with("PT")) return std::nullopt;
  duration.remove_prefix(2);
  std::string text;
  for (const char unit : {'H', 'M', 'S'}) {
    const std::size_t end = duration.find(unit);
    std::string_view number = "0";
    if (end != std::string_view::npos) {
      number = duration.substr(0, end);
      duration.remove_prefix(end + 1);
    }
    number = number.substr(0, number.find_first_of(".,"));
    if (number.empty() || number.find_first_not_of("0123456789") != std::string_view::npos) {
      return std::nullopt;
    }
    text += fmt::format("{}{:0>2}", text.empty() ? "" : ":", number);
  }
  return duration.empty() ? std::optional(text) : std::nullopt;
}

/// Reads content.xml: first styles, among them those of hidden sheets, then the sheets.
class DocumentReader : public XmlHandler {
 public:
  DocumentReader(const Archive& archive, const std::string& wanted, SheetBudget& budget)
      : archive_(archive), wanted_(wanted), budget_(budget) {}

  void begin(const XmlTag& tag) override;
  void end(std::string_view name) override;
  void text(std::string_view piece) override;

  std::vector<Sheet> sheets{};
  bool has_spreadsheet = false;

 private:
  /// Equal cells beside each other.
  struct Cells {
    std::size_t column = 0;
    std::size_t count = 0;
    std::string text{};
    CellKind kind = CellKind::kText;
  };
  void begin_sheet(const XmlTag& tag);
  void begin_row(const XmlTag& tag);
  void begin_cell(const XmlTag& tag);
  void begin_in_cell(const XmlTag& tag);
  void end_cell();
  void end_row();
  void add(CellKind kind, std::string_view text);
  void add_number();
  [[noreturn]] void refuse(std::string_view what) const {
    archive_.refuse(fmt::format("the cell {} of the sheet '{}' in {} {}",
                                name_of_cell(row_ + 1, column_),
                                sheets.back().name,
                                kContent,
                                what));
  }

  [[noreturn]] void refuse_unknown(std::string_view element) const {
    archive_.refuse(fmt::format("the sheet '{}' in {} has an unknown element '{}' after row {}",
                                sheets.back().name,
                                kContent,
                                element,
                                row_));
  }

  const Archive& archive_;
  const std::string& wanted_;
  SheetBudget& budget_;
  std::string style_{};
  std::set<std::string, std::less<>> hidden_styles_{};
  bool is_sheet_ = false;
  bool is_row_ = false;
  bool is_cell_ = false;
  std::size_t row_ = 0;  // rows before the current one
  std::size_t row_repeats_ = 1;
  bool is_hidden_row_ = false;
  std::vector<Cells> cells_{};  // of the row, with content
  std::size_t column_ = 0;
  std::size_t column_repeats_ = 1;
  std::string type_{};
  std::string value_{};
  bool is_error_ = false;
  bool has_formula_ = false;
  std::string content_{};
  int paragraphs_ = 0;
  int foreign_ = 0;  // depth in comments and drawings
};

void DocumentReader::begin(const XmlTag& tag) {
  const bool is_drawing = is_sheet_ && !is_cell_ && (tag.name == "shapes" || tag.name == "forms");
  if (foreign_ > 0 || is_drawing) return void(++foreign_);
  if (is_cell_) return begin_in_cell(tag);
  if (tag.name == "spreadsheet") has_spreadsheet = true;
  if (tag.name == "style") style_ = tag.attribute("style:1.0|name");
  if (tag.name == "table-properties" && tag.attribute("table:1.0|display") == "false") {
    hidden_styles_.insert(style_);
  }
  // Tables elsewhere are copies of linked files.
  if (tag.name == "table" && tag.parent == "spreadsheet") return begin_sheet(tag);
  if (!is_sheet_) return;
  if (tag.name == "table-row") return begin_row(tag);
  const bool is_cell = tag.name == "table-cell" || tag.name == "covered-table-cell";
  // A damaged name would lose a row or a cell.
  if (is_row_ != is_cell) refuse_unknown(is_row_ ? tag.name : tag.parent);
  if (is_cell) begin_cell(tag);
}

void DocumentReader::end(std::string_view name) {
  if (foreign_ > 0) {
    --foreign_;
  } else if (is_cell_) {
    if (name == "p") paragraphs_ -= 1;
    if (name == "table-cell" || name == "covered-table-cell") end_cell();
  } else if (name == "table-row" && is_row_) {
    end_row();
  } else if (name == "table") {
    is_sheet_ = false;
  }
}

/// Rows hold cells, and cells paragraphs; other text there is the rest of tags that are lost.
void DocumentReader::text(std::string_view piece) {
  if (foreign_ > 0) return;
  if (is_cell_ && paragraphs_ > 0) {
    content_ += piece;
  } else if (is_row_ && !is_blank(piece)) {
    refuse("has text outside of its paragraphs");
  }
}

void DocumentReader::begin_sheet(const XmlTag& tag) {
  const std::string name(tag.attribute("table:1.0|name"));
  is_sheet_ = wanted_.empty() || wanted_ == name;
  row_ = 0;
  if (!is_sheet_) return;
  sheets.push_back({.name = name,
                    .is_hidden = hidden_styles_.contains(tag.attribute("table:1.0|style-name")),
                    .text = SheetText(place_of_sheet(archive_.file(), name), budget_)});
}

void DocumentReader::begin_row(const XmlTag& tag) {
  row_repeats_ = repeats(tag.attribute("table:1.0|number-rows-repeated"));
  const std::string_view visibility = tag.attribute("table:1.0|visibility");
  is_hidden_row_ = visibility == "collapse" || visibility == "filter";
  is_row_ = true;
  column_ = 0;
  cells_.clear();
}

void DocumentReader::begin_cell(const XmlTag& tag) {
  column_repeats_ = repeats(tag.attribute("table:1.0|number-columns-repeated"));
  type_ = tag.attribute("office:1.0|value-type");
  is_error_ = tag.attribute("calcext:1.0|value-type") == "error";
  has_formula_ = !tag.attribute("table:1.0|formula").empty();
  value_.clear();
  for (const char* const name : {"office:1.0|value",
                                 "office:1.0|date-value",
                                 "office:1.0|time-value",
                                 "office:1.0|boolean-value",
                                 "office:1.0|string-value"}) {
    if (value_.empty()) value_ = tag.attribute(name);
  }
  content_.clear();
  paragraphs_ = 0;
  is_cell_ = true;
}

void DocumentReader::begin_in_cell(const XmlTag& tag) {
  // Comments and drawings have paragraphs of their own.
  const bool is_own = tag.name == "p" || paragraphs_ > 0;
  if (!is_own || tag.name == "annotation" || tag.name == "ruby-text") {
    ++foreign_;
  } else if (tag.name == "p") {
    if (!content_.empty()) content_ += '\n';
    ++paragraphs_;
  } else if (tag.name == "s") {
    constexpr std::size_t kMostBlanks = 32767;  // of a cell
    content_.append(std::min(repeats(tag.attribute("text:1.0|c")), kMostBlanks), ' ');
  } else if (tag.name == "tab" || tag.name == "line-break") {
    content_ += ' ';
  }
}

void DocumentReader::end_cell() {
  is_cell_ = false;
  if (is_error_) {
    add(CellKind::kError, content_);
  } else if (type_ == "string" || type_.empty()) {
    if (has_formula_ && type_.empty() && content_.empty()) add(CellKind::kMissingFormula, {});
    const std::string_view text = value_.empty() ? content_ : value_;
    if (!text.empty()) add(CellKind::kText, text);
  } else if (type_ == "float" || type_ == "currency" || type_ == "percentage") {
    add_number();
  } else if (type_ == "boolean") {
    if (value_ != "true" && value_ != "false") refuse("has a logical value that cannot be read");
    add(CellKind::kLogical, value_ == "true" ? "1" : "0");
  } else if (type_ == "date") {
    add(CellKind::kDate, value_);
  } else if (type_ == "time") {
    add(CellKind::kDate, clock_time(value_).value_or(value_));
  } else {
    refuse("has an unknown type");
  }
  column_ = std::min(column_ + column_repeats_, kMostRepeats);
}

void DocumentReader::add_number() {
  double ignored = 0.0;
  if (!data::parse_number(value_, ignored)) refuse("has a value that is not a number");
  add(type_ == "percentage" ? CellKind::kPercentage : CellKind::kNumber, value_);
}

void DocumentReader::add(CellKind kind, std::string_view text) {
  if (column_repeats_ == 0 || column_ + column_repeats_ > kMostColumns) {
    refuse("is repeated more often than a sheet has columns");
  }
  cells_.push_back(
      {.column = column_, .count = column_repeats_, .text = std::string(text), .kind = kind});
}

void DocumentReader::end_row() {
  is_row_ = false;
  // Rows without content are repeated to the end of the sheet.
  if (!cells_.empty() && (row_repeats_ == 0 || row_ + row_repeats_ > kMostRows)) {
    refuse("is in a row that is repeated more often than a sheet has rows");
  }
  SheetText& sheet = sheets.back().text;
  const std::size_t most = cells_.empty() ? 0 : row_repeats_;
  for (std::size_t i = 0; i < most; ++i) {
    const std::size_t before = sheet.rows();
    for (const Cells& cells : cells_) {
      for (std::size_t k = 0; k < cells.count; ++k) {
        sheet.add(row_ + i + 1, cells.column + k, cells.text, cells.kind);
      }
    }
    if (is_hidden_row_ && sheet.rows() > before) sheet.note_hidden_row();
  }
  row_ = std::min(row_ + row_repeats_, kMostRepeats);
}

}  // namespace

std::vector<Sheet> sheets_of_open_document(Archive& archive,
                                           const std::string& wanted,
                                           SheetBudget& budget) {
  DocumentReader reader(archive, wanted, budget);
  read_xml(archive, kContent, reader);
  if (!reader.has_spreadsheet) archive.refuse(fmt::format("{} has no sheets", kContent));
  return std::move(reader.sheets);
}

}  // namespace silvafit::source
