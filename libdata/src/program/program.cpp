// SPDX-License-Identifier: MIT
#include "silvafit/data/program.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "program/program_block.hpp"
#include "program/program_values.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::data {

namespace {

struct BlockCode {
  std::vector<BlockInstruction> instructions{};
  std::vector<std::uint32_t> scalars{};  ///< the scalar values that are needed, operands first
  std::size_t registers = 0;
};

/// Which values the wanted ones are computed from, themselves included.
std::vector<bool> needed(const std::vector<Value>& values, std::vector<std::uint32_t> wanted) {
  std::vector<bool> result(values.size(), false);
  while (!wanted.empty()) {
    const std::uint32_t number = wanted.back();
    wanted.pop_back();
    if (number == kNone || result[number]) continue;
    result[number] = true;
    for (const std::uint32_t operand : values[number].operands) wanted.push_back(operand);
  }
  return result;
}

/// Chooses the steps, with a separate register for each result.
class StepChoice {
 public:
  StepChoice(const std::vector<Value>& values, std::span<const std::uint32_t> outputs)
      : values_(values), has_pair_(values.size(), false) {
    const std::vector<bool> used = needed(values, {outputs.begin(), outputs.end()});
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (used[i] && takes_logarithm(values[i])) has_pair_[values[i].operands[0]] = true;
    }
  }

  BlockOperand operand(std::uint32_t number) {
    const Value& value = values_[number];
    if (value.is_scalar) return {.kind = BlockOperand::kScalar, .index = number};
    if (value.operation == Operation::kVariable) {
      return {.kind = BlockOperand::kColumn, .index = value.input};
    }
    const auto known = known_.find(number);
    if (known != known_.end()) return known->second;
    const BlockOperand result = step(value);
    known_.emplace(number, result);
    return result;
  }

  std::vector<BlockInstruction> instructions() { return std::move(instructions_); }
  std::uint32_t target_count() const { return targets_; }

 private:
  using Pair = std::pair<BlockOperand, BlockOperand>;

  bool is_whole_constant(std::uint32_t number) const {
    return values_[number].operation == Operation::kConstant &&
           is_whole_power(values_[number].constant);
  }

  bool takes_logarithm(const Value& value) const {
    return value.operation == Operation::kPower && !values_[value.operands[0]].is_scalar &&
           !is_whole_constant(value.operands[1]);
  }

  bool is_product(std::uint32_t number) const {
    return values_[number].operation == Operation::kMultiply && !values_[number].is_scalar;
  }

  BlockOperand step(const Value& value) {
    switch (value.operation) {
      case Operation::kAdd:
      case Operation::kSubtract:
        return sum(value);
      case Operation::kPower:
        return power(value);
      case Operation::kExp:
        if (is_product(value.operands[0])) return exp_of_product(value.operands[0]);
        return plain(value);
      case Operation::kLog:
        if (has_pair_[value.operands[0]]) return logarithm(value.operands[0]).first;
        return plain(value);
      case Operation::kLogFloored:
        if (has_pair_[value.operands[0]]) return floored_logarithm(value.operands[0]);
        return plain(value);
      default:
        return plain(value);
    }
  }

  BlockOperand plain(const Value& value) {
    BlockInstruction instruction{.operation = value.operation};
    for (std::size_t k = 0; k < value.operands.size(); ++k) {
      if (value.operands[k] != kNone) instruction.operands[k] = operand(value.operands[k]);
    }
    return add(instruction);
  }

  BlockOperand sum(const Value& value) {
    const auto [a, b, unused] = value.operands;
    const bool is_sum = value.operation == Operation::kAdd;
    if (is_product(b))
      return with_product(is_sum ? Step::kMultiplyAdd : Step::kSubtractProduct, b, a);
    if (is_product(a))
      return with_product(is_sum ? Step::kMultiplyAdd : Step::kMultiplySubtract, a, b);
    return plain(value);
  }

  BlockOperand with_product(Step step, std::uint32_t product, std::uint32_t other) {
    const auto [a, b] = factors(product);
    const BlockOperand c = operand(other);
    return add({.step = step, .operands = {a, b, c}});
  }

  BlockOperand exp_of_product(std::uint32_t product) {
    const auto [a, b] = factors(product);
    return add({.step = Step::kExpOfProduct, .operands = {a, b}});
  }

  /// The factor that differs by row comes first.
  Pair factors(std::uint32_t product) {
    const BlockOperand a = operand(values_[product].operands[0]);
    const BlockOperand b = operand(values_[product].operands[1]);
    return a.kind == BlockOperand::kScalar ? Pair(b, a) : Pair(a, b);
  }

  BlockOperand power(const Value& value) {
    const auto [base, exponent, unused] = value.operands;
    if (takes_logarithm(value)) {
      const auto [high, low] = logarithm(base);
      return add({.step = Step::kPowerOfLogarithm,
                  .operands = {operand(base), operand(exponent), high, low}});
    }
    if (values_[base].is_scalar) return plain(value);
    return add({.step = Step::kWholePower, .operands = {operand(base), operand(exponent)}});
  }

  Pair logarithm(std::uint32_t number) {
    const auto known = pairs_.find(number);
    if (known != pairs_.end()) return known->second;
    BlockInstruction instruction{.step = Step::kLogarithmPair, .operands = {operand(number)}};
    instruction.second_target = new_target();
    const Pair result{add(instruction), instruction.second_target};
    pairs_.emplace(number, result);
    return result;
  }

  BlockOperand floored_logarithm(std::uint32_t number) {
    return add(
        {.step = Step::kFlooredLogarithm, .operands = {operand(number), logarithm(number).first}});
  }

  BlockOperand new_target() { return {.kind = BlockOperand::kRegister, .index = targets_++}; }

  BlockOperand add(BlockInstruction instruction) {
    instruction.target = new_target();
    instructions_.push_back(instruction);
    return instruction.target;
  }

  const std::vector<Value>& values_;
  std::vector<bool> has_pair_;  ///< by number: whether a power needs its logarithm
  std::unordered_map<std::uint32_t, BlockOperand> known_{};
  std::unordered_map<std::uint32_t, Pair> pairs_{};
  std::vector<BlockInstruction> instructions_{};
  std::uint32_t targets_ = 0;
};

/// Assigns targets to outputs, or to as few registers as possible.
class Placement {
 public:
  Placement(std::vector<BlockInstruction>& instructions, std::uint32_t target_count)
      : instructions_(instructions), places_(target_count), last_use_(target_count, 0) {
    for (std::size_t i = 0; i < instructions.size(); ++i) {
      for (const BlockOperand& operand : instructions[i].operands) {
        if (operand.kind == BlockOperand::kRegister) last_use_[operand.index] = i;
      }
    }
  }

  /// Assigns a target to an output; false if it already has one.
  bool put_into_output(std::uint32_t target, std::uint32_t output) {
    if (places_[target].kind == BlockOperand::kOutput) return false;
    places_[target] = {.kind = BlockOperand::kOutput, .index = output};
    return true;
  }

  BlockOperand place(const BlockOperand& operand) const {
    return operand.kind == BlockOperand::kRegister ? places_[operand.index] : operand;
  }

  /// \return the number of registers
  std::size_t assign() {
    for (std::size_t i = 0; i < instructions_.size(); ++i) {
      BlockInstruction& instruction = instructions_[i];
      std::vector<std::uint32_t> freed;
      for (BlockOperand& operand : instruction.operands) {
        if (operand.kind != BlockOperand::kRegister) continue;
        const std::uint32_t target = operand.index;
        operand = places_[target];
        // A row's operands are read before its result is written, so that the result may overwrite
        // them.
        if (last_use_[target] == i) freed.push_back(operand.index);
        if (last_use_[target] == i && operand.kind == BlockOperand::kOutput) freed.pop_back();
      }
      release(freed);
      take(instruction.target);
      if (instruction.step == Step::kLogarithmPair) take(instruction.second_target);
    }
    return count_;
  }

 private:
  void release(std::vector<std::uint32_t>& freed) {
    std::ranges::sort(freed);
    freed.erase(std::unique(freed.begin(), freed.end()), freed.end());
    free_.insert(free_.end(), freed.begin(), freed.end());
  }

  void take(BlockOperand& target) {
    BlockOperand& place = places_[target.index];
    if (place.kind != BlockOperand::kOutput) {
      place.kind = BlockOperand::kRegister;
      if (free_.empty()) {
        place.index = static_cast<std::uint32_t>(count_++);
      } else {
        place.index = free_.back();
        free_.pop_back();
      }
    }
    target = place;
  }

  std::vector<BlockInstruction>& instructions_;
  std::vector<BlockOperand> places_;
  std::vector<std::size_t> last_use_;
  std::vector<std::uint32_t> free_{};
  std::size_t count_ = 0;
};

std::vector<std::uint32_t> needed_scalars(const std::vector<Value>& values,
                                          const std::vector<BlockInstruction>& instructions) {
  std::vector<std::uint32_t> wanted;
  const auto want = [&wanted](const BlockOperand& operand) {
    if (operand.kind == BlockOperand::kScalar) wanted.push_back(operand.index);
  };
  for (const BlockInstruction& instruction : instructions) {
    std::ranges::for_each(instruction.operands, want);
  }
  const std::vector<bool> used = needed(values, std::move(wanted));
  std::vector<std::uint32_t> result;
  for (std::uint32_t number = 0; number < values.size(); ++number) {
    if (used[number]) result.push_back(number);
  }
  return result;
}

/// The code that writes values[outputs[k]] to output k, row by row.
///
/// Sums with a product become one step, powers of one base share its logarithm. The steps of the
/// first output do not depend on the others, with one exception: log(x) that a power of x shares is
/// rounded from more digits. A step writes to its output where it can, else to a register, which is
/// free again after its last use.
BlockCode block_code(const std::vector<Value>& values, std::span<const std::uint32_t> outputs) {
  StepChoice choice(values, outputs);
  std::vector<BlockOperand> results;
  for (const std::uint32_t output : outputs) results.push_back(choice.operand(output));
  BlockCode code{.instructions = choice.instructions()};

  Placement placement(code.instructions, choice.target_count());
  std::vector<std::uint32_t> copied;
  for (std::uint32_t k = 0; k < results.size(); ++k) {
    const bool is_direct = results[k].kind == BlockOperand::kRegister &&
                           placement.put_into_output(results[k].index, k);
    if (!is_direct) copied.push_back(k);
  }
  code.registers = placement.assign();
  for (const std::uint32_t k : copied) {
    code.instructions.push_back({.step = Step::kCopy,
                                 .target = {.kind = BlockOperand::kOutput, .index = k},
                                 .operands = {placement.place(results[k])}});
  }
  code.scalars = needed_scalars(values, code.instructions);
  return code;
}

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

struct Program::Code {
  std::vector<Input> inputs{};
  std::vector<Value> values{};
  BlockCode block{};
  std::size_t output_count = 0;
};

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
