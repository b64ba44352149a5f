// SPDX-License-Identifier: MIT
#include "conversion.hpp"

#include <algorithm>
#include <cmath>
#include <cpp11/doubles.hpp>
#include <cpp11/strings.hpp>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>

#include "silvafit/base/error.hpp"

namespace silvafit::r {
namespace {

using nlohmann::ordered_json;

// Functions of R that may allocate or fail run in cpp11::safe, which turns R's jumps into C++
// exceptions.

std::string_view view_of(SEXP text) { return {cpp11::safe[Rf_translateCharUTF8](text)}; }

data::TextColumn text_column(SEXP values) {
  data::TextColumn column;
  const R_xlen_t size = Rf_xlength(values);
  column.reserve(static_cast<std::size_t>(size));
  // R has equal texts once, and rows of one group follow each other.
  SEXP last = NA_STRING;
  std::string_view view;
  for (R_xlen_t i = 0; i < size; ++i) {
    SEXP text = STRING_ELT(values, i);
    if (text == NA_STRING) {
      column.append_missing();
      continue;
    }
    if (text != last) view = view_of(text);
    last = text;
    column.append(view);
  }
  return column;
}

SEXP character(std::string_view text) {
  return cpp11::safe[Rf_mkCharLenCE](text.data(), static_cast<int>(text.size()), CE_UTF8);
}

/// Whether the elements are of a kind or null. Those of an array of nulls count as numbers.
bool all_of_kind(const ordered_json& array, bool (*is_kind)(const ordered_json&)) {
  return !array.empty() && std::ranges::all_of(array, [&](const ordered_json& element) {
    return element.is_null() || is_kind(element);
  });
}

cpp11::sexp vector_of(SEXPTYPE type, std::size_t size) {
  return cpp11::safe[Rf_allocVector](type, static_cast<R_xlen_t>(size));
}

cpp11::sexp array_of(const ordered_json& array) {
  const auto filled = [&](SEXPTYPE type, const auto& set) {
    cpp11::sexp result = vector_of(type, array.size());
    for (std::size_t i = 0; i < array.size(); ++i) set(result, static_cast<R_xlen_t>(i), array[i]);
    return result;
  };
  if (all_of_kind(array, [](const ordered_json& e) { return e.is_number(); })) {
    return filled(REALSXP, [](SEXP result, R_xlen_t i, const ordered_json& element) {
      REAL(result)[i] = element.is_null() ? NA_REAL : element.get<double>();
    });
  }
  if (all_of_kind(array, [](const ordered_json& e) { return e.is_string(); })) {
    return filled(STRSXP, [](SEXP result, R_xlen_t i, const ordered_json& element) {
      SEXP text = element.is_null() ? NA_STRING : character(element.get_ref<const std::string&>());
      SET_STRING_ELT(result, i, text);
    });
  }
  if (all_of_kind(array, [](const ordered_json& e) { return e.is_boolean(); })) {
    return filled(LGLSXP, [](SEXP result, R_xlen_t i, const ordered_json& element) {
      LOGICAL(result)[i] = element.is_null() ? NA_LOGICAL : static_cast<int>(element.get<bool>());
    });
  }
  return filled(VECSXP, [](SEXP result, R_xlen_t i, const ordered_json& element) {
    SET_VECTOR_ELT(result, i, value_of(element));
  });
}

cpp11::sexp object_of(const ordered_json& object) {
  NamedList result;
  for (const auto& [name, value] : object.items()) result.add(name, value_of(value));
  return result.list();
}

[[noreturn]] void refuse_missing() { throw UsageError("must not be a missing value"); }

/// An element of a vector or list.
ordered_json element_of(SEXP value, R_xlen_t i) {
  switch (TYPEOF(value)) {
    case VECSXP:
      return json_of(VECTOR_ELT(value, i));
    case LGLSXP:
      if (LOGICAL(value)[i] == NA_LOGICAL) refuse_missing();
      return LOGICAL(value)[i] == TRUE;
    case REALSXP:
      if (std::isnan(REAL(value)[i])) refuse_missing();
      return REAL(value)[i];
    case STRSXP:
      if (STRING_ELT(value, i) == NA_STRING) refuse_missing();
      return view_of(STRING_ELT(value, i));
    case INTSXP: {
      const int number = INTEGER(value)[i];
      if (number == NA_INTEGER) refuse_missing();
      if (!Rf_isFactor(value)) return number;
      return view_of(STRING_ELT(Rf_getAttrib(value, R_LevelsSymbol), number - 1));
    }
    default:
      throw UsageError("must be text, a number, TRUE or FALSE, or a list of these");
  }
}

/// The same; errors name the element.
ordered_json named_element(SEXP value, R_xlen_t i, const std::string& name) {
  try {
    return element_of(value, i);
  } catch (const UsageError& error) {
    throw UsageError(error.message(), {.column = "`" + name + "`"});
  }
}

ordered_json rows_of_matrix(SEXP matrix) {
  const R_xlen_t rows = Rf_nrows(matrix);
  ordered_json result = ordered_json::array();
  for (R_xlen_t i = 0; i < rows; ++i) {
    ordered_json row = ordered_json::array();
    for (R_xlen_t k = i; k < Rf_xlength(matrix); k += rows) row.push_back(element_of(matrix, k));
    result.push_back(std::move(row));
  }
  return result;
}

}  // namespace

data::Table table_of(const cpp11::list& columns) {
  const std::vector<std::string> names = texts_of(Rf_getAttrib(columns, R_NamesSymbol));
  data::Table table(columns.size() > 0 ? static_cast<std::size_t>(Rf_xlength(columns[0])) : 0);
  for (R_xlen_t i = 0; i < columns.size(); ++i) {
    const std::string& name = names[static_cast<std::size_t>(i)];
    if (TYPEOF(columns[i]) == STRSXP) {
      table.set(name, text_column(columns[i]));
    } else {
      table.set(name, numbers_of(columns[i]));
    }
  }
  return table;
}

data::TableSource source_of(SEXP source) {
  if (TYPEOF(source) == STRSXP) return std::filesystem::path(text_of(source));
  return std::make_shared<const data::Table>(table_of(cpp11::list(source)));
}

cpp11::sexp columns_of(const data::Table& table) {
  NamedList result;
  for (const std::string& name : table.names()) {
    if (table.is_numeric(name)) {
      const auto numbers = table.numbers(name);
      cpp11::sexp column = vector_of(REALSXP, numbers.size());
      std::transform(numbers.begin(), numbers.end(), REAL(column), [](double value) {
        return value == value ? value : NA_REAL;
      });
      result.add(name, column);
      continue;
    }
    const data::TextColumn& text = table.text(name);
    cpp11::sexp column = vector_of(STRSXP, text.size());
    for (std::size_t row = 0; row < text.size(); ++row) {
      SET_STRING_ELT(column,
                     static_cast<R_xlen_t>(row),
                     text.is_missing(row) ? NA_STRING : character(text[row]));
    }
    result.add(name, column);
  }
  return result.list();
}

cpp11::sexp value_of(const ordered_json& json) {
  switch (json.type()) {
    case ordered_json::value_t::object:
      return object_of(json);
    case ordered_json::value_t::array:
      return array_of(json);
    case ordered_json::value_t::string:
      return value_of(json.get_ref<const std::string&>());
    case ordered_json::value_t::boolean:
      return cpp11::safe[Rf_ScalarLogical](json.get<bool>());
    case ordered_json::value_t::null:
      return R_NilValue;
    default:
      return cpp11::safe[Rf_ScalarReal](json.get<double>());
  }
}

cpp11::sexp value_of(const std::vector<std::string>& texts) {
  cpp11::sexp result = vector_of(STRSXP, texts.size());
  for (std::size_t i = 0; i < texts.size(); ++i) {
    SET_STRING_ELT(result, static_cast<R_xlen_t>(i), character(texts[i]));
  }
  return result;
}

cpp11::sexp value_of(const std::string& text) { return value_of(std::vector<std::string>{text}); }

cpp11::sexp row_numbers(const std::vector<std::size_t>& rows) {
  cpp11::sexp result = vector_of(INTSXP, rows.size());
  std::transform(rows.begin(), rows.end(), INTEGER(result), [](std::size_t row) {
    return static_cast<int>(row) + 1;
  });
  return result;
}

std::vector<std::string> texts_of(SEXP value) {
  std::vector<std::string> result;
  if (value == R_NilValue) return result;
  if (TYPEOF(value) != STRSXP) throw std::invalid_argument("a character vector is needed");
  for (R_xlen_t i = 0; i < Rf_xlength(value); ++i) {
    result.emplace_back(view_of(STRING_ELT(value, i)));
  }
  return result;
}

std::string text_of(SEXP value) {
  const std::vector<std::string> texts = texts_of(value);
  return texts.empty() ? std::string() : texts.front();
}

std::vector<double> numbers_of(SEXP value) {
  if (value == R_NilValue) return {};
  const cpp11::sexp numbers = cpp11::safe[Rf_coerceVector](value, REALSXP);
  return {REAL(numbers), REAL(numbers) + Rf_xlength(numbers)};
}

ordered_json json_of(SEXP value) {
  if (value == R_NilValue) return nullptr;
  if (Rf_isMatrix(value) == TRUE) return rows_of_matrix(value);
  const R_xlen_t size = Rf_xlength(value);
  const std::vector<std::string> names = texts_of(Rf_getAttrib(value, R_NamesSymbol));
  if (names.empty()) {
    if (size == 1 && TYPEOF(value) != VECSXP) return element_of(value, 0);
    ordered_json list = ordered_json::array();
    for (R_xlen_t i = 0; i < size; ++i) list.push_back(element_of(value, i));
    return list;
  }
  const bool has_all = std::ranges::find(names, "") == names.end();
  ordered_json result = has_all ? ordered_json::object() : ordered_json::array();
  for (R_xlen_t i = 0; i < size; ++i) {
    const std::string& name = names[static_cast<std::size_t>(i)];
    const ordered_json element = named_element(value, i, name);
    if (has_all) {
      result[name] = element;
    } else {
      const std::string text = element.is_string() ? element.get<std::string>() : element.dump();
      result.push_back(name.empty() ? text : name + "=" + text);
    }
  }
  return result;
}

void NamedList::add(const std::string& name, const cpp11::sexp& value) {
  names_.push_back(name);
  values_.push_back(value);
}

cpp11::sexp NamedList::list() const {
  cpp11::sexp result = vector_of(VECSXP, values_.size());
  for (std::size_t i = 0; i < values_.size(); ++i) {
    SET_VECTOR_ELT(result, static_cast<R_xlen_t>(i), values_[i]);
  }
  cpp11::safe[Rf_setAttrib](result, R_NamesSymbol, value_of(names_));
  return result;
}

}  // namespace silvafit::r
