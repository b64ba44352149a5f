// SPDX-License-Identifier: MIT
// The nonlinear regression problems of NIST's Statistical Reference Datasets, in NIST's own format.
#pragma once

#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "reference.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::test {

struct NistProblem {
  std::string name;
  std::string formula;  ///< "y ~ ..." in b1, b2, ... and columns
  data::Table table;
  std::array<std::vector<double>, 2> starts{};
  std::vector<double> certified{};
  std::vector<double> standard_deviations{};
  double sum_of_squares = 0.0;
};

namespace nist {

inline std::vector<std::string> words(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> result;
  for (std::string word; stream >> word;) result.push_back(word);
  return result;
}

inline void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at)) {
    text.replace(at, from.size(), to);
    at += to.size();
  }
}

/// NIST's notation as ours: brackets are parentheses, ** is ^, and there is no error term.
inline std::string formula(std::string model) {
  std::erase_if(model, [](unsigned char byte) { return std::isspace(byte) != 0; });
  if (model.ends_with("+e")) model.resize(model.size() - 2);
  replace_all(model, "**", "^");
  replace_all(model, "[", "(");
  replace_all(model, "]", ")");
  replace_all(model, "arctan", "atan");
  replace_all(model, "log(y)=", "logy=");
  const std::size_t equals = model.find('=');
  return model.substr(0, equals) + " ~ " + model.substr(equals + 1);
}

/// "b1 = start start certified sd".
inline void read_coefficient(const std::vector<std::string>& row, NistProblem& problem) {
  problem.starts[0].push_back(std::stod(row[2]));
  problem.starts[1].push_back(std::stod(row[3]));
  problem.certified.push_back(std::stod(row[4]));
  problem.standard_deviations.push_back(std::stod(row[5]));
}

inline void read_data(std::istream& stream,
                      const std::vector<std::string>& columns,
                      NistProblem& problem) {
  std::vector<std::vector<double>> values(columns.size());
  for (std::string line; std::getline(stream, line);) {
    const std::vector<std::string> row = words(line);
    if (row.size() != columns.size()) continue;
    for (std::size_t k = 0; k < row.size(); ++k) values[k].push_back(std::stod(row[k]));
  }
  for (std::size_t k = 0; k < columns.size(); ++k) problem.table.set(columns[k], values[k]);
  std::vector<double> logs;
  for (const double y : problem.table.numbers("y")) logs.push_back(y > 0.0 ? std::log(y) : 0.0);
  if (problem.formula.rfind("logy", 0) == 0) problem.table.set("logy", logs);
}

}  // namespace nist

inline NistProblem read_nist(const std::string& name) {
  std::ifstream stream(reference_data("nist/" + name + ".dat"));
  NistProblem problem{.name = name, .formula = {}, .table = {}};
  std::string model;
  bool in_model = false;
  for (std::string line; std::getline(stream, line);) {
    const std::vector<std::string> row = nist::words(line);
    // The model's equation: from "y =" or "log[y] =" on, until it ends with "+ e".
    if (problem.certified.empty() && row.size() > 2 && row[1] == "=" &&
        (row[0] == "y" || row[0] == "log[y]")) {
      in_model = true;
    }
    if (in_model) model += line;
    if (in_model && !row.empty() && row.back() == "e") in_model = false;
    const bool is_coefficient = row.size() == 6 && row[0][0] == 'b' && row[1] == "=";
    if (is_coefficient) nist::read_coefficient(row, problem);
    if (line.rfind("Residual Sum of Squares:", 0) == 0) problem.sum_of_squares = std::stod(row[4]);
    const bool starts_data = row.size() > 2 && row[0] == "Data:" && row[1] == "y";
    if (starts_data) {
      problem.formula = nist::formula(model);
      nist::read_data(stream, {row.begin() + 1, row.end()}, problem);
    }
  }
  return problem;
}

inline const std::vector<std::string>& nist_names() {
  static const std::vector<std::string> names{
      "Misra1a", "Chwirut2", "Chwirut1", "Lanczos3", "Gauss1", "Gauss2",   "DanWood",
      "Misra1b", "Kirby2",   "Hahn1",    "Nelson",   "MGH17",  "Lanczos1", "Lanczos2",
      "Gauss3",  "Misra1c",  "Misra1d",  "Roszman1", "ENSO",   "MGH09",    "Thurber",
      "BoxBOD",  "Rat42",    "MGH10",    "Eckerle4", "Rat43",  "Bennett5"};
  return names;
}

}  // namespace silvafit::test
