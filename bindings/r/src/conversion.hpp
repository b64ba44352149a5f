// SPDX-License-Identifier: MIT
// Values of R as those of silvafit, and the reverse. To be called from R's thread only.
#pragma once

#include <cpp11/R.hpp>
#include <cpp11/list.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::r {

/// Columns of a data frame as a table: numbers and texts. The R functions have turned all other
/// classes into these.
data::Table table_of(const cpp11::list& columns);

/// A path, or a table in memory from a list of columns.
data::TableSource source_of(SEXP source);

/// A table as a list of columns, texts as character vectors.
cpp11::sexp columns_of(const data::Table& table);

/// Objects become named lists; arrays become vectors if all of their values are numbers, texts or
/// logical values, else lists; null is NULL, and NA in a vector.
cpp11::sexp value_of(const nlohmann::ordered_json& json);

cpp11::sexp value_of(const std::vector<std::string>& texts);
cpp11::sexp value_of(const std::string& text);
/// Numbers of rows from 0 as those of R.
cpp11::sexp row_numbers(const std::vector<std::size_t>& rows);

/// Arguments of R as JSON: named vectors and lists are objects, unless some elements have no name,
/// which are texts such as SM=60 then; matrices are lists of rows; one value is no list.
/// \throws UsageError that names the element of a list that is no such value, or is missing
nlohmann::ordered_json json_of(SEXP value);

std::string text_of(SEXP value);
std::vector<std::string> texts_of(SEXP value);
std::vector<double> numbers_of(SEXP value);

/// A named list from its elements.
class NamedList {
 public:
  void add(const std::string& name, const cpp11::sexp& value);
  cpp11::sexp list() const;

 private:
  std::vector<std::string> names_;
  std::vector<cpp11::sexp> values_;
};

}  // namespace silvafit::r
