// SPDX-License-Identifier: MIT
// Functions of vectors of doubles; compiled once for each instruction set (see vector_targets.hpp).
//
// Each gives what the function of <cmath> gives to a few units in the last place
// (program_accuracy_test.cpp says how many), for every argument. A lane's value depends on its own
// argument alone. Arguments that a fast formula does not cover (missing, infinite, outside of its
// range) are left to <cmath>, lane by lane.
//
// The polynomials have the least maximum error on their interval to within a factor of two
// (interpolation at Chebyshev nodes with 60 digits, coefficients then rounded).

// An include guard that opens again for the next instruction set.
#if defined(SILVAFIT_DATA_VECTOR_FUNCTIONS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SILVAFIT_DATA_VECTOR_FUNCTIONS_INL
#undef SILVAFIT_DATA_VECTOR_FUNCTIONS_INL
#else
#define SILVAFIT_DATA_VECTOR_FUNCTIONS_INL
#endif

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include <cmath>
#include <cstdint>

#include "vector_rows-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace silvafit::data {
namespace HWY_NAMESPACE {
namespace {

using BitsTag = hn::Rebind<std::uint64_t, VectorTag>;
using Bits = hn::Vec<BitsTag>;
using Mask = hn::Mask<VectorTag>;
constexpr BitsTag kBits;

HWY_INLINE Vector constant(double value) { return hn::Set(kVector, value); }

constexpr double kSmallestNormal = 0x1p-1022;
constexpr double kLargest = 0x1.fffffffffffffp+1023;

// ln 2 = kLn2High + kLn2Low to 85 bits; the first has 32 bits, so that its products with exponents
// are exact.
constexpr double kLn2High = 0x1.62e42feep-1;
constexpr double kLn2Low = 0x1.a39ef35793c76p-33;

/// A sum of two doubles that has about twice their digits.
struct Pair {
  Vector high;
  Vector low;
};

/// a b - product, exactly, where product is a b rounded.
HWY_INLINE Vector product_error(Vector a, Vector b, Vector product) {
#if HWY_NATIVE_FMA
  return hn::MulSub(a, b, product);
#else
  // T. J. Dekker 1971, A floating-point technique for extending the available precision.
  const Vector splitter = constant(0x1p27 + 1.0);
  const Vector a_scaled = hn::Mul(a, splitter);
  const Vector b_scaled = hn::Mul(b, splitter);
  const Vector a_high = hn::Sub(a_scaled, hn::Sub(a_scaled, a));
  const Vector b_high = hn::Sub(b_scaled, hn::Sub(b_scaled, b));
  const Vector a_low = hn::Sub(a, a_high);
  const Vector b_low = hn::Sub(b, b_high);
  Vector error = hn::Sub(hn::Mul(a_high, b_high), product);
  error = hn::Add(error, hn::Mul(a_high, b_low));
  error = hn::Add(error, hn::Mul(a_low, b_high));
  return hn::Add(error, hn::Mul(a_low, b_low));
#endif
}

/// Replaces the lanes that are not ordinary by other(argument).
template <typename Function>
HWY_NOINLINE Vector replace_others(Vector x, Vector values, Mask ordinary) {
  HWY_ALIGN double arguments[kVectorRows];
  HWY_ALIGN double results[kVectorRows];
  HWY_ALIGN double is_ordinary[kVectorRows];
  hn::Store(x, kVector, arguments);
  hn::Store(values, kVector, results);
  hn::Store(hn::IfThenElseZero(ordinary, constant(1.0)), kVector, is_ordinary);
  for (std::size_t lane = 0; lane < kVectorRows; ++lane) {
    if (is_ordinary[lane] == 0.0) results[lane] = Function::other(arguments[lane]);
  }
  return hn::Load(kVector, results);
}

/// Function::ordinary where Function::is_ordinary, Function::other for the other lanes.
template <typename Function>
struct Everywhere {
  HWY_INLINE Vector operator()(Vector x) const {
    const Mask ordinary = Function::is_ordinary(x);
    const Vector values = Function::ordinary(x);
    if (HWY_LIKELY(hn::AllTrue(kVector, ordinary))) return values;
    return replace_others<Function>(x, values, ordinary);
  }
};

HWY_INLINE Mask is_within(Vector x, double bound) {  // false for missing values
  return hn::Le(hn::Abs(x), constant(bound));
}

// ---------------------------------------------------------------- exponential

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

// ---------------------------------------------------------------- logarithms

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

/// What is missing in LogarithmHigh; only numbers below the normal ones have such a part.
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

// ---------------------------------------------------------------- powers

/// x^y from the logarithm of x, which other powers of x share.
struct PowerOfLogarithm {
  HWY_INLINE Vector operator()(Vector x, Vector y, Vector high, Vector low) const {
    const Vector product = hn::Mul(y, high);
    const Vector rest = hn::MulAdd(y, low, product_error(y, high, product));
    // False for a base that has no logarithm, and for whatever overflows or loses digits.
    const Mask ordinary = hn::And(is_within(product, 707.0), is_within(y, 0x1p900));
    const Vector result = ordinary_exponential(product, rest);
    if (HWY_LIKELY(hn::AllTrue(kVector, ordinary))) return result;
    return others(x, y, result, ordinary);
  }

  static HWY_NOINLINE Vector others(Vector x, Vector y, Vector values, Mask ordinary) {
    HWY_ALIGN double bases[kVectorRows];
    HWY_ALIGN double exponents[kVectorRows];
    HWY_ALIGN double results[kVectorRows];
    HWY_ALIGN double is_ordinary[kVectorRows];
    hn::Store(x, kVector, bases);
    hn::Store(y, kVector, exponents);
    hn::Store(values, kVector, results);
    hn::Store(hn::IfThenElseZero(ordinary, constant(1.0)), kVector, is_ordinary);
    for (std::size_t lane = 0; lane < kVectorRows; ++lane) {
      if (is_ordinary[lane] == 0.0) results[lane] = std::pow(bases[lane], exponents[lane]);
    }
    return hn::Load(kVector, results);
  }
};

struct Power {
  HWY_INLINE Vector operator()(Vector x, Vector y) const {
    const Pair log = logarithm_pair(x);
    return PowerOfLogarithm()(x, y, log.high, log.low);
  }
};

// ---------------------------------------------------------------- trigonometry, by Highway

/// Where x is zero, x: its sign is lost otherwise.
HWY_INLINE Vector keep_zero(Vector x, Vector result) {
  return hn::IfThenElse(hn::Eq(x, hn::Zero(kVector)), x, result);
}

struct OrdinarySine {
  static HWY_INLINE Mask is_ordinary(Vector x) { return is_within(x, 39000.0); }
  static HWY_INLINE Vector ordinary(Vector x) { return keep_zero(x, hn::Sin(kVector, x)); }
  static double other(double x) { return std::sin(x); }
};
using Sine = Everywhere<OrdinarySine>;

struct OrdinaryCosine {
  static HWY_INLINE Mask is_ordinary(Vector x) { return is_within(x, 39000.0); }
  static HWY_INLINE Vector ordinary(Vector x) { return hn::Cos(kVector, x); }
  static double other(double x) { return std::cos(x); }
};
using Cosine = Everywhere<OrdinaryCosine>;

struct OrdinaryTangent {
  static HWY_INLINE Mask is_ordinary(Vector x) { return is_within(x, 39000.0); }
  static HWY_INLINE Vector ordinary(Vector x) {
    return keep_zero(x, hn::Div(hn::Sin(kVector, x), hn::Cos(kVector, x)));
  }
  static double other(double x) { return std::tan(x); }
};
using Tangent = Everywhere<OrdinaryTangent>;

struct OrdinaryArcSine {
  static HWY_INLINE Mask is_ordinary(Vector x) { return is_within(x, 1.0); }
  static HWY_INLINE Vector ordinary(Vector x) { return hn::Asin(kVector, x); }
  static double other(double x) { return std::asin(x); }
};
using ArcSine = Everywhere<OrdinaryArcSine>;

struct OrdinaryArcCosine {
  static HWY_INLINE Mask is_ordinary(Vector x) { return is_within(x, 1.0); }
  static HWY_INLINE Vector ordinary(Vector x) { return hn::Acos(kVector, x); }
  static double other(double x) { return std::acos(x); }
};
using ArcCosine = Everywhere<OrdinaryArcCosine>;

struct OrdinaryArcTangent {
  static HWY_INLINE Mask is_ordinary(Vector x) { return is_within(x, kLargest); }
  static HWY_INLINE Vector ordinary(Vector x) { return hn::Atan(kVector, x); }
  static double other(double x) { return std::atan(x); }
};
using ArcTangent = Everywhere<OrdinaryArcTangent>;

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace silvafit::data
HWY_AFTER_NAMESPACE();

#endif
