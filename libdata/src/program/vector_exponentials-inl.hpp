// SPDX-License-Identifier: MIT
// The exponential and the hyperbolic functions of vectors.

// An include guard that opens again for the next instruction set.
#if defined(SILVAFIT_DATA_VECTOR_EXPONENTIALS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SILVAFIT_DATA_VECTOR_EXPONENTIALS_INL
#undef SILVAFIT_DATA_VECTOR_EXPONENTIALS_INL
#else
#define SILVAFIT_DATA_VECTOR_EXPONENTIALS_INL
#endif

#include <hwy/highway.h>

#include <cmath>

#include "program/vector_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace silvafit::data {
namespace HWY_NAMESPACE {
namespace {

// Adding this leaves n + 1023, for a whole n, in the lowest bits.
constexpr double kExponentShift = 0x1.8p52 + 1023.0;

/// 2^n for n + kExponentShift, -1023 < n < 1024.
HWY_INLINE Vector power_of_two(Vector shifted) {
  return hn::BitCast(kVector, hn::ShiftLeft<52>(hn::BitCast(kBits, shifted)));
}

/// x + low = n ln 2 + remainder + remainder_low
struct Reduced {
  Vector shifted;    ///< n + kExponentShift
  Vector remainder;  ///< at most ln 2 / 2, exact
  Vector remainder_low;
};

HWY_INLINE Reduced reduced(Vector x, Vector low) {
  const Vector shifted =
      hn::MulAdd(x, constant(0x1.71547652b82fep+0), constant(kExponentShift));  // 1 / ln 2
  const Vector n = hn::Sub(shifted, constant(kExponentShift));
  return {shifted, hn::MulAdd(n, constant(-kLn2High), x), hn::MulAdd(n, constant(-kLn2Low), low)};
}

/// exp(r) - 1 - remainder, where r is the remainder with its low part; error of the polynomial
/// 2^-61.
HWY_INLINE Vector exponential_tail(const Reduced& argument) {
  const Vector r = hn::Add(argument.remainder, argument.remainder_low);
  Vector sum = constant(0x1.1f72fc730b510p-29);
  sum = hn::MulAdd(sum, r, constant(0x1.af4ddd848831bp-26));
  sum = hn::MulAdd(sum, r, constant(0x1.27e4db67b4303p-22));
  sum = hn::MulAdd(sum, r, constant(0x1.71de02375656cp-19));
  sum = hn::MulAdd(sum, r, constant(0x1.a01a01a6d7808p-16));
  sum = hn::MulAdd(sum, r, constant(0x1.a01a01abe62ddp-13));
  sum = hn::MulAdd(sum, r, constant(0x1.6c16c16c162d6p-10));
  sum = hn::MulAdd(sum, r, constant(0x1.11111111100dfp-7));
  sum = hn::MulAdd(sum, r, constant(0x1.5555555555556p-5));
  sum = hn::MulAdd(sum, r, constant(0x1.5555555555557p-3));
  sum = hn::MulAdd(sum, r, constant(0.5));
  return hn::MulAdd(hn::Mul(r, r), sum, argument.remainder_low);
}

/// exp(r), with little more than the last rounding.
HWY_INLINE Vector exponential_of(const Reduced& argument) {
  const Vector one = constant(1.0);
  const Vector sum = hn::Add(one, argument.remainder);
  const Vector sum_low = hn::Add(hn::Sub(one, sum), argument.remainder);
  return hn::Add(sum, hn::Add(sum_low, exponential_tail(argument)));
}

/// exp(x + low) for |x| <= kOrdinaryExponent and a low of a few units in the last place of x.
constexpr double kOrdinaryExponent = 708.0;
HWY_INLINE Vector ordinary_exponential(Vector x, Vector low) {
  const Reduced argument = reduced(x, low);
  return hn::Mul(exponential_of(argument), power_of_two(argument.shifted));
}

/// Also where the result overflows or has fewer digits: 2^n in two factors.
HWY_NOINLINE Vector any_exponential(Vector x) {
  const Vector clamped = hn::Max(hn::Min(x, constant(720.0)), constant(-760.0));
  const Reduced argument = reduced(clamped, hn::Zero(kVector));
  const Vector n = hn::Sub(argument.shifted, constant(kExponentShift));
  const Vector half = hn::MulAdd(n, constant(0.5), constant(kExponentShift));
  const Vector rest = hn::Sub(n, hn::Sub(half, constant(kExponentShift)));
  const Vector result = hn::Mul(hn::Mul(exponential_of(argument), power_of_two(half)),
                                power_of_two(hn::Add(rest, constant(kExponentShift))));
  return hn::IfThenElse(hn::IsNaN(x), x, result);
}

struct Exponential {
  HWY_INLINE Vector operator()(Vector x) const {
    if (HWY_LIKELY(hn::AllTrue(kVector, is_within(x, kOrdinaryExponent)))) {
      return ordinary_exponential(x, hn::Zero(kVector));
    }
    return any_exponential(x);
  }
};

/// exp(x) - 1 as 2^n (exp(r) - 1) + (2^n - 1).
struct OrdinaryExpm1 {
  static HWY_INLINE Mask is_ordinary(Vector x) { return is_within(x, 700.0); }
  static HWY_INLINE Vector ordinary(Vector x) {
    const Reduced argument = reduced(x, hn::Zero(kVector));
    const Vector scale = power_of_two(argument.shifted);
    const Vector of_remainder = hn::Add(argument.remainder, exponential_tail(argument));
    const Vector result = hn::MulAdd(scale, of_remainder, hn::Sub(scale, constant(1.0)));
    return hn::IfThenElse(is_within(x, 0x1p-54), x, result);  // keeps the sign of zero
  }
  static double other(double x) { return std::expm1(x); }
};
using Expm1 = Everywhere<OrdinaryExpm1>;

// With m = exp(|x|) - 1: sinh |x| = (m + m / (m + 1)) / 2, and tanh |x| = m / (m + 2) where m =
// exp(2 |x|) - 1.
struct OrdinaryHyperbolicSine {
  static HWY_INLINE Mask is_ordinary(Vector x) { return is_within(x, 700.0); }
  static HWY_INLINE Vector ordinary(Vector x) {
    const Vector m = OrdinaryExpm1::ordinary(hn::Abs(x));
    const Vector twice = hn::Add(m, hn::Div(m, hn::Add(m, constant(1.0))));
    return hn::CopySign(hn::Mul(constant(0.5), twice), x);
  }
  static double other(double x) { return std::sinh(x); }
};
using HyperbolicSine = Everywhere<OrdinaryHyperbolicSine>;

struct OrdinaryHyperbolicCosine {
  static HWY_INLINE Mask is_ordinary(Vector x) { return is_within(x, 700.0); }
  static HWY_INLINE Vector ordinary(Vector x) {
    const Vector e = ordinary_exponential(hn::Abs(x), hn::Zero(kVector));
    return hn::Mul(constant(0.5), hn::Add(e, hn::Div(constant(1.0), e)));
  }
  static double other(double x) { return std::cosh(x); }
};
using HyperbolicCosine = Everywhere<OrdinaryHyperbolicCosine>;

struct OrdinaryHyperbolicTangent {
  static HWY_INLINE Mask is_ordinary(Vector x) { return is_within(x, 300.0); }
  static HWY_INLINE Vector ordinary(Vector x) {
    const Vector m = OrdinaryExpm1::ordinary(hn::Mul(constant(2.0), hn::Abs(x)));
    return hn::CopySign(hn::Div(m, hn::Add(m, constant(2.0))), x);
  }
  static double other(double x) { return std::tanh(x); }
};
using HyperbolicTangent = Everywhere<OrdinaryHyperbolicTangent>;

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace silvafit::data
HWY_AFTER_NAMESPACE();

#endif
