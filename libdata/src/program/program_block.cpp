// SPDX-License-Identifier: MIT
#include "program/program_block.hpp"

#include <cmath>

#include "program/vector_targets.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "program/program_block.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include "program/vector_exponentials-inl.hpp"
#include "program/vector_logarithms-inl.hpp"
#include "program/vector_powers-inl.hpp"
#include "program/vector_rows-inl.hpp"
#include "program/vector_trigonometry-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace silvafit::data {
namespace HWY_NAMESPACE {
namespace {

// ---------------------------------------------------------------- operands

/// An operand with a value a row.
struct Rows {
  const double* values;
  HWY_INLINE Vector all(std::size_t row) const { return hn::LoadU(kVector, values + row); }
  HWY_INLINE Vector first(std::size_t row, std::size_t rows) const {
    return load_repeated(values + row, rows);
  }
};

/// A scalar, the same in every lane.
struct Same {
  Vector value;
  HWY_INLINE Vector all(std::size_t /*row*/) const { return value; }
  HWY_INLINE Vector first(std::size_t /*row*/, std::size_t /*rows*/) const { return value; }
};

/// The operands and the target of an instruction in one block.
struct Place {
  const BlockInstruction& instruction;
  const BlockMemory& memory;

  HWY_INLINE bool is_scalar(std::size_t k) const {
    return instruction.operands.data()[k].kind == BlockOperand::kScalar;
  }
  HWY_INLINE double scalar(std::size_t k) const {
    return memory.scalars[instruction.operands.data()[k].index];
  }
  HWY_INLINE Same same(std::size_t k) const { return {hn::Set(kVector, scalar(k))}; }
  HWY_INLINE Rows rows(std::size_t k) const { return {values(instruction.operands.data()[k])}; }
  HWY_INLINE double* target() const { return values(instruction.target); }
  HWY_INLINE double* second_target() const { return values(instruction.second_target); }

 private:
  HWY_INLINE double* values(const BlockOperand& operand) const {
    if (operand.kind == BlockOperand::kRegister) {
      return memory.registers + operand.index * kRegisterStride;
    }
    if (operand.kind == BlockOperand::kOutput) {
      return memory.outputs[operand.index] + memory.first_row;
    }
    return const_cast<double*>(memory.columns[operand.index]) + memory.first_row;  // only read
  }
};

template <typename Function, typename... Operands>
HWY_INLINE void for_rows(const Place& place, const Operands&... operands) {
  const Function function;
  double* const target = place.target();
  const std::size_t rows = place.memory.rows;
  std::size_t row = 0;
  for (; row + kVectorRows <= rows; row += kVectorRows) {
    hn::StoreU(function(operands.all(row)...), kVector, target + row);
  }
  if (row < rows) {
    const std::size_t rest = rows - row;
    store_first(function(operands.first(row, rest)...), target + row, rest);
  }
}

template <typename Function>
void unary(const Place& place) {
  for_rows<Function>(place, place.rows(0));
}

/// At least one of the two differs by row.
template <typename Function>
void binary(const Place& place) {
  if (place.is_scalar(0)) {
    for_rows<Function>(place, place.same(0), place.rows(1));
  } else if (place.is_scalar(1)) {
    for_rows<Function>(place, place.rows(0), place.same(1));
  } else {
    for_rows<Function>(place, place.rows(0), place.rows(1));
  }
}

template <typename Function, typename First, typename Second>
HWY_INLINE void with_third(const Place& place, const First& first, const Second& second) {
  if (place.is_scalar(2)) {
    for_rows<Function>(place, first, second, place.same(2));
  } else {
    for_rows<Function>(place, first, second, place.rows(2));
  }
}

/// The first of the three differs by row.
template <typename Function>
void ternary(const Place& place) {
  if (place.is_scalar(1)) {
    with_third<Function>(place, place.rows(0), place.same(1));
  } else {
    with_third<Function>(place, place.rows(0), place.rows(1));
  }
}

// ---------------------------------------------------------------- what happens to a row

struct Add {
  HWY_INLINE Vector operator()(Vector a, Vector b) const { return hn::Add(a, b); }
};
struct Subtract {
  HWY_INLINE Vector operator()(Vector a, Vector b) const { return hn::Sub(a, b); }
};
struct Multiply {
  HWY_INLINE Vector operator()(Vector a, Vector b) const { return hn::Mul(a, b); }
};
struct LimitProduct {
  HWY_INLINE Vector operator()(Vector a, Vector b) const {
    const Vector zero = hn::Zero(kVector);
    return hn::IfThenZeroElse(hn::Or(hn::Eq(a, zero), hn::Eq(b, zero)), hn::Mul(a, b));
  }
};
struct Divide {
  HWY_INLINE Vector operator()(Vector a, Vector b) const { return hn::Div(a, b); }
};
struct MultiplyAdd {
  HWY_INLINE Vector operator()(Vector a, Vector b, Vector c) const { return hn::MulAdd(a, b, c); }
};
struct MultiplySubtract {
  HWY_INLINE Vector operator()(Vector a, Vector b, Vector c) const { return hn::MulSub(a, b, c); }
};
struct SubtractProduct {
  HWY_INLINE Vector operator()(Vector a, Vector b, Vector c) const {
    return hn::NegMulAdd(a, b, c);
  }
};
struct ExpOfProduct {
  HWY_INLINE Vector operator()(Vector a, Vector b) const { return Exponential()(hn::Mul(a, b)); }
};

struct Copy {
  HWY_INLINE Vector operator()(Vector a) const { return a; }
};
struct Negate {
  HWY_INLINE Vector operator()(Vector a) const { return hn::Neg(a); }
};
struct Absolute {
  HWY_INLINE Vector operator()(Vector a) const { return hn::Abs(a); }
};
struct SquareRoot {
  HWY_INLINE Vector operator()(Vector a) const { return hn::Sqrt(a); }
};

HWY_INLINE Vector as_number(Mask truth) { return hn::IfThenElseZero(truth, constant(1.0)); }

// Missing values are neither true nor false; operation.cpp defines what follows.
HWY_INLINE Mask is_true(Vector a) {
  return hn::Or(hn::Lt(a, hn::Zero(kVector)), hn::Gt(a, hn::Zero(kVector)));
}
HWY_INLINE Vector unless_missing(Vector a, Vector b, Vector result) {
  return hn::IfThenElse(hn::Or(hn::IsNaN(a), hn::IsNaN(b)), hn::NaN(kVector), result);
}

struct Sign {
  HWY_INLINE Vector operator()(Vector a) const {
    const Vector zero = hn::Zero(kVector);
    const Vector sign = hn::IfThenElse(hn::Lt(a, zero), constant(-1.0), as_number(hn::Gt(a, zero)));
    return hn::IfThenElse(hn::IsNaN(a), a, sign);
  }
};
struct Less {
  HWY_INLINE Vector operator()(Vector a, Vector b) const {
    return unless_missing(a, b, as_number(hn::Lt(a, b)));
  }
};
struct LessEqual {
  HWY_INLINE Vector operator()(Vector a, Vector b) const {
    return unless_missing(a, b, as_number(hn::Le(a, b)));
  }
};
struct Equal {
  HWY_INLINE Vector operator()(Vector a, Vector b) const {
    return unless_missing(a, b, as_number(hn::Eq(a, b)));
  }
};
struct LogicalAnd {
  HWY_INLINE Vector operator()(Vector a, Vector b) const {
    const Vector zero = hn::Zero(kVector);
    const Mask is_false = hn::Or(hn::Eq(a, zero), hn::Eq(b, zero));
    return hn::IfThenZeroElse(is_false, unless_missing(a, b, constant(1.0)));
  }
};
struct LogicalOr {
  HWY_INLINE Vector operator()(Vector a, Vector b) const {
    return hn::IfThenElse(
        hn::Or(is_true(a), is_true(b)), constant(1.0), unless_missing(a, b, hn::Zero(kVector)));
  }
};
struct LogicalNot {
  HWY_INLINE Vector operator()(Vector a) const {
    return unless_missing(a, a, as_number(hn::Eq(a, hn::Zero(kVector))));
  }
};
struct Minimum {
  HWY_INLINE Vector operator()(Vector a, Vector b) const {
    return hn::IfThenElse(hn::Or(hn::Lt(b, a), hn::IsNaN(b)), b, a);
  }
};
struct Maximum {
  HWY_INLINE Vector operator()(Vector a, Vector b) const {
    return hn::IfThenElse(hn::Or(hn::Gt(b, a), hn::IsNaN(b)), b, a);
  }
};
struct Choose {
  HWY_INLINE Vector operator()(Vector condition, Vector a, Vector b) const {
    return unless_missing(condition, condition, hn::IfThenElse(is_true(condition), a, b));
  }
};

/// log a, given as the second argument; only a = 0 has another value.
struct FlooredLogarithm {
  HWY_INLINE Vector operator()(Vector a, Vector logarithm) const {
    const Vector floor = constant(-708.39641853226408);  // log of the smallest normal number
    return hn::IfThenElse(hn::Eq(a, hn::Zero(kVector)), floor, logarithm);
  }
};

struct LogarithmFloored {
  HWY_INLINE Vector operator()(Vector a) const {
    const Vector smallest = constant(kSmallestNormal);
    return Logarithm()(hn::IfThenElse(hn::Eq(a, hn::Zero(kVector)), smallest, a));
  }
};

// ---------------------------------------------------------------- steps of their own shape

/// Whole powers by multiplication, for any base.
void whole_power(const Place& place) {
  const auto exponent = static_cast<int>(place.scalar(1));
  const Rows base = place.rows(0);
  double* const target = place.target();
  const std::size_t rows = place.memory.rows;
  for (std::size_t row = 0; row < rows; row += kVectorRows) {
    const bool is_whole = row + kVectorRows <= rows;
    Vector factor = is_whole ? base.all(row) : base.first(row, rows - row);
    Vector result = constant(1.0);
    for (int rest = exponent < 0 ? -exponent : exponent; rest > 0; rest /= 2) {
      if (rest % 2 == 1) result = hn::Mul(result, factor);
      factor = hn::Mul(factor, factor);
    }
    if (exponent < 0) result = hn::Div(constant(1.0), result);
    if (is_whole) {
      hn::StoreU(result, kVector, target + row);
    } else {
      store_first(result, target + row, rows - row);
    }
  }
}

void logarithm_pairs(const Place& place) {
  const Rows x = place.rows(0);
  double* const high = place.target();
  double* const low = place.second_target();
  const std::size_t rows = place.memory.rows;
  std::size_t row = 0;
  for (; row + kVectorRows <= rows; row += kVectorRows) {
    const Pair log = logarithm_pair(x.all(row));
    hn::StoreU(log.high, kVector, high + row);
    hn::StoreU(log.low, kVector, low + row);
  }
  if (row < rows) {
    const Pair log = logarithm_pair(x.first(row, rows - row));
    store_first(log.high, high + row, rows - row);
    store_first(log.low, low + row, rows - row);
  }
}

void power_of_logarithm(const Place& place) {
  if (!place.is_scalar(1)) {
    for_rows<PowerOfLogarithm>(place, place.rows(0), place.rows(1), place.rows(2), place.rows(3));
  } else if (is_whole_power(place.scalar(1))) {
    whole_power(place);
  } else {
    for_rows<PowerOfLogarithm>(place, place.rows(0), place.same(1), place.rows(2), place.rows(3));
  }
}

/// Only one of the three operands has to differ by row.
void choose(const Place& place) {
  if (!place.is_scalar(0)) {
    ternary<Choose>(place);
  } else if (place.is_scalar(1)) {
    for_rows<Choose>(place, place.same(0), place.same(1), place.rows(2));
  } else {
    with_third<Choose>(place, place.same(0), place.rows(1));
  }
}

void copy(const Place& place) {
  if (place.is_scalar(0)) {
    for_rows<Copy>(place, place.same(0));
  } else {
    unary<Copy>(place);
  }
}

// ---------------------------------------------------------------- which step

void run_function(const Place& place) {
  switch (place.instruction.operation) {
    case Operation::kNegate:
      return unary<Negate>(place);
    case Operation::kNot:
      return unary<LogicalNot>(place);
    case Operation::kExp:
      return unary<Exponential>(place);
    case Operation::kLog:
      return unary<Logarithm>(place);
    case Operation::kLogFloored:
      return unary<LogarithmFloored>(place);
    case Operation::kLog10:
      return unary<Logarithm10>(place);
    case Operation::kLog2:
      return unary<Logarithm2>(place);
    case Operation::kLog1p:
      return unary<Logarithm1p>(place);
    case Operation::kExpm1:
      return unary<Expm1>(place);
    case Operation::kSqrt:
      return unary<SquareRoot>(place);
    case Operation::kAbs:
      return unary<Absolute>(place);
    case Operation::kSign:
      return unary<Sign>(place);
    case Operation::kSin:
      return unary<Sine>(place);
    case Operation::kCos:
      return unary<Cosine>(place);
    case Operation::kTan:
      return unary<Tangent>(place);
    case Operation::kAsin:
      return unary<ArcSine>(place);
    case Operation::kAcos:
      return unary<ArcCosine>(place);
    case Operation::kAtan:
      return unary<ArcTangent>(place);
    case Operation::kSinh:
      return unary<HyperbolicSine>(place);
    case Operation::kCosh:
      return unary<HyperbolicCosine>(place);
    case Operation::kTanh:
      return unary<HyperbolicTangent>(place);
    default:
      return;  // variables and constants are not steps
  }
}

void run_operation(const Place& place) {
  switch (place.instruction.operation) {
    case Operation::kAdd:
      return binary<Add>(place);
    case Operation::kSubtract:
      return binary<Subtract>(place);
    case Operation::kMultiply:
      return binary<Multiply>(place);
    case Operation::kLimitProduct:
      return binary<LimitProduct>(place);
    case Operation::kDivide:
      return binary<Divide>(place);
    case Operation::kPower:
      return binary<Power>(place);
    case Operation::kLess:
      return binary<Less>(place);
    case Operation::kLessEqual:
      return binary<LessEqual>(place);
    case Operation::kEqual:
      return binary<Equal>(place);
    case Operation::kAnd:
      return binary<LogicalAnd>(place);
    case Operation::kOr:
      return binary<LogicalOr>(place);
    case Operation::kMin:
      return binary<Minimum>(place);
    case Operation::kMax:
      return binary<Maximum>(place);
    case Operation::kIfElse:
      return choose(place);
    default:
      return run_function(place);
  }
}

void run(const Place& place) {
  switch (place.instruction.step) {
    case Step::kOperation:
      return run_operation(place);
    case Step::kMultiplyAdd:
      return ternary<MultiplyAdd>(place);
    case Step::kMultiplySubtract:
      return ternary<MultiplySubtract>(place);
    case Step::kSubtractProduct:
      return ternary<SubtractProduct>(place);
    case Step::kExpOfProduct:
      return binary<ExpOfProduct>(place);
    case Step::kWholePower:
      return whole_power(place);
    case Step::kLogarithmPair:
      return logarithm_pairs(place);
    case Step::kPowerOfLogarithm:
      return power_of_logarithm(place);
    case Step::kFlooredLogarithm:
      return binary<FlooredLogarithm>(place);
    case Step::kCopy:
      return copy(place);
  }
}

void run_blocks(const BlockInstruction* instructions,
                std::size_t count,
                const BlockMemory& memory,
                std::size_t rows) {
  BlockMemory block = memory;
  for (; block.first_row < rows; block.first_row += kBlockRows) {
    const std::size_t rest = rows - block.first_row;
    block.rows = rest < kBlockRows ? rest : kBlockRows;
    for (std::size_t k = 0; k < count; ++k) run({instructions[k], block});
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace silvafit::data
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace silvafit::data {
namespace {

HWY_EXPORT(run_blocks);

}  // namespace

bool is_whole_power(double exponent) {
  return std::abs(exponent) <= kLargestWhole && exponent == std::round(exponent);
}

void execute(std::span<const BlockInstruction> instructions,
             const BlockMemory& memory,
             std::size_t rows) {
  HWY_DYNAMIC_DISPATCH(run_blocks)(instructions.data(), instructions.size(), memory, rows);
}

}  // namespace silvafit::data
#endif  // HWY_ONCE
