// SPDX-License-Identifier: MIT
// Elimination of the random effects of one grouping from cross products, with derivatives.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>
#include <vector>

#include "likelihood/profile_sums.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit::level_algebra {

/// The random effects of one grouping: their columns and L, row by row.
struct Level {
  const Index* columns = nullptr;
  Index size = 0;
  Index width = 0;
  std::vector<double> factor{};

  Level(const std::vector<Index>& of, const MatrixXd& l, Index moments_width)
      : columns(of.data()), size(static_cast<Index>(of.size())), width(moments_width) {
    factor.resize(static_cast<std::size_t>(size * size));
    for (Index i = 0; i < size; ++i) {
      for (Index k = 0; k < size; ++k) factor[i * size + k] = k <= i ? l(i, k) : 0.0;
    }
  }
  /// Stored numbers of a group: the triangle U of A = U U', and U^-1 L'Z'[X w].
  Index kept() const { return size * size + size * width; }
};

/// The log of a product of many numbers >= 1, with few evaluations of the logarithm.
class LogOfProduct {
 public:
  void multiply(double value) {
    product_ *= value;
    if (product_ > 1e200) {
      sum_ += std::log(product_);
      product_ = 1.0;
    }
  }
  double value() const { return sum_ + std::log(product_); }

 private:
  double product_ = 1.0;
  double sum_ = 0.0;
};

/// Numbers on the stack if their count is known at compile time, so that the compiler can exclude
/// aliasing.
template <int kCount>
using Buffer = std::conditional_t<(kCount > 0), std::array<double, kCount>, std::vector<double>>;

template <int kCount>
Buffer<kCount> zeros(Index count) {
  if constexpr (kCount > 0) {
    return {};
  } else {
    return std::vector<double>(static_cast<std::size_t>(count));
  }
}

/// The sums to which the derivatives of a group are added.
struct Derivatives {
  double* spherical = nullptr;      ///< (size) v for the first vector of the adjoint, is set
  double* by_factor = nullptr;      ///< (size x size) row by row
  double* by_covariance = nullptr;  ///< (size x size)
  double* by_products = nullptr;    ///< (width x width), or null
  Adjoint* inside = nullptr;        ///< the derivative by the cross products as vectors, or null
};

/// The algebra of one level; small numbers of effects and columns are compile-time constants.
template <int kSize, int kWidth>
class LevelAlgebra {
 public:
  explicit LevelAlgebra(const Level& level) : level_(level) {}

  /// Computes the stored numbers of a group from its cross products: the triangle U of A = U U'
  /// with the inverse of its diagonal, and U^-1 L'Z'[X w].
  void eliminate(const double* products, double* kept, LogOfProduct& determinant) const {
    const Index q = size();
    const Index w = width();
    const auto l = factor();
    auto triangle = zeros<kSize * kSize>(q * q);
    auto half = zeros<kSize * kWidth>(q * w);
    for (Index k = 0; k < q; ++k) {
      for (Index i = k; i < q; ++i) {
        const double* const of = products + level_.columns[i] * w;
        for (Index c = 0; c < w; ++c) half[k * w + c] += l[i * q + k] * of[c];
      }
    }
    double product = 1.0;
    for (Index k = 0; k < q; ++k) {
      for (Index j = 0; j <= k; ++j) {
        double value = k == j ? 1.0 : 0.0;
        for (Index i = j; i < q; ++i) {
          value += half[k * w + level_.columns[i]] * l[i * q + j];
        }
        for (Index i = 0; i < j; ++i) value -= triangle[k * q + i] * triangle[j * q + i];
        if (k == j) {
          const double root = std::sqrt(value);
          product *= root;
          triangle[k * q + k] = 1.0 / root;
        } else {
          triangle[k * q + j] = value * triangle[j * q + j];
        }
      }
      for (Index i = 0; i < k; ++i) {
        const double u = triangle[k * q + i];
        for (Index c = 0; c < w; ++c) half[k * w + c] -= u * half[i * w + c];
      }
      for (Index c = 0; c < w; ++c) half[k * w + c] *= triangle[k * q + k];
    }
    determinant.multiply(product);
    std::copy_n(triangle.data(), q * q, kept);
    std::copy_n(half.data(), q * w, kept + q * q);
  }

  /// Adds the reduced cross products to a sum.
  void add_remainder(const double* products, const double* kept, double* sum) const {
    const Index q = size();
    const Index w = width();
    const double* const half = kept + q * q;
    for (Index a = 0; a < w; ++a) {
      auto row = zeros<kWidth>(w);
      for (Index c = 0; c < w; ++c) row[c] = products[a * w + c];
      for (Index k = 0; k < q; ++k) {
        const double share = half[k * w + a];
        for (Index c = 0; c < w; ++c) row[c] -= share * half[k * w + c];
      }
      for (Index c = 0; c < w; ++c) sum[a * w + c] += row[c];
    }
  }

  /// \param from  the derivative by the reduced cross products
  void differentiate(const double* products,
                     const double* kept,
                     const Adjoint& from,
                     const Derivatives& to) const {
    const Index q = size();
    const Index w = width();
    const auto l = factor();
    const double* const half = kept + q * q;
    auto by_factor = zeros<kSize * kSize>(q * q);
    auto by_covariance = zeros<kSize * kSize>(q * q);
    auto by_products = zeros<kWidth * kWidth>(w * w);
    for (Index f = 0; f < from.count; ++f) {
      const double* const given = from.vectors.data() + f * w;
      auto v = zeros<kSize>(q);
      auto t = zeros<kWidth>(w);
      auto s = zeros<kSize>(q);
      for (Index k = 0; k < q; ++k) {
        for (Index c = 0; c < w; ++c) v[k] += half[k * w + c] * given[c];
      }
      solve_transposed(kept, v.data());
      for (Index c = 0; c < w; ++c) t[c] = given[c];
      for (Index i = 0; i < q; ++i) {
        for (Index k = 0; k <= i; ++k) t[level_.columns[i]] -= l[i * q + k] * v[k];
      }
      for (Index i = 0; i < q; ++i) {
        const double* const of = products + level_.columns[i] * w;
        for (Index c = 0; c < w; ++c) s[i] += of[c] * t[c];
      }
      for (Index i = 0; i < q; ++i) {
        for (Index k = 0; k <= i; ++k) by_factor[i * q + k] -= 2.0 * s[i] * v[k];
        for (Index k = 0; k < q; ++k) by_covariance[i * q + k] -= s[i] * s[k];
      }
      if (f == 0) std::copy_n(v.data(), q, to.spherical);
      add_vector(t.data(), by_products.data(), to);
    }
    by_determinant(products, kept, by_factor.data(), by_covariance.data(), by_products.data(), to);
    for (Index k = 0; k < q * q; ++k) to.by_factor[k] += by_factor[k];
    for (Index k = 0; k < q * q; ++k) to.by_covariance[k] += by_covariance[k];
    if (to.by_products == nullptr) return;
    for (Index k = 0; k < w * w; ++k) to.by_products[k] += by_products[k];
  }

 private:
  Index size() const {
    if constexpr (kSize > 0) {
      return kSize;
    } else {
      return level_.size;
    }
  }
  Index width() const {
    if constexpr (kWidth > 0) {
      return kWidth;
    } else {
      return level_.width;
    }
  }
  Buffer<kSize * kSize> factor() const {
    auto l = zeros<kSize * kSize>(size() * size());
    std::ranges::copy(level_.factor, l.begin());
    return l;
  }

  /// x becomes U^-T x.
  void solve_transposed(const double* triangle, double* x) const {
    const Index q = size();
    for (Index k = q - 1; k >= 0; --k) {
      for (Index i = k + 1; i < q; ++i) x[k] -= triangle[i * q + k] * x[i];
      x[k] *= triangle[k * q + k];
    }
  }

  /// A vector t of the derivative t t' by the cross products.
  void add_vector(const double* t, double* by_products, const Derivatives& to) const {
    const Index w = width();
    if (to.by_products != nullptr) {
      for (Index a = 0; a < w; ++a) {
        for (Index c = 0; c < w; ++c) by_products[a * w + c] += t[a] * t[c];
      }
    }
    if (to.inside != nullptr) {
      to.inside->vectors.insert(to.inside->vectors.end(), t, t + w);
      ++to.inside->count;
    }
  }

  /// The derivative of log|A| / 2.
  void by_determinant(const double* products,
                      const double* kept,
                      double* by_factor,
                      double* by_covariance,
                      double* by_products,
                      const Derivatives& to) const {
    const Index q = size();
    const Index w = width();
    const double* const half = kept + q * q;
    for (Index i = 0; i < q; ++i) {
      // Z'Z L A^-1 = (A^-1 L'Z'Z)'.
      auto v = zeros<kSize>(q);
      for (Index k = 0; k < q; ++k) v[k] = half[k * w + level_.columns[i]];
      solve_transposed(kept, v.data());
      for (Index k = 0; k <= i; ++k) by_factor[i * q + k] += v[k];
      for (Index j = 0; j < q; ++j) {
        double value = products[level_.columns[i] * w + level_.columns[j]];
        for (Index k = 0; k < q; ++k) {
          value -= half[k * w + level_.columns[i]] * half[k * w + level_.columns[j]];
        }
        by_covariance[i * q + j] += 0.5 * value;
      }
    }
    if (to.by_products == nullptr && to.inside == nullptr) return;
    // L A^-1 L' = Y'Y with Y = U^-1 L', whose row k is L times column k of U^-T.
    const auto l = factor();
    for (Index k = 0; k < q; ++k) {
      auto v = zeros<kSize>(q);
      auto t = zeros<kWidth>(w);
      v[k] = std::numbers::sqrt2 / 2.0;
      solve_transposed(kept, v.data());
      for (Index i = 0; i < q; ++i) {
        for (Index j = 0; j <= i; ++j) t[level_.columns[i]] += l[i * q + j] * v[j];
      }
      add_vector(t.data(), by_products, to);
    }
  }

  const Level& level_;
};

}  // namespace silvafit::fit::level_algebra
