// SPDX-License-Identifier: MIT
#include "silvafit/data/row_sums.hpp"

#include "program/vector_targets.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "program/row_sums.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include "program/vector_rows-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace silvafit::data {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// ---------------------------------------------------------------- one sum

constexpr std::size_t kSums = 16;                      // running sums
constexpr std::size_t kVectors = kSums / kVectorRows;  // vectors that hold them

// What is added for a row, of up to three columns.
struct Value {
  const double* a;
  template <typename Load>
  HWY_INLINE Vector add_to(Vector sum, std::size_t row, Load load) const {
    return hn::Add(sum, load(a + row));
  }
};

struct Product {
  const double* a;
  const double* b;
  template <typename Load>
  HWY_INLINE Vector add_to(Vector sum, std::size_t row, Load load) const {
    return hn::MulAdd(load(a + row), load(b + row), sum);
  }
};

struct WeightedProduct {
  const double* w;
  const double* a;
  const double* b;
  template <typename Load>
  HWY_INLINE Vector add_to(Vector sum, std::size_t row, Load load) const {
    return hn::MulAdd(hn::Mul(load(w + row), load(a + row)), load(b + row), sum);
  }
};

/// Running sum k adds rows k, k + 16, k + 32 ...; then k and k + 8, k and k + 4 ... are added.
template <typename Term>
HWY_INLINE double sum_of(const Term& term, std::size_t rows) {
  Vector sums[kVectors];
  for (Vector& part : sums) part = hn::Zero(kVector);
  std::size_t row = 0;
  for (; row + kSums <= rows; row += kSums) {
    for (std::size_t k = 0; k < kVectors; ++k) {
      sums[k] = term.add_to(sums[k], row + k * kVectorRows, LoadAll());
    }
  }
  for (std::size_t k = 0; k < kVectors && row < rows; ++k, row += kVectorRows) {
    sums[k] = rows - row >= kVectorRows ? term.add_to(sums[k], row, LoadAll())
                                        : term.add_to(sums[k], row, LoadFirst{rows - row});
  }
  for (std::size_t half = kVectors / 2; half > 0; half /= 2) {
    for (std::size_t k = 0; k < half; ++k) sums[k] = hn::Add(sums[k], sums[k + half]);
  }
  return sum_of_lanes(kVector, sums[0]);
}

double sum(const double* a, std::size_t rows) { return sum_of(Value{a}, rows); }

double dot(const double* a, const double* b, std::size_t rows) {
  return sum_of(Product{a, b}, rows);
}

double weighted_dot(const double* w, const double* a, const double* b, std::size_t rows) {
  return sum_of(WeightedProduct{w, a, b}, rows);
}

void segment_sums(const double* const* columns,
                  std::size_t column_count,
                  const std::size_t* begins,
                  std::size_t segment_count,
                  double* sums) {
  for (std::size_t s = 0; s < segment_count; ++s) {
    for (std::size_t c = 0; c < column_count; ++c) {
      *sums++ = sum_of(Value{columns[c] + begins[s]}, begins[s + 1] - begins[s]);
    }
  }
}

// ---------------------------------------------------------------- all products of columns

constexpr std::size_t kProductSums = 8;  // running sums of a product
constexpr std::size_t kParts = kProductSums / kVectorRows;
// The side of the squares in which the matrix is computed: its sums, one row of columns and a
// column must fit into 32 registers with AVX-512 and NEON, else into 16.
constexpr std::size_t kSide = HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_NEON ? 4 : 3;

struct Columns {
  const double* const* columns;
  std::size_t count;
  const double* weight;
  std::size_t rows;
};

template <std::size_t kLeft, std::size_t kRight, typename Load>
HWY_INLINE void add_products(const Columns& x,
                             std::size_t left,
                             std::size_t right,
                             std::size_t row,
                             Load load,
                             Vector (&sums)[kLeft][kRight]) {
  Vector weighted[kLeft];
  for (std::size_t i = 0; i < kLeft; ++i) weighted[i] = load(x.columns[left + i] + row);
  if (x.weight != nullptr) {
    const Vector weight = load(x.weight + row);
    for (std::size_t i = 0; i < kLeft; ++i) weighted[i] = hn::Mul(weight, weighted[i]);
  }
  for (std::size_t j = 0; j < kRight; ++j) {
    const Vector value = load(x.columns[right + j] + row);
    for (std::size_t i = 0; i < kLeft; ++i) {
      sums[i][j] = hn::MulAdd(weighted[i], value, sums[i][j]);
    }
  }
}

/// The products of columns left .. left + kLeft - 1 with columns right .. right + kRight - 1.
template <std::size_t kLeft, std::size_t kRight>
void block_of_products(const Columns& x, std::size_t left, std::size_t right, double* products) {
  Vector total[kParts][kLeft][kRight];
  for (std::size_t part = 0; part < kParts; ++part) {
    Vector sums[kLeft][kRight];
    for (auto& line : sums) {
      for (Vector& value : line) value = hn::Zero(kVector);
    }
    std::size_t row = part * kVectorRows;
    for (; row + kVectorRows <= x.rows; row += kProductSums) {
      add_products<kLeft, kRight>(x, left, right, row, LoadAll(), sums);
    }
    if (row < x.rows) {
      add_products<kLeft, kRight>(x, left, right, row, LoadFirst{x.rows - row}, sums);
    }
    for (std::size_t i = 0; i < kLeft; ++i) {
      for (std::size_t j = 0; j < kRight; ++j) total[part][i][j] = sums[i][j];
    }
  }
  for (std::size_t half = kParts / 2; half > 0; half /= 2) {
    for (std::size_t part = 0; part < half; ++part) {
      for (std::size_t i = 0; i < kLeft; ++i) {
        for (std::size_t j = 0; j < kRight; ++j) {
          total[part][i][j] = hn::Add(total[part][i][j], total[part + half][i][j]);
        }
      }
    }
  }
  for (std::size_t i = 0; i < kLeft; ++i) {
    for (std::size_t j = 0; j < kRight; ++j) {
      if (right + j < left + i) continue;  // below the diagonal; the element above is used
      const double value = sum_of_lanes(kVector, total[0][i][j]);
      products[(left + i) * x.count + right + j] = value;
      products[(right + j) * x.count + left + i] = value;
    }
  }
}

template <std::size_t kLeft>
void row_of_blocks(const Columns& x, std::size_t left, double* products) {
  for (std::size_t right = left; right < x.count;) {
    const std::size_t rest = x.count - right;
    if (rest >= 4 && kSide >= 4) {
      block_of_products<kLeft, kSide>(x, left, right, products);
    } else if (rest >= 3) {
      block_of_products<kLeft, 3>(x, left, right, products);
    } else if (rest == 2) {
      block_of_products<kLeft, 2>(x, left, right, products);
    } else {
      block_of_products<kLeft, 1>(x, left, right, products);
    }
    right += rest < kSide ? rest : kSide;
  }
}

void weighted_products(const double* const* columns,
                       std::size_t column_count,
                       const double* weight,
                       std::size_t rows,
                       double* products) {
  const Columns x{columns, column_count, weight, rows};
  for (std::size_t left = 0; left < column_count; left += kSide) {
    const std::size_t rest = column_count - left;
    if (rest >= 4 && kSide >= 4) {
      row_of_blocks<kSide>(x, left, products);
    } else if (rest >= 3) {
      row_of_blocks<3>(x, left, products);
    } else if (rest == 2) {
      row_of_blocks<2>(x, left, products);
    } else {
      row_of_blocks<1>(x, left, products);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace silvafit::data
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace silvafit::data {
namespace {

HWY_EXPORT(sum);
HWY_EXPORT(dot);
HWY_EXPORT(weighted_dot);
HWY_EXPORT(segment_sums);
HWY_EXPORT(weighted_products);

}  // namespace

double sum(const double* a, std::size_t rows) { return HWY_DYNAMIC_DISPATCH(sum)(a, rows); }

double dot(const double* a, const double* b, std::size_t rows) {
  return HWY_DYNAMIC_DISPATCH(dot)(a, b, rows);
}

double weighted_dot(const double* w, const double* a, const double* b, std::size_t rows) {
  return HWY_DYNAMIC_DISPATCH(weighted_dot)(w, a, b, rows);
}

void segment_sums(std::span<const double* const> columns,
                  std::span<const std::size_t> begins,
                  double* sums) {
  if (begins.empty()) return;
  HWY_DYNAMIC_DISPATCH(segment_sums)
  (columns.data(), columns.size(), begins.data(), begins.size() - 1, sums);
}

void weighted_products(std::span<const double* const> columns,
                       const double* weight,
                       std::size_t rows,
                       double* products) {
  HWY_DYNAMIC_DISPATCH(weighted_products)(columns.data(), columns.size(), weight, rows, products);
}

}  // namespace silvafit::data
#endif  // HWY_ONCE
