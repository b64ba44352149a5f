// SPDX-License-Identifier: MIT
// Trigonometric functions of vectors, by Highway.

// An include guard that opens again for the next instruction set.
#if defined(SILVAFIT_DATA_VECTOR_TRIGONOMETRY_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SILVAFIT_DATA_VECTOR_TRIGONOMETRY_INL
#undef SILVAFIT_DATA_VECTOR_TRIGONOMETRY_INL
#else
#define SILVAFIT_DATA_VECTOR_TRIGONOMETRY_INL
#endif

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include <cmath>

#include "program/vector_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace silvafit::data {
namespace HWY_NAMESPACE {
namespace {

/// x where x is zero, because the result has lost its sign.
HWY_INLINE Vector keep_zero(Vector x, Vector result) {
  return hn::IfThenElse(hn::Eq(x, hn::Zero(kVector)), x, result);
}

HWY_INLINE Mask is_angle(Vector x) { return is_within(x, 39000.0); }

/// x where Highway's sine and cosine may be called, and zero elsewhere: they convert quadrants to
/// whole numbers, which is undefined for missing values on some processors.
HWY_INLINE Vector angle(Vector x) { return hn::IfThenElseZero(is_angle(x), x); }

struct OrdinarySine {
  static HWY_INLINE Mask is_ordinary(Vector x) { return is_angle(x); }
  static HWY_INLINE Vector ordinary(Vector x) { return keep_zero(x, hn::Sin(kVector, angle(x))); }
  static double other(double x) { return std::sin(x); }
};
using Sine = Everywhere<OrdinarySine>;

struct OrdinaryCosine {
  static HWY_INLINE Mask is_ordinary(Vector x) { return is_angle(x); }
  static HWY_INLINE Vector ordinary(Vector x) { return hn::Cos(kVector, angle(x)); }
  static double other(double x) { return std::cos(x); }
};
using Cosine = Everywhere<OrdinaryCosine>;

struct OrdinaryTangent {
  static HWY_INLINE Mask is_ordinary(Vector x) { return is_angle(x); }
  static HWY_INLINE Vector ordinary(Vector x) {
    const Vector safe = angle(x);
    return keep_zero(x, hn::Div(hn::Sin(kVector, safe), hn::Cos(kVector, safe)));
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
