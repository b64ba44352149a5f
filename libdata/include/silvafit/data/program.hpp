// SPDX-License-Identifier: MIT
// Expressions compiled for evaluation over blocks of rows.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "silvafit/data/expression.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::data {

/// Several expressions compiled together: common parts are computed once, parts without columns
/// once a call, the rest in blocks of rows that stay in cache, with the vector instructions of the
/// processor that runs it.
///
/// The functions are those of C to a few units in the last place, for every argument, missing
/// and infinite ones too. A product that is added or subtracted is rounded once, with its sum,
/// where the processor has fused multiply-add: two processors may differ in the last digit if one
/// has none. The values of a row depend on that row alone.
///
/// Thread safety: evaluate() is const and may run on several threads, each with a workspace of its
/// own.
class Program {
 public:
  /// An input is either a column (a value a row) or a scalar (one value a call).
  struct Input {
    std::string name{};
    bool is_scalar = false;
  };

  /// Scratch memory of one caller.
  struct Workspace {
    std::vector<double> registers{};
    std::vector<double> scalars{};
  };

  Program() = default;
  /// \throws UsageError if an expression has a variable that is no input
  Program(std::span<const Expression> outputs, std::vector<Input> inputs);

  std::size_t output_count() const;
  const std::vector<Input>& inputs() const;

  /// Computes all outputs for `rows` rows.
  /// \param inputs   a pointer per input: `rows` values of a column, one value of a scalar
  /// \param outputs  a pointer per output with room for `rows` values, apart from the inputs and
  /// from
  ///                 each other
  void evaluate(std::span<const double* const> inputs,
                std::size_t rows,
                std::span<double* const> outputs,
                Workspace& workspace) const;

 private:
  struct Code;
  std::shared_ptr<const Code> code_;
};

/// An expression of a table's columns, a value a row; `column == "text"` compares a text column.
/// \throws UsageError if a name is no column of the table
std::vector<double> evaluate(const Expression& expression, const Table& table);

/// The values of a variable of an expression: a numeric column, or 1 and 0 for `column == "text"`
/// (NaN where the text is missing).
std::vector<double> variable_values(std::string_view variable, const Table& table);

}  // namespace silvafit::data
