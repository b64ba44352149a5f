// SPDX-License-Identifier: MIT
#include "row_output.hpp"

#include <iostream>
#include <utility>

#include "silvafit/base/error.hpp"
#include "standard_output.hpp"
#include "table_output.hpp"

namespace silvafit::cli {

RowOutput::RowOutput(const std::string& out) {
  if (out.empty()) return;
  file_.emplace(out);
  stream_ = &file_->stream();
}

bool RowOutput::begin(std::string_view header, bool is_in_file_order) {
  if (stream_ == nullptr) return false;
  if (rows_) return true;
  *stream_ << header;
  rows_.emplace(*stream_, !is_in_file_order);
  return true;
}

void RowOutput::finish() {
  if (rows_) rows_->finish();
  if (file_) file_->commit();
  if (stream_ == &std::cout) finish_standard_output();
}

RowOutput file_or_standard_output(const std::string& out, const CommonOptions& common) {
  if (!out.empty()) return RowOutput(out);
  return RowOutput(common.json ? nullptr : &std::cout);
}

TableWithColumns::TableWithColumns(const std::string& out,
                                   bool is_in_parts,
                                   const study::ReadingSettings& reading,
                                   const CommonOptions& common)
    : out_(out),
      reading_(reading),
      common_(common),
      rows_(is_layer_output(out) ? RowOutput(&layer_) : file_or_standard_output(out, common)) {
  if (is_in_parts && is_layer_output(out)) {
    throw UsageError("writes CSV only, because a layer is written as a whole",
                     {.column = "--stream"});
  }
}

void TableWithColumns::write(const data::TableSource& rows,
                             const AddedColumns& columns,
                             bool is_in_file_order) {
  if (!rows_.begin("", is_in_file_order)) return;
  study::write_rows_with_columns(
      rows, columns, reading_, [&](std::size_t line, std::string_view record) {
        if (line > 0 || !std::exchange(has_header_, true)) rows_.add(line, record);
      });
}

void TableWithColumns::finish(const TreeTable& trees) {
  rows_.finish();
  if (!is_layer_output(out_)) return;
  write_trees(
      out_, table_of_csv(std::move(layer_).str(), out_, reading_), {}, trees.coordinates, common_);
}

}  // namespace silvafit::cli
