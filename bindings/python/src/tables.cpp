// SPDX-License-Identifier: MIT
#include "tables.hpp"

#include <pybind11/stl.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <numeric>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "silvafit/base/error.hpp"

namespace silvafit::python {
namespace {

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Codes = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>;

template <class Value, int Flags>
std::span<const Value> view(const py::array_t<Value, Flags>& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

/// An empty text is a missing value, as in CSV files.
void append(std::string_view text, data::TextColumn& column) {
  text.empty() ? column.append_missing() : column.append(text);
}

/// \param codes  numbers of texts; negative for a missing value
data::TextColumn text_column(std::span<const std::int32_t> codes,
                             const std::vector<std::string>& texts) {
  data::TextColumn column;
  column.reserve(codes.size());
  for (const std::int32_t code : codes) {
    append(code < 0 ? "" : texts.at(static_cast<std::size_t>(code)), column);
  }
  return column;
}

/// \param columns  (name, numbers), (name, Text) or (name, (codes, texts))
TablePointer table_of(std::size_t rows, const py::list& columns) {
  data::Table table(rows);
  for (const auto& column : columns) {
    const auto [name, values] = column.cast<std::pair<std::string, py::object>>();
    if (py::isinstance<data::TextColumn>(values)) {
      table.set(name, values.cast<const data::TextColumn&>());
    } else if (py::isinstance<py::tuple>(values)) {
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

bool is_nan(PyObject* object) {
  return PyFloat_Check(object) != 0 && std::isnan(PyFloat_AS_DOUBLE(object));
}

/// Appends a text or a missing value. \return false if the object is neither
bool append(PyObject* object, data::TextColumn& column) {
  if (object == Py_None || is_nan(object)) {
    column.append_missing();
    return true;
  }
  if (PyUnicode_Check(object) == 0) return false;
  Py_ssize_t size = 0;
  const char* const bytes = PyUnicode_AsUTF8AndSize(object, &size);
  if (bytes == nullptr) throw py::error_already_set();
  append(std::string_view(bytes, static_cast<std::size_t>(size)), column);
  return true;
}

/// A column of objects that are all text, None or NaN; else None.
py::object text_of_objects(const py::array& objects) {
  if (objects.dtype().kind() != 'O' || objects.ndim() != 1) return py::none();
  auto column = std::make_shared<data::TextColumn>();
  column->reserve(static_cast<std::size_t>(objects.shape(0)));
  for (py::ssize_t row = 0; row < objects.shape(0); ++row) {
    PyObject* const object = *static_cast<PyObject* const*>(objects.data(row));
    if (object == nullptr || !append(object, *column)) return py::none();
  }
  return column->levels().empty() ? py::none() : py::cast(column);
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
  py::class_<data::TextColumn, std::shared_ptr<data::TextColumn>>(module, "Text")
      .def("__len__", &data::TextColumn::size);
  module.def("text", &text_of_objects, py::arg("objects"));
  module.def("table", &table_of, py::arg("rows"), py::arg("columns"));
}

}  // namespace silvafit::python
