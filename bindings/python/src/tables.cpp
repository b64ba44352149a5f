// SPDX-License-Identifier: MIT
#include "tables.hpp"

#include <pybind11/stl.h>

#include <cstdint>
#include <filesystem>
#include <numeric>
#include <span>
#include <string>

#include "silvafit/base/error.hpp"

namespace silvafit::python {
namespace {

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Codes = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>;

template <class Value, int Flags>
std::span<const Value> view(const py::array_t<Value, Flags>& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

/// \param codes  numbers of texts; negative for a missing value
data::TextColumn text_column(std::span<const std::int32_t> codes,
                             const std::vector<std::string>& texts) {
  data::TextColumn column;
  column.reserve(codes.size());
  for (const std::int32_t code : codes) {
    code < 0 ? column.append_missing() : column.append(texts.at(static_cast<std::size_t>(code)));
  }
  return column;
}

/// \param columns  (name, numbers) or (name, (codes, texts)); a negative code is a missing value
TablePointer table_of(std::size_t rows, const py::list& columns) {
  data::Table table(rows);
  for (const auto& column : columns) {
    const auto [name, values] = column.cast<std::pair<std::string, py::object>>();
    if (py::isinstance<py::tuple>(values)) {
      const auto [codes, texts] = values.cast<std::pair<Codes, std::vector<std::string>>>();
      table.set(name, text_column(view(codes), texts));
    } else {
      // A copy if the values are of another type or not contiguous.
      const auto array = values.cast<Numbers>();
      const auto numbers = view(array);
      table.set(name, std::vector<double>(numbers.begin(), numbers.end()));
    }
  }
  // Places in messages count rows from 1.
  std::vector<std::uint32_t> lines(rows);
  std::iota(lines.begin(), lines.end(), 1U);
  table.set_origin("", std::move(lines));
  return share(std::move(table));
}

/// Numbers are a view that keeps the table alive.
py::object numbers_of(const TablePointer& table, const std::string& name) {
  const std::span<const double> numbers = table->numbers(name);
  const py::array view(py::dtype::of<double>(),
                       {static_cast<py::ssize_t>(numbers.size())},
                       {static_cast<py::ssize_t>(sizeof(double))},
                       numbers.data(),
                       py::cast(table));
  view.attr("flags").attr("writeable") = false;
  return view;
}

py::object text_of(const data::TextColumn& column) {
  py::array_t<std::int32_t> codes(static_cast<py::ssize_t>(column.size()));
  std::int32_t* const target = codes.mutable_data();
  for (std::size_t row = 0; row < column.size(); ++row) {
    target[row] = column.is_missing(row) ? -1 : static_cast<std::int32_t>(column.code(row));
  }
  return py::make_tuple(codes, column.levels());
}

py::list columns_of(const TablePointer& table) {
  py::list columns;
  for (const std::string& name : table->names()) {
    columns.append(py::make_tuple(
        name, table->is_numeric(name) ? numbers_of(table, name) : text_of(table->text(name))));
  }
  return columns;
}

}  // namespace

data::TableSource source_of(const py::object& trees) {
  if (py::isinstance<data::Table>(trees)) {
    return std::shared_ptr<const data::Table>(trees.cast<TablePointer>());
  }
  return std::filesystem::path(trees.cast<std::string>());
}

void add_tables(py::module_& module) {
  py::class_<data::Table, TablePointer>(module, "Table")
      .def_property_readonly("rows", &data::Table::rows)
      .def_property_readonly("names", &data::Table::names)
      .def("columns", &columns_of);
  module.def("table", &table_of, py::arg("rows"), py::arg("columns"));
}

}  // namespace silvafit::python
