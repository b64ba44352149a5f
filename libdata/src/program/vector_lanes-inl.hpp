// SPDX-License-Identifier: MIT
// What functions of vectors of doubles share; compiled once for each instruction set (see
// vector_targets.hpp).
//
// Each agrees with the function of <cmath> to a few units in the last place for every argument;
// program_accuracy_test.cpp has the limits. A lane's value depends on its own argument alone.
// Arguments that a fast formula does not cover (missing, infinite, outside of its range) are
// computed by <cmath>, lane by lane.
//
// The polynomials have the least maximum error on their interval to within a factor of two
// (interpolation at Chebyshev nodes with 60 digits, coefficients then rounded).

// An include guard that opens again for the next instruction set.
#if defined(SILVAFIT_DATA_VECTOR_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SILVAFIT_DATA_VECTOR_LANES_INL
#undef SILVAFIT_DATA_VECTOR_LANES_INL
#else
#define SILVAFIT_DATA_VECTOR_LANES_INL
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "program/vector_rows-inl.hpp"

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

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace silvafit::data
HWY_AFTER_NAMESPACE();

#endif
