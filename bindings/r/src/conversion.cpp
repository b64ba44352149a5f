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
  for (R_xlen_t i = 0; i < size; ++i) {
    SEXP text = STRING_ELT(values, i);
    if (text == NA_STRING) {
      column.append_missing();
    } else {
      column.append(view_of(text));
    }
  }
  return column;
}

data::TextColumn factor_column(SEXP values) {
  SEXP levels = Rf_getAttrib(values, R_LevelsSymbol);
  std::vector<std::string> labels;
  for (R_xlen_t i = 0; i < Rf_xlength(levels); ++i) {
    labels.emplace_back(view_of(STRING_ELT(levels, i)));
  }
  data::TextColumn column;
  const R_xlen_t size = Rf_xlength(values);
  column.reserve(static_cast<std::size_t>(size));
  const int* const codes = INTEGER(values);
  for (R_xlen_t i = 0; i < size; ++i) {
    if (codes[i] == NA_INTEGER) {
      column.append_missing();
    } else {
      column.append(labels.at(static_cast<std::size_t>(codes[i]) - 1));
    }
  }
  return column;
}

/// The largest integer of R and of the settings.
constexpr double kLargestInteger = std::numeric_limits<int>::max();

[[noreturn]] void refuse(const char* argument, const std::string& wanted) {
  throw UsageError("`" + std::string(argument) + "` has to be " + wanted);
}

std::vector<std::string> checked_texts(SEXP value, const char* argument) {
  if (TYPEOF(value) != STRSXP) refuse(argument, "text");
  for (R_xlen_t i = 0; i < Rf_xlength(value); ++i) {
    if (STRING_ELT(value, i) == NA_STRING) refuse(argument, "text without missing values");
  }
  return texts_of(value);
}

double checked_number(SEXP value, const char* argument) {
  const bool is_integer = TYPEOF(value) == INTSXP && !Rf_isFactor(value);
  if ((TYPEOF(value) != REALSXP && !is_integer) || Rf_xlength(value) != 1) {
    refuse(argument, "one number");
  }
  const double number = numbers_of(value).front();
  if (std::isnan(number)) refuse(argument, "a number, not a missing value");
  return number;
}

double checked_count(SEXP value, const char* argument, double largest) {
  const double number = checked_number(value, argument);
  if (number < 0 || number > largest || number != std::floor(number)) {
    const std::string end = std::to_string(static_cast<std::int64_t>(largest));
    refuse(argument, "a whole number from 0 to " + end);
  }
  return number;
}

/// Integers and logical values, whose missing value is the same.
std::vector<double> numbers_of_integers(const int* values, R_xlen_t size) {
  std::vector<double> result(static_cast<std::size_t>(size));
  std::transform(values, values + size, result.begin(), [](int value) {
    return value == NA_INTEGER ? data::kMissing : static_cast<double>(value);
  });
  return result;
}

void set_column(data::Table& table, const std::string& name, SEXP values) {
  const R_xlen_t size = Rf_xlength(values);
  switch (TYPEOF(values)) {
    case REALSXP:
      table.set(name, std::vector<double>(REAL(values), REAL(values) + size));
      return;
    case INTSXP:
      if (Rf_isFactor(values)) {
        table.set(name, factor_column(values));
      } else {
        table.set(name, numbers_of_integers(INTEGER(values), size));
      }
      return;
    case LGLSXP:
      table.set(name, numbers_of_integers(LOGICAL(values), size));
      return;
    case STRSXP:
      table.set(name, text_column(values));
      return;
    default:
      throw std::invalid_argument("column '" + name + "' has an unknown type");
  }
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

cpp11::sexp numbers_of_array(const ordered_json& array) {
  cpp11::sexp result = vector_of(REALSXP, array.size());
  double* place = REAL(result);
  for (const ordered_json& element : array) {
    *place++ = element.is_null() ? NA_REAL : element.get<double>();
  }
  return result;
}

cpp11::sexp texts_of_array(const ordered_json& array) {
  cpp11::sexp result = vector_of(STRSXP, array.size());
  R_xlen_t place = 0;
  for (const ordered_json& element : array) {
    SET_STRING_ELT(
        result,
        place++,
        element.is_null() ? NA_STRING : character(element.get_ref<const std::string&>()));
  }
  return result;
}

cpp11::sexp truths_of_array(const ordered_json& array) {
  cpp11::sexp result = vector_of(LGLSXP, array.size());
  int* place = LOGICAL(result);
  for (const ordered_json& element : array) {
    *place++ = element.is_null() ? NA_LOGICAL : static_cast<int>(element.get<bool>());
  }
  return result;
}

cpp11::sexp array_of(const ordered_json& array) {
  if (all_of_kind(array, [](const ordered_json& e) { return e.is_number(); })) {
    return numbers_of_array(array);
  }
  if (all_of_kind(array, [](const ordered_json& e) { return e.is_string(); })) {
    return texts_of_array(array);
  }
  if (all_of_kind(array, [](const ordered_json& e) { return e.is_boolean(); })) {
    return truths_of_array(array);
  }
  cpp11::sexp result = vector_of(VECSXP, array.size());
  R_xlen_t place = 0;
  for (const ordered_json& element : array) SET_VECTOR_ELT(result, place++, value_of(element));
  return result;
}

cpp11::sexp object_of(const ordered_json& object) {
  cpp11::sexp result = vector_of(VECSXP, object.size());
  cpp11::sexp names = vector_of(STRSXP, object.size());
  R_xlen_t place = 0;
  for (const auto& [name, value] : object.items()) {
    SET_VECTOR_ELT(result, place, value_of(value));
    SET_STRING_ELT(names, place++, character(name));
  }
  cpp11::safe[Rf_setAttrib](result, R_NamesSymbol, names);
  return result;
}

}  // namespace

data::Table table_of(const cpp11::list& columns) {
  const std::vector<std::string> names = texts_of(Rf_getAttrib(columns, R_NamesSymbol));
  data::Table table(columns.size() > 0 ? static_cast<std::size_t>(Rf_xlength(columns[0])) : 0);
  for (R_xlen_t i = 0; i < columns.size(); ++i) {
    set_column(table, names[static_cast<std::size_t>(i)], columns[i]);
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

cpp11::sexp value_of(const Eigen::VectorXd& values) {
  cpp11::sexp result = vector_of(REALSXP, static_cast<std::size_t>(values.size()));
  std::copy(values.data(), values.data() + values.size(), REAL(result));
  return result;
}

cpp11::sexp value_of(const Eigen::MatrixXd& values) {
  cpp11::sexp result = cpp11::safe[Rf_allocMatrix](
      REALSXP, static_cast<int>(values.rows()), static_cast<int>(values.cols()));
  std::copy(values.data(), values.data() + values.size(), REAL(result));
  return result;
}

cpp11::sexp value_of(const std::vector<double>& values) {
  cpp11::sexp result = vector_of(REALSXP, values.size());
  std::copy(values.begin(), values.end(), REAL(result));
  return result;
}

cpp11::sexp value_of(const std::vector<std::string>& texts) {
  cpp11::sexp result = vector_of(STRSXP, texts.size());
  for (std::size_t i = 0; i < texts.size(); ++i) {
    SET_STRING_ELT(result, static_cast<R_xlen_t>(i), character(texts[i]));
  }
  return result;
}

cpp11::sexp value_of(const std::string& text) { return value_of(std::vector<std::string>{text}); }

cpp11::sexp row_numbers(const std::vector<std::size_t>& rows, int first) {
  cpp11::sexp result = vector_of(INTSXP, rows.size());
  std::transform(rows.begin(), rows.end(), INTEGER(result), [&](std::size_t row) {
    return static_cast<int>(row) - first + 1;
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

double number_of(SEXP value) { return numbers_of(value).at(0); }

unsigned threads_of(SEXP value) { return static_cast<unsigned>(number_of(value)); }

std::map<std::string, double> named_numbers(SEXP value) {
  std::map<std::string, double> result;
  if (value == R_NilValue) return result;
  const std::vector<std::string> names = texts_of(Rf_getAttrib(value, R_NamesSymbol));
  const std::vector<double> numbers = numbers_of(value);
  for (std::size_t i = 0; i < names.size(); ++i) result[names[i]] = numbers.at(i);
  return result;
}

Arguments::Arguments(SEXP list) : list_(list) {
  const std::vector<std::string> names = texts_of(Rf_getAttrib(list, R_NamesSymbol));
  for (std::size_t i = 0; i < names.size(); ++i) places_[names[i]] = static_cast<R_xlen_t>(i);
}

bool Arguments::has(const char* name) const {
  const auto found = places_.find(name);
  return found != places_.end() && VECTOR_ELT(list_, found->second) != R_NilValue;
}

SEXP Arguments::operator[](const char* name) const { return VECTOR_ELT(list_, places_.at(name)); }

void Arguments::read(const char* name, std::string& value) const {
  if (!has(name)) return;
  const std::vector<std::string> texts = checked_texts((*this)[name], name);
  if (texts.size() > 1) refuse(name, "one text");
  value = texts.empty() ? std::string() : texts.front();
}
void Arguments::read(const char* name, std::vector<std::string>& value) const {
  if (has(name)) value = checked_texts((*this)[name], name);
}
void Arguments::read(const char* name, double& value) const {
  if (has(name)) value = checked_number((*this)[name], name);
}
void Arguments::read(const char* name, std::optional<double>& value) const {
  if (has(name)) value = checked_number((*this)[name], name);
}
void Arguments::read(const char* name, bool& value) const {
  if (!has(name)) return;
  SEXP truth = (*this)[name];
  if (TYPEOF(truth) != LGLSXP || Rf_xlength(truth) != 1 || LOGICAL(truth)[0] == NA_LOGICAL) {
    refuse(name, "TRUE or FALSE");
  }
  value = LOGICAL(truth)[0] == TRUE;
}
void Arguments::read(const char* name, std::size_t& value) const {
  // Larger whole numbers are no exact doubles.
  if (has(name)) value = static_cast<std::size_t>(checked_count((*this)[name], name, 0x1p53));
}
void Arguments::read(const char* name, int& value) const {
  if (has(name)) value = static_cast<int>(checked_count((*this)[name], name, kLargestInteger));
}
void Arguments::read(const char* name, unsigned& value) const {
  if (has(name)) value = static_cast<unsigned>(checked_count((*this)[name], name, kLargestInteger));
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
