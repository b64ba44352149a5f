// SPDX-License-Identifier: MIT
#include "csv_with_columns.hpp"

#include <iostream>
#include <sstream>
#include <utility>

#include "silvafit/base/error.hpp"
#include "standard_output.hpp"
#include "table_output.hpp"

namespace silvafit::cli {
namespace {

study::RecordSink sink_of(std::ostream& stream) {
  return [&stream](std::size_t, std::string_view record) { stream << record; };
}

}  // namespace

void write_with_columns(const TreeTable& in,
                        const std::string& out,
                        const AddedColumns& columns,
                        const study::ReadingSettings& reading,
                        const CommonOptions& common) {
  if (is_layer_output(out)) {
    std::ostringstream text;
    study::write_rows_with_columns(in.table, columns, reading, sink_of(text));
    write_trees(out, table_of_csv(std::move(text).str(), out, reading), {}, in.coordinates, common);
  } else if (!out.empty()) {
    AtomicFile file(out);
    study::write_rows_with_columns(in.table, columns, reading, sink_of(file.stream()));
    file.commit();
  } else if (!common.json) {
    study::write_rows_with_columns(in.table, columns, reading, sink_of(std::cout));
    finish_standard_output();
  }
}

PartsWithColumns::PartsWithColumns(const std::string& out,
                                   const study::ReadingSettings& reading,
                                   const CommonOptions& common)
    : reading_(reading) {
  if (is_layer_output(out)) {
    throw UsageError("writes CSV only, because a layer is written as a whole",
                     {.column = "--stream"});
  }
  if (!out.empty()) file_.emplace(out);
  if (file_) {
    stream_ = &file_->stream();
  } else if (!common.json) {
    stream_ = &std::cout;
  }
}

void PartsWithColumns::write(const data::TableSource& rows,
                             const AddedColumns& columns,
                             bool is_in_file_order) {
  if (stream_ == nullptr) return;
  const bool is_first = !rows_;
  if (is_first) rows_.emplace(*stream_, !is_in_file_order);
  study::write_rows_with_columns(
      rows, columns, reading_, [&](std::size_t line, std::string_view record) {
        if (line > 0 || is_first) rows_->add(line, record);
      });
}

void PartsWithColumns::finish() {
  if (rows_) rows_->finish();
  if (file_) file_->commit();
  if (stream_ == &std::cout) finish_standard_output();
}

}  // namespace silvafit::cli
