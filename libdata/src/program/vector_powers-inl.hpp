// SPDX-License-Identifier: MIT
// Powers of vectors.

// An include guard that opens again for the next instruction set.
#if defined(SILVAFIT_DATA_VECTOR_POWERS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SILVAFIT_DATA_VECTOR_POWERS_INL
#undef SILVAFIT_DATA_VECTOR_POWERS_INL
#else
#define SILVAFIT_DATA_VECTOR_POWERS_INL
#endif

#include <hwy/highway.h>

#include <cmath>
#include <cstddef>

#include "program/vector_exponentials-inl.hpp"
#include "program/vector_lanes-inl.hpp"
#include "program/vector_logarithms-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace silvafit::data {
namespace HWY_NAMESPACE {
namespace {

/// x^y from the logarithm of x, which other powers of x share.
struct PowerOfLogarithm {
  HWY_INLINE Vector operator()(Vector x, Vector y, Vector high, Vector low) const {
    const Vector product = hn::Mul(y, high);
    const Vector rest = hn::MulAdd(y, low, product_error(y, high, product));
    // False for a base without a logarithm, and for results that overflow or lose digits.
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

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace silvafit::data
HWY_AFTER_NAMESPACE();

#endif
