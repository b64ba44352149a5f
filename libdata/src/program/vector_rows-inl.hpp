// SPDX-License-Identifier: MIT
// Vectors of consecutive rows; compiled once for each instruction set (see vector_targets.hpp).

// An include guard that opens again for the next instruction set.
#if defined(SILVAFIT_DATA_VECTOR_ROWS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SILVAFIT_DATA_VECTOR_ROWS_INL
#undef SILVAFIT_DATA_VECTOR_ROWS_INL
#else
#define SILVAFIT_DATA_VECTOR_ROWS_INL
#endif

#include <hwy/highway.h>

#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace silvafit::data {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// At most 8 rows, so that the running sums of row_sums.cpp fill whole vectors everywhere.
using VectorTag = hn::CappedTag<double, 8>;
using Vector = hn::Vec<VectorTag>;
constexpr VectorTag kVector;
constexpr std::size_t kVectorRows = hn::MaxLanes(kVector);

/// Loads a whole vector.
struct LoadAll {
  HWY_INLINE Vector operator()(const double* from) const { return hn::LoadU(kVector, from); }
};

/// Loads the first `rows` values, 0 < rows < kVectorRows; the others are zeros and are not read.
struct LoadFirst {
  [[maybe_unused]] std::size_t rows;
  HWY_INLINE Vector operator()(const double* from) const {
#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3
    return hn::MaskedLoad(hn::FirstN(kVector, rows), kVector, from);
#elif HWY_TARGET == HWY_SCALAR
    return hn::LoadU(kVector, from);  // never happens
#else
    // Vectors of two: one value is left. The masked loads of these targets read beyond it.
    static_assert(kVectorRows == 2);
    return hn::ZeroExtendVector(kVector, hn::LoadU(hn::CappedTag<double, 1>(), from));
#endif
  }
};

/// Like LoadFirst, but the lanes without a row repeat the first value, so that functions are not
/// evaluated at zeros that are not data.
HWY_INLINE Vector load_repeated(const double* from, [[maybe_unused]] std::size_t rows) {
  const Vector first = hn::Set(kVector, *from);
#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3
  const auto present = hn::FirstN(kVector, rows);
  return hn::IfThenElse(present, hn::MaskedLoad(present, kVector, from), first);
#else
  return first;
#endif
}

/// Stores the first `rows` values, 0 < rows < kVectorRows, and nothing else.
HWY_INLINE void store_first(Vector values, double* to, [[maybe_unused]] std::size_t rows) {
#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3
  hn::BlendedStore(values, hn::FirstN(kVector, rows), kVector, to);
#else
  *to = hn::GetLane(values);
#endif
}

/// The sum of all lanes, lane k with lane k + half first.
#if HWY_TARGET == HWY_SCALAR
HWY_INLINE double sum_of_lanes(VectorTag /*tag*/, Vector lanes) { return hn::GetLane(lanes); }
#else
template <typename Tag, typename Lanes>
HWY_INLINE double sum_of_lanes(Tag tag, Lanes lanes) {
  if constexpr (hn::MaxLanes(tag) == 1) {
    return hn::GetLane(lanes);
  } else {
    const hn::Half<Tag> half;
    return sum_of_lanes(half, hn::Add(hn::LowerHalf(half, lanes), hn::UpperHalf(half, lanes)));
  }
}
#endif

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace silvafit::data
HWY_AFTER_NAMESPACE();

#endif
