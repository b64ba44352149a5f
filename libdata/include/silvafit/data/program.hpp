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

/// Several expressions that are compiled together. Common parts are computed once, parts without
/// columns once per call, and the others in blocks of rows that fit into the cache, with the vector
/// instructions of the processor.
///
/// The functions agree with those of C to a few units in the last place for all arguments,
/// including missing and infinite ones. On processors with fused multiply-add, a product and the
/// sum that it belongs to are rounded once together; results of processors with and without it may
/// differ in the last digit. The values of a row depend on this row only.
///
/// Thread safety: evaluate() is const and may run on several threads, each with its own workspace.
class Program {
 public:
  /// A column (one value per row) or a scalar (one value per call).
  struct Input {
    std::string name{};
    bool is_scalar = false;
  };

  /// Temporary values of one thread.
  struct Workspace {
    std::vector<double> registers{};
    std::vector<double> scalars{};
  };

  Program() = default;
  /// \throws UsageError if a variable of an expression is not an input
  Program(std::span<const Expression> outputs, std::vector<Input> inputs);

  std::size_t output_count() const;
  const std::vector<Input>& inputs() const;

  /// Computes all outputs for `rows` rows.
  /// \param inputs   one pointer per input: to `rows` values of a column, or one value of a scalar
  /// \param outputs  one pointer per output, to memory for `rows` values that overlaps with no
  ///                 other output or input
  void evaluate(std::span<const double* const> inputs,
                std::size_t rows,
                std::span<double* const> outputs,
                Workspace& workspace) const;

 private:
  struct Code;
  std::shared_ptr<const Code> code_;
};

/// The values of an expression of a table's columns, one per row. `column == "text"` compares a
/// text column.
/// \throws UsageError if a name is not a column of the table
std::vector<double> evaluate(const Expression& expression, const Table& table);

/// The values of a variable of an expression: a numeric column, or 1 and 0 for `column == "text"`
/// (NaN where the text is missing).
std::vector<double> variable_values(std::string_view variable, const Table& table);

}  // namespace silvafit::data
