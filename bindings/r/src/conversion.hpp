// SPDX-License-Identifier: MIT
// Values of R as those of silvafit, and the reverse. To be called from R's thread only.
#pragma once

#include <Eigen/Core>
#include <cpp11/R.hpp>
#include <cpp11/list.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::r {

/// Columns of a data frame as a table: numbers, integers and logical values are numbers, factors
/// and texts are text. The R functions have turned all other classes into these.
data::Table table_of(const cpp11::list& columns);

/// A path, or a table in memory from a list of columns.
data::TableSource source_of(SEXP source);

/// A table as a list of columns, texts as character vectors.
cpp11::sexp columns_of(const data::Table& table);

/// Objects become named lists; arrays become vectors if all of their values are numbers, texts or
/// logical values, else lists; null is NULL, and NA in a vector.
cpp11::sexp value_of(const nlohmann::ordered_json& json);

cpp11::sexp value_of(const Eigen::VectorXd& values);
cpp11::sexp value_of(const Eigen::MatrixXd& values);
cpp11::sexp value_of(const std::vector<double>& values);
cpp11::sexp value_of(const std::vector<std::string>& texts);
cpp11::sexp value_of(const std::string& text);
/// Numbers of rows that count from 0, or from another number, as those of R.
cpp11::sexp row_numbers(const std::vector<std::size_t>& rows, int first = 0);

std::string text_of(SEXP value);
std::vector<std::string> texts_of(SEXP value);
std::vector<double> numbers_of(SEXP value);
double number_of(SEXP value);
unsigned threads_of(SEXP value);
/// A named vector of numbers.
std::map<std::string, double> named_numbers(SEXP value);

/// The elements of a named list that an R function has made.
class Arguments {
 public:
  explicit Arguments(SEXP list);
  bool has(const char* name) const;
  /// \throws std::out_of_range if the list has no such element
  SEXP operator[](const char* name) const;
  // Nothing happens if the list has no such element, or if it is NULL.
  // \throws UsageError that names the argument if its value has another type or range
  void read(const char* name, std::string& value) const;
  void read(const char* name, std::vector<std::string>& value) const;
  void read(const char* name, double& value) const;
  void read(const char* name, std::optional<double>& value) const;
  void read(const char* name, bool& value) const;
  void read(const char* name, std::size_t& value) const;
  void read(const char* name, int& value) const;
  void read(const char* name, unsigned& value) const;

 private:
  SEXP list_;
  std::map<std::string, R_xlen_t> places_;
};

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
