// SPDX-License-Identifier: MIT
#include "program/program_code.hpp"

#include <algorithm>
#include <unordered_map>
#include <utility>

namespace silvafit::data {
namespace {

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

}  // namespace

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

}  // namespace silvafit::data
