// SPDX-License-Identifier: MIT
// Programs over the rows of data, with the sources of their inputs.
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/data/expression.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Rows per block of a program, so few that inputs and sums fit into the second-level cache.
constexpr Index kProgramRows = 512;

/// Several expressions compiled together.
/// \tparam Source  where the values of an input come from; `is_scalar()` says whether they are one
///   value for all rows
template <class Source>
struct RowProgram {
  data::Program program{};
  std::vector<Source> sources{};  ///< of the inputs, which come by name
  std::size_t outputs = 0;
};

/// \param source_of  gives the source of the variable of a name
template <class SourceOf>
auto row_program(const std::vector<data::Expression>& outputs, const SourceOf& source_of) {
  RowProgram<decltype(source_of(std::string()))> result{.outputs = outputs.size()};
  std::set<std::string> names;
  for (const data::Expression& output : outputs) {
    for (std::string& name : output.variables()) names.insert(std::move(name));
  }
  std::vector<data::Program::Input> inputs;
  for (const std::string& name : names) {
    result.sources.push_back(source_of(name));
    inputs.push_back({.name = name, .is_scalar = result.sources.back().is_scalar()});
  }
  result.program = data::Program(outputs, inputs);
  return result;
}

/// (rows x outputs) the values of a program.
/// \param inputs  of the program, each of all rows or a scalar
inline MatrixXd values_of(const data::Program& program,
                          const std::vector<const double*>& inputs,
                          Index rows) {
  MatrixXd result(rows, static_cast<Index>(program.output_count()));
  std::vector<double*> outputs;
  for (Index k = 0; k < result.cols(); ++k) outputs.push_back(result.col(k).data());
  data::Program::Workspace workspace;
  program.evaluate(inputs, static_cast<std::size_t>(rows), outputs, workspace);
  return result;
}

}  // namespace silvafit::fit
