// SPDX-License-Identifier: MIT
#include "silvafit/data/program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "expression_node.hpp"
#include "program_block.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::data {
namespace {

constexpr std::uint32_t kNone = 0xffffffffU;

/// A value of the program before storage is assigned: an operation on earlier values.
struct Value {
  Operation operation = Operation::kConstant;
  std::array<std::uint32_t, 3> operands{kNone, kNone, kNone};
  bool is_scalar = true;
  std::uint32_t input = kNone;  ///< for variables
  double constant = 0.0;
};

bool commutes(Operation operation) {
  return operation == Operation::kAdd || operation == Operation::kMultiply ||
         operation == Operation::kEqual;
}

/// Numbers the values of several graphs so that equal parts get one number.
class ValueNumbering {
 public:
  explicit ValueNumbering(const std::vector<Program::Input>& inputs) : inputs_(inputs) {}

  std::uint32_t number(const NodePointer& node) {
    const auto known = by_node_.find(node.get());
    if (known != by_node_.end()) return known->second;
    const std::uint32_t result = find_or_add(described(node));
    by_node_.emplace(node.get(), result);
    return result;
  }

  const std::vector<Value>& values() const { return values_; }

 private:
  Value described(const NodePointer& node) {
    Value value{.operation = node->operation};
    if (node->operation == Operation::kConstant) {
      value.constant = node->value;
    } else if (node->operation == Operation::kVariable) {
      value.input = input_number(node->name);
      value.is_scalar = inputs_[value.input].is_scalar;
    } else {
      for (int i = 0; i < node->operand_count; ++i) {
        value.operands[i] = number(node->operands[i]);
        value.is_scalar = value.is_scalar && values_[value.operands[i]].is_scalar;
      }
      if (commutes(value.operation) && value.operands[0] > value.operands[1]) {
        std::swap(value.operands[0], value.operands[1]);
      }
    }
    return value;
  }

  std::uint32_t input_number(const std::string& name) const {
    const auto found = std::ranges::find(inputs_, name, &Program::Input::name);
    if (found == inputs_.end()) {
      throw UsageError(fmt::format("'{}' is neither a column nor a parameter", name));
    }
    return static_cast<std::uint32_t>(found - inputs_.begin());
  }

  std::uint32_t find_or_add(const Value& value) {
    const Key key{
        value.operation, value.operands, value.input, std::bit_cast<std::uint64_t>(value.constant)};
    const auto [entry, is_new] =
        by_key_.try_emplace(key, static_cast<std::uint32_t>(values_.size()));
    if (is_new) values_.push_back(value);
    return entry->second;
  }

  using Key = std::tuple<Operation, std::array<std::uint32_t, 3>, std::uint32_t, std::uint64_t>;
  const std::vector<Program::Input>& inputs_;
  std::vector<Value> values_;
  std::unordered_map<const ExpressionNode*, std::uint32_t> by_node_;
  std::map<Key, std::uint32_t> by_key_;
};

}  // namespace

struct Program::Code {
  std::vector<Input> inputs{};
  std::vector<Value> values{};
  std::vector<BlockInstruction> block{};
  std::vector<BlockOperand> outputs{};
  std::size_t registers = 0;
};

namespace {

/// Assigns registers to the values that differ by row; a register is free again after its last use.
class RegisterAllocation {
 public:
  RegisterAllocation(const std::vector<Value>& values, const std::vector<std::uint32_t>& outputs)
      : values_(values), last_use_(values.size(), 0), place_(values.size(), kNone) {
    for (std::uint32_t i = 0; i < values.size(); ++i) {
      for (const std::uint32_t operand : values[i].operands) {
        if (operand != kNone) last_use_[operand] = i;
      }
    }
    for (const std::uint32_t output : outputs) {
      last_use_[output] = static_cast<std::uint32_t>(values.size());
    }
  }

  std::vector<BlockInstruction> instructions() {
    std::vector<BlockInstruction> code;
    for (std::uint32_t i = 0; i < values_.size(); ++i) {
      const Value& value = values_[i];
      if (value.is_scalar || value.operation == Operation::kVariable) continue;
      BlockInstruction instruction{.operation = value.operation};
      for (std::size_t k = 0; k < 3; ++k) {
        if (value.operands[k] != kNone) instruction.operands[k] = operand(value.operands[k]);
      }
      release_operands(i);
      place_[i] = take();
      instruction.target = place_[i];
      code.push_back(instruction);
    }
    return code;
  }

  BlockOperand operand(std::uint32_t number) const {
    const Value& value = values_[number];
    if (value.is_scalar) return {.kind = BlockOperand::kScalar, .index = number};
    if (value.operation == Operation::kVariable) {
      return {.kind = BlockOperand::kColumn, .index = value.input};
    }
    return {.kind = BlockOperand::kRegister, .index = place_[number]};
  }

  std::size_t count() const { return count_; }

 private:
  void release_operands(std::uint32_t user) {
    const auto& operands = values_[user].operands;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t number = operands[k];
      if (number == kNone || place_[number] == kNone || last_use_[number] != user) continue;
      const bool repeated =
          std::find(operands.begin(), operands.begin() + k, number) != operands.begin() + k;
      if (!repeated) free_.push_back(place_[number]);
    }
  }

  std::uint32_t take() {
    if (free_.empty()) return static_cast<std::uint32_t>(count_++);
    const std::uint32_t place = free_.back();
    free_.pop_back();
    return place;
  }

  const std::vector<Value>& values_;
  std::vector<std::uint32_t> last_use_;
  std::vector<std::uint32_t> place_;
  std::vector<std::uint32_t> free_;
  std::size_t count_ = 0;
};

void evaluate_scalars(const std::vector<Value>& values,
                      std::span<const double* const> inputs,
                      std::vector<double>& scalars) {
  scalars.resize(values.size());
  const auto at = [&scalars](std::uint32_t number) {
    return number == kNone ? 0.0 : scalars[number];
  };
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Value& value = values[i];
    if (!value.is_scalar) continue;
    if (value.operation == Operation::kConstant) {
      scalars[i] = value.constant;
    } else if (value.operation == Operation::kVariable) {
      scalars[i] = *inputs[value.input];
    } else {
      scalars[i] = apply(
          value.operation, at(value.operands[0]), at(value.operands[1]), at(value.operands[2]));
    }
  }
}

}  // namespace

Program::Program(std::span<const Expression> outputs, std::vector<Input> inputs) {
  auto code = std::make_shared<Code>();
  code->inputs = std::move(inputs);
  ValueNumbering numbering(code->inputs);
  std::vector<std::uint32_t> numbers;
  for (const Expression& output : outputs) numbers.push_back(numbering.number(output.node()));
  code->values = numbering.values();
  RegisterAllocation allocation(code->values, numbers);
  code->block = allocation.instructions();
  for (const std::uint32_t number : numbers) code->outputs.push_back(allocation.operand(number));
  code->registers = allocation.count();
  code_ = std::move(code);
}

std::size_t Program::output_count() const { return code_ ? code_->outputs.size() : 0; }

const std::vector<Program::Input>& Program::inputs() const {
  static const std::vector<Input> none;
  return code_ ? code_->inputs : none;
}

void Program::evaluate(std::span<const double* const> inputs,
                       std::size_t rows,
                       std::span<double* const> outputs,
                       Workspace& workspace) const {
  if (!code_ || inputs.size() != code_->inputs.size() || outputs.size() != code_->outputs.size()) {
    throw UsageError("a program needs a pointer for each of its inputs and outputs");
  }
  evaluate_scalars(code_->values, inputs, workspace.scalars);
  workspace.registers.resize(code_->registers * kBlockRows);
  BlockMemory memory{.registers = workspace.registers.data(),
                     .scalars = workspace.scalars.data(),
                     .columns = inputs};
  for (memory.first_row = 0; memory.first_row < rows; memory.first_row += kBlockRows) {
    memory.rows = std::min(kBlockRows, rows - memory.first_row);
    for (const BlockInstruction& instruction : code_->block) execute(instruction, memory);
    for (std::size_t k = 0; k < outputs.size(); ++k) {
      copy_out(code_->outputs[k], memory, outputs[k] + memory.first_row);
    }
  }
}

std::vector<double> variable_values(std::string_view variable, const Table& table) {
  TextMatch match;
  if (!is_text_match(variable, match)) {
    const std::span<const double> numbers = table.numbers(variable);
    return {numbers.begin(), numbers.end()};
  }
  const TextColumn column = table.labels(match.column);
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
