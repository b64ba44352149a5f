// SPDX-License-Identifier: MIT
#include "silvafit/data/program.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "program/program_code.hpp"
#include "program/program_values.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::data {

struct Program::Code {
  std::vector<Input> inputs{};
  std::vector<Value> values{};
  BlockCode block{};
  std::size_t output_count = 0;
};

namespace {

void evaluate_scalars(const std::vector<Value>& values,
                      const std::vector<std::uint32_t>& needed,
                      std::span<const double* const> inputs,
                      std::vector<double>& scalars) {
  scalars.resize(values.size());
  const auto at = [&scalars](std::uint32_t number) {
    return number == kNone ? 0.0 : scalars[number];
  };
  for (const std::uint32_t number : needed) {
    const Value& value = values[number];
    if (value.operation == Operation::kConstant) {
      scalars[number] = value.constant;
    } else if (value.operation == Operation::kVariable) {
      scalars[number] = *inputs[value.input];
    } else {
      scalars[number] = apply(
          value.operation, at(value.operands[0]), at(value.operands[1]), at(value.operands[2]));
    }
  }
}

/// The registers of a workspace, at a multiple of kRegisterAlignment.
double* registers_of(std::vector<double>& memory, std::size_t count) {
  constexpr std::size_t kSpare = kRegisterAlignment / sizeof(double);
  // Never shrinks: memory that grows again is filled with zeros.
  memory.resize(std::max(memory.size(), count * kRegisterStride + kSpare));
  void* start = memory.data();
  std::size_t space = memory.size() * sizeof(double);
  return static_cast<double*>(
      std::align(kRegisterAlignment, count * kRegisterStride * sizeof(double), start, space));
}

}  // namespace

Program::Program(std::span<const Expression> outputs, std::vector<Input> inputs) {
  auto code = std::make_shared<Code>();
  code->inputs = std::move(inputs);
  ValueNumbering numbering(code->inputs);
  std::vector<std::uint32_t> numbers;
  for (const Expression& output : outputs) numbers.push_back(numbering.number(output.node()));
  code->values = numbering.values();
  code->block = block_code(code->values, numbers);
  code->output_count = outputs.size();
  code_ = std::move(code);
}

std::size_t Program::output_count() const { return code_ ? code_->output_count : 0; }

const std::vector<Program::Input>& Program::inputs() const {
  static const std::vector<Input> none;
  return code_ ? code_->inputs : none;
}

void Program::evaluate(std::span<const double* const> inputs,
                       std::size_t rows,
                       std::span<double* const> outputs,
                       Workspace& workspace) const {
  if (!code_ || inputs.size() != code_->inputs.size() || outputs.size() != code_->output_count) {
    throw UsageError("a program needs one pointer for each input and output");
  }
  evaluate_scalars(code_->values, code_->block.scalars, inputs, workspace.scalars);
  const BlockMemory memory{.registers = registers_of(workspace.registers, code_->block.registers),
                           .scalars = workspace.scalars.data(),
                           .columns = inputs.data(),
                           .outputs = outputs.data()};
  execute(code_->block.instructions, memory, rows);
}

namespace {

/// "01" and "1.0" match the number 1; text that is not a number matches no value.
std::vector<double> matches_of_number(std::span<const double> numbers, const TextMatch& match) {
  double wanted = kMissing;
  const bool is_number = parse_number(match.value, wanted);
  std::vector<double> values(numbers.size());
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (std::isnan(numbers[row])) {
      values[row] = kMissing;
    } else {
      values[row] = is_number && numbers[row] == wanted ? 1.0 : 0.0;
    }
  }
  return values;
}

}  // namespace

std::vector<double> variable_values(std::string_view variable, const Table& table) {
  TextMatch match;
  if (!is_text_match(variable, match)) {
    const std::span<const double> numbers = table.numbers(variable);
    return {numbers.begin(), numbers.end()};
  }
  if (table.is_numeric(match.column)) return matches_of_number(table.numbers(match.column), match);
  const TextColumn& column = table.text(match.column);
  const std::uint32_t wanted = column.code_of(match.value);
  std::vector<double> values(column.size());
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (column.is_missing(row)) {
      values[row] = kMissing;
    } else {
      values[row] = wanted != TextColumn::kMissingCode && column.code(row) == wanted ? 1.0 : 0.0;
    }
  }
  return values;
}

std::vector<double> evaluate(const Expression& expression, const Table& table) {
  std::vector<Program::Input> inputs;
  std::vector<std::vector<double>> columns;
  std::vector<const double*> pointers;
  for (const std::string& name : expression.variables()) {
    inputs.push_back({.name = name});
    columns.push_back(variable_values(name, table));
  }
  pointers.reserve(columns.size());
  for (const auto& column : columns) pointers.push_back(column.data());
  const Program program(std::span(&expression, 1), inputs);
  std::vector<double> result(table.rows());
  double* const output = result.data();
  Program::Workspace workspace;
  program.evaluate(pointers, result.size(), std::span(&output, 1), workspace);
  return result;
}

}  // namespace silvafit::data
