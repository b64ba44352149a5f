// SPDX-License-Identifier: MIT
#include "csv_with_columns.hpp"

#include <algorithm>
#include <iostream>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/data/csv.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

void write_rows(const std::string& in, const AddedColumns& columns, std::ostream& stream) {
  data::CsvReader reader(in);
  const auto& header = reader.header();
  const auto replaced = std::ranges::find(header, columns.replaced) - header.begin();
  const char* separator = "";
  const auto write = [&](std::string_view field) {
    stream << separator << data::csv_field(field);
    separator = ",";
  };
  for (const std::string& name : header) write(name);
  for (const std::string& name : columns.names) write(name);
  stream << '\n';
  std::vector<std::string_view> fields;
  for (std::size_t row = 0; reader.next(fields); ++row) {
    separator = "";
    std::string own;
    if (replaced < std::ssize(fields) && columns.replacement) {
      own = columns.replacement(row);
      if (!own.empty()) fields[static_cast<std::size_t>(replaced)] = own;
    }
    for (const std::string_view field : fields) write(field);
    for (const std::string& field : columns.fields(row)) write(field);
    stream << '\n';
  }
}

}  // namespace

void write_with_columns(const std::string& in,
                        const std::string& out,
                        const AddedColumns& columns,
                        const CommonOptions& common) {
  if (!out.empty()) {
    AtomicFile file(out);
    write_rows(in, columns, file.stream());
    file.commit();
  } else if (!common.json) {
    write_rows(in, columns, std::cout);
    finish_standard_output();
  }
}

}  // namespace silvafit::cli
