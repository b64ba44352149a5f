// SPDX-License-Identifier: MIT
// Logarithms of vectors, also to about twice the digits.

// An include guard that opens again for the next instruction set.
#if defined(SILVAFIT_DATA_VECTOR_LOGARITHMS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SILVAFIT_DATA_VECTOR_LOGARITHMS_INL
#undef SILVAFIT_DATA_VECTOR_LOGARITHMS_INL
#else
#define SILVAFIT_DATA_VECTOR_LOGARITHMS_INL
#endif

#include <hwy/highway.h>

#include <cmath>
#include <cstdint>

#include "program/vector_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace silvafit::data {
namespace HWY_NAMESPACE {
namespace {

/// x = 2^exponent (1 + fraction) with sqrt(1/2) <= 1 + fraction < sqrt(2), for a normal x > 0.
struct Split {
  Vector exponent;
  Vector fraction;
};

HWY_INLINE Split split(Vector x) {
  const Bits bits = hn::BitCast(kBits, x);
  // 1 - sqrt(1/2) in bits: the exponent field steps at sqrt(1/2) and not at 1.
  const Bits shifted = hn::Add(
      bits, hn::Set(kBits, std::uint64_t{0x3ff0000000000000} - std::uint64_t{0x3fe6a09e667f3bcd}));
  const Bits biased = hn::ShiftRight<52>(shifted);
  const Bits mantissa =
      hn::Add(hn::Sub(bits, hn::And(shifted, hn::Set(kBits, std::uint64_t{0xfff0000000000000}))),
              hn::Set(kBits, std::uint64_t{0x3ff0000000000000}));
  const Vector exponent =  // as the lowest bits of 2^52 + exponent + 1023
      hn::Sub(
          hn::BitCast(kVector, hn::Or(biased, hn::Set(kBits, std::uint64_t{0x4330000000000000}))),
          constant(0x1p52 + 1023.0));
  return {exponent, hn::Sub(hn::BitCast(kVector, mantissa), constant(1.0))};
}

HWY_INLINE Mask is_normal_positive(Vector x) {
  return hn::And(hn::Ge(x, constant(kSmallestNormal)), hn::Le(x, constant(kLargest)));
}

/// log(x) for a normal x > 0: with s = f / (2 + f), log(1 + f) = 2 s + s (2/3 s^2 + 2/5 s^4 + ...),
/// where 2 s = f - s f, so that f, which is exact, carries most of the sum.
HWY_INLINE Vector ordinary_logarithm(Vector x) {
  const Split parts = split(x);
  const Vector f = parts.fraction;
  const Vector s = hn::Div(f, hn::Add(constant(2.0), f));
  const Vector z = hn::Mul(s, s);
  Vector series = constant(0x1.2b584aae78c14p-3);  // relative error 2^-57 of the logarithm
  series = hn::MulAdd(series, z, constant(0x1.39fe606542dbap-3));
  series = hn::MulAdd(series, z, constant(0x1.7462b4ab2ef6cp-3));
  series = hn::MulAdd(series, z, constant(0x1.c71c62e5800a1p-3));
  series = hn::MulAdd(series, z, constant(0x1.2492492df148dp-2));
  series = hn::MulAdd(series, z, constant(0x1.99999999952e2p-2));
  series = hn::MulAdd(series, z, constant(0x1.5555555555558p-1));
  const Vector half_square = hn::Mul(hn::Mul(f, f), constant(0.5));
  const Vector small =
      hn::MulAdd(s, hn::MulAdd(z, series, half_square), hn::Mul(parts.exponent, constant(kLn2Low)));
  return hn::MulAdd(parts.exponent, constant(kLn2High), hn::Sub(f, hn::Sub(half_square, small)));
}

/// log(x) for a normal x > 0 with an error of about 2^-64 of its size, for powers: an error in log
/// x becomes y log x times as large in x^y.
HWY_INLINE Pair ordinary_logarithm_pair(Vector x) {
  const Split parts = split(x);
  const Vector f = parts.fraction;
  const Vector two = constant(2.0);

  // s = f / (2 + f)
  const Vector divisor = hn::Add(two, f);
  const Vector divisor_low = hn::Sub(f, hn::Sub(divisor, two));
  const Vector inverse = hn::Div(constant(1.0), divisor);
  const Vector s = hn::Mul(f, inverse);
  const Vector s_divisor = hn::Mul(s, divisor);
  const Vector rest = hn::Sub(hn::Sub(hn::Sub(f, s_divisor), product_error(s, divisor, s_divisor)),
                              hn::Mul(s, divisor_low));
  const Vector s_low = hn::Mul(rest, inverse);

  // z = s^2, and the series 2/3 + 2/5 z + ...
  const Vector z = hn::Mul(s, s);
  const Vector z_low = hn::MulAdd(hn::Add(s, s), s_low, product_error(s, s, z));
  Vector tail = constant(0x1.e02d197c00fbcp-4);  // relative error 2^-66 of the logarithm
  tail = hn::MulAdd(tail, z, constant(0x1.df7ce9a6bcc7bp-4));
  tail = hn::MulAdd(tail, z, constant(0x1.1118c74823a2fp-3));
  tail = hn::MulAdd(tail, z, constant(0x1.3b1395d4f9e5fp-3));
  tail = hn::MulAdd(tail, z, constant(0x1.745d177a8f200p-3));
  tail = hn::MulAdd(tail, z, constant(0x1.c71c71c6eaa8dp-3));
  tail = hn::MulAdd(tail, z, constant(0x1.2492492492521p-2));
  tail = hn::MulAdd(tail, z, constant(0x1.999999999999ap-2));
  tail = hn::Mul(tail, z);
  const Vector two_thirds = constant(0x1.5555555555555p-1);
  const Vector series = hn::Add(two_thirds, tail);
  const Vector series_low =
      hn::Add(hn::Add(hn::Sub(two_thirds, series), tail), constant(0x1.5555555555555p-55));

  // 2 + z series
  const Vector t = hn::Mul(z, series);
  const Vector t_low =
      hn::MulAdd(z_low, series, hn::MulAdd(z, series_low, product_error(z, series, t)));
  const Vector factor = hn::Add(two, t);
  const Vector factor_low = hn::Add(hn::Add(hn::Sub(two, factor), t), t_low);

  // s (2 + z series) + exponent ln 2
  const Vector of_fraction = hn::Mul(s, factor);
  const Vector of_fraction_low =
      hn::MulAdd(s_low, factor, hn::MulAdd(s, factor_low, product_error(s, factor, of_fraction)));
  const Vector of_exponent = hn::Mul(parts.exponent, constant(kLn2High));  // exact
  const Vector sum = hn::Add(of_exponent, of_fraction);
  const Vector sum_low = hn::Add(hn::Add(hn::Sub(of_exponent, sum), of_fraction),
                                 hn::MulAdd(parts.exponent, constant(kLn2Low), of_fraction_low));
  const Vector high = hn::Add(sum, sum_low);
  return {high, hn::Add(hn::Sub(sum, high), sum_low)};
}

struct LogarithmHigh {
  static double other(double x) { return std::log(x); }
};

/// The low part to LogarithmHigh; it is not zero for subnormal numbers only.
struct LogarithmLow {
  static double other(double x) {
    if (!(x > 0.0 && x < kSmallestNormal)) return 0.0;
    return static_cast<double>(::logl(static_cast<long double>(x)) - std::log(x));
  }
};

/// The logarithm of any x as a pair; its high part is what std::log gives.
HWY_INLINE Pair logarithm_pair(Vector x) {
  const Mask ordinary = is_normal_positive(x);
  const Pair result = ordinary_logarithm_pair(x);
  if (HWY_LIKELY(hn::AllTrue(kVector, ordinary))) return result;
  return {replace_others<LogarithmHigh>(x, result.high, ordinary),
          replace_others<LogarithmLow>(x, result.low, ordinary)};
}

struct OrdinaryLogarithm {
  static HWY_INLINE Mask is_ordinary(Vector x) { return is_normal_positive(x); }
  static HWY_INLINE Vector ordinary(Vector x) { return ordinary_logarithm(x); }
  static double other(double x) { return std::log(x); }
};
using Logarithm = Everywhere<OrdinaryLogarithm>;

/// The logarithm times a constant, which keeps the logarithms of powers of the base whole.
HWY_INLINE Vector scaled_logarithm(Vector x, double scale, double scale_low) {
  const Pair log = ordinary_logarithm_pair(x);
  const Vector product = hn::Mul(log.high, constant(scale));
  const Vector error = product_error(log.high, constant(scale), product);
  return hn::Add(
      product,
      hn::MulAdd(log.high, constant(scale_low), hn::MulAdd(log.low, constant(scale), error)));
}

struct OrdinaryLogarithm10 {
  static HWY_INLINE Mask is_ordinary(Vector x) { return is_normal_positive(x); }
  static HWY_INLINE Vector ordinary(Vector x) {
    return scaled_logarithm(x, 0x1.bcb7b1526e50ep-2, 0x1.95355baaafad3p-57);
  }
  static double other(double x) { return std::log10(x); }
};
using Logarithm10 = Everywhere<OrdinaryLogarithm10>;

struct OrdinaryLogarithm2 {
  static HWY_INLINE Mask is_ordinary(Vector x) { return is_normal_positive(x); }
  static HWY_INLINE Vector ordinary(Vector x) {
    return scaled_logarithm(x, 0x1.71547652b82fep+0, 0x1.777d0ffda0d24p-56);
  }
  static double other(double x) { return std::log2(x); }
};
using Logarithm2 = Everywhere<OrdinaryLogarithm2>;

/// log(1 + x) as log(u) + c / u, where u + c = 1 + x exactly.
struct OrdinaryLogarithm1p {
  static HWY_INLINE Mask is_ordinary(Vector x) {
    return hn::And(hn::Gt(x, constant(-1.0)), hn::Le(x, constant(1e300)));
  }
  static HWY_INLINE Vector ordinary(Vector x) {
    const Vector one = constant(1.0);
    const Vector u = hn::Add(one, x);
    const Vector of_x = hn::Sub(u, one);
    const Vector c = hn::Add(hn::Sub(one, hn::Sub(u, of_x)), hn::Sub(x, of_x));
    const Vector result = hn::Add(ordinary_logarithm(u), hn::Div(c, u));
    return hn::IfThenElse(is_within(x, 0x1p-54), x, result);  // keeps the sign of zero
  }
  static double other(double x) { return std::log1p(x); }
};
using Logarithm1p = Everywhere<OrdinaryLogarithm1p>;

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace silvafit::data
HWY_AFTER_NAMESPACE();

#endif
