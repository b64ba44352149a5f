// SPDX-License-Identifier: MIT
#include "linear_mixed_profile.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <type_traits>

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

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
  /// Numbers that one group keeps: the triangle U of A = U U', and U^-1 L'Z'[X w].
  Index kept() const { return size * size + size * width; }
};

/// The log of a product of many numbers that are at least one, with few logarithms.
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

/// What the likelihood's derivative by a symmetric matrix of cross products is: F F', and the
/// vectors of F in a row each.
struct Adjoint {
  Index count = 0;
  std::vector<double> vectors{};  ///< (count x width)
};

/// Numbers on the stack where their count is known to the compiler: it then sees that nothing else
/// changes them.
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

/// What derivatives of one group are added to.
struct Derivatives {
  double* spherical = nullptr;      ///< (size) v for the first vector of the adjoint, is set
  double* by_factor = nullptr;      ///< (size x size) row by row
  double* by_covariance = nullptr;  ///< (size x size)
  double* by_products = nullptr;    ///< (width x width), or null
  Adjoint* inside = nullptr;        ///< the derivative by the cross products as vectors, or null
};

/// The algebra of one level; the numbers of effects and columns are known to the compiler where
/// they are small.
template <int kSize, int kWidth>
class LevelAlgebra {
 public:
  explicit LevelAlgebra(const Level& level) : level_(level) {}

  /// Fills what a group keeps from its cross products: the triangle U of A = U U' with the inverse
  /// of its diagonal, and U^-1 L'Z'[X w].
  void take_out(const double* products, double* kept, LogOfProduct& determinant) const {
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

  /// Adds what is left of the cross products to a sum.
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

  /// \param from  the derivative by what is left of the cross products
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

  /// The part of log|A| / 2.
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

/// One evaluation: sums over groups and clusters on the way up, derivatives on the way down.
template <int kInner, int kWidth>
class Evaluation {
 public:
  Evaluation(const LinearMixedModel& model,
             const RelativeFactors& factors,
             const VectorXd& displacement)
      : model_(model),
        moments_(model.moments),
        displacement_(displacement),
        term_weights_(moments_.term_weights(displacement)),
        is_displaced_(displacement.size() > 0 && !displacement.isZero(0.0)),
        width_(moments_.width()),
        inner_(model.random.inner, factors.inner, width_),
        outer_(model.random.outer, factors.outer, width_),
        inner_algebra_(inner_),
        outer_algebra_(outer_),
        products_(static_cast<std::size_t>(width_ * width_)) {}

  LinearMixedProfile run(bool with_derivatives) {
    sum_up();
    LinearMixedProfile result = solve();
    if (result.is_valid && with_derivatives) differentiate(result);
    return result;
  }

 private:
  bool has_clusters() const { return outer_.size > 0; }
  Index clusters() const { return static_cast<Index>(model_.random.cluster_begin.size()) - 1; }
  double* kept(Index group) { return inner_kept_.data() + group * inner_.kept(); }
  double* cluster_kept(Index cluster) { return outer_kept_.data() + cluster * outer_.kept(); }
  double* cluster_products(Index cluster) {
    return cluster_products_.data() + cluster * width_ * width_;
  }

  /// The cross products of a group at the displacement.
  const double* products(Index group) {
    if (!is_displaced_) return moments_.term(group, 0);
    const Index size = width_ * width_;
    const double* const terms = moments_.term(group, 0);
    for (Index k = 0; k < size; ++k) products_[k] = term_weights_[0] * terms[k];
    for (Index term = 1; term < moments_.terms(); ++term) {
      const double weight = term_weights_[term];
      const double* const of = terms + term * size;
      for (Index k = 0; k < size; ++k) products_[k] += weight * of[k];
    }
    return products_.data();
  }

  void sum_up() {
    const Index size = width_ * width_;
    inner_kept_.resize(static_cast<std::size_t>(moments_.groups() * inner_.kept()));
    total_.setZero(width_, width_);
    if (!has_clusters()) {
      for (Index group = 0; group < moments_.groups(); ++group) add_group(group, total_.data());
      return;
    }
    outer_kept_.resize(static_cast<std::size_t>(clusters() * outer_.kept()));
    cluster_products_.assign(static_cast<std::size_t>(clusters() * size), 0.0);
    for (Index cluster = 0; cluster < clusters(); ++cluster) {
      const Index end = model_.random.cluster_begin[cluster + 1];
      for (Index group = model_.random.cluster_begin[cluster]; group < end; ++group) {
        add_group(group, cluster_products(cluster));
      }
      outer_algebra_.take_out(cluster_products(cluster), cluster_kept(cluster), determinant_);
      outer_algebra_.add_remainder(cluster_products(cluster), cluster_kept(cluster), total_.data());
    }
  }

  void add_group(Index group, double* sum) {
    const double* const of = products(group);
    inner_algebra_.take_out(of, kept(group), determinant_);
    inner_algebra_.add_remainder(of, kept(group), sum);
  }

  LinearMixedProfile solve() {
    LinearMixedProfile result;
    const Index p = width_ - 1;
    result.information = total_.topLeftCorner(p, p);
    information_.compute(result.information);
    if (information_.info() != Eigen::Success) return result;
    const VectorXd right = total_.col(p).head(p);
    result.coefficients = information_.solve(right);
    result.sum_of_squares = total_(p, p) - result.coefficients.dot(right);
    const double freedom = static_cast<double>(model_.observations - (model_.restricted ? p : 0));
    result.sigma2 = result.sum_of_squares / freedom;
    if (!(result.sigma2 > 0.0)) return result;
    result.minus_log_likelihood =
        0.5 * freedom * (std::log(2.0 * std::numbers::pi * result.sigma2) + 1.0) +
        determinant_.value() + moments_.sum_log_at(displacement_);
    if (model_.restricted) {
      const MatrixXd& triangle = information_.matrixLLT();
      result.minus_log_likelihood +=
          triangle.diagonal().array().log().sum() + 0.5 * model_.log_units;
    }
    result.is_valid = std::isfinite(result.minus_log_likelihood);
    return result;
  }

  /// dF / d total: the residuals' part of S and, restricted, that of log|X'V^-1 X| / 2.
  Adjoint adjoint_of_total(const LinearMixedProfile& at) const {
    const Index p = width_ - 1;
    Adjoint result{.count = 1};
    const double scale = 1.0 / std::sqrt(2.0 * at.sigma2);
    for (const double value : at.coefficients) result.vectors.push_back(-value * scale);
    result.vectors.push_back(scale);
    if (!model_.restricted) return result;
    const MatrixXd inverse = information_.matrixL().solve(MatrixXd::Identity(p, p));
    for (Index k = 0; k < p; ++k) {
      for (Index c = 0; c < p; ++c) {
        result.vectors.push_back(std::numbers::sqrt2 / 2.0 * inverse(k, c));
      }
      result.vectors.push_back(0.0);
      ++result.count;
    }
    return result;
  }

  void differentiate(LinearMixedProfile& result) {
    const Index q = inner_.size;
    const Index r = outer_.size;
    result.spherical.resize(q, moments_.groups());
    // Row by row here, and put upright at the end.
    result.by_factor = {.inner = MatrixXd::Zero(q, q), .outer = MatrixXd::Zero(r, r)};
    result.by_covariance = result.by_factor;
    by_term_ = VectorXd::Zero(moments_.terms());
    const Adjoint of_total = adjoint_of_total(result);
    if (!has_clusters()) {
      for (Index group = 0; group < moments_.groups(); ++group) {
        differentiate_group(group, of_total, result);
      }
    } else {
      result.outer_spherical.resize(r, clusters());
      for (Index cluster = 0; cluster < clusters(); ++cluster) {
        Adjoint inside;
        outer_algebra_.differentiate(cluster_products(cluster),
                                     cluster_kept(cluster),
                                     of_total,
                                     {.spherical = result.outer_spherical.col(cluster).data(),
                                      .by_factor = result.by_factor.outer.data(),
                                      .by_covariance = result.by_covariance.outer.data(),
                                      .inside = &inside});
        const Index end = model_.random.cluster_begin[cluster + 1];
        for (Index group = model_.random.cluster_begin[cluster]; group < end; ++group) {
          differentiate_group(group, inside, result);
        }
      }
    }
    // The residuals were divided by sqrt(2) sigma.
    const double scale = std::sqrt(2.0 * result.sigma2);
    result.spherical *= scale;
    result.outer_spherical *= scale;
    result.by_factor.inner.transposeInPlace();
    result.by_factor.outer.transposeInPlace();
    result.by_variance = moments_.by_displacement(by_term_, displacement_) +
                         moments_.sum_log_gradient(displacement_);
  }

  void differentiate_group(Index group, const Adjoint& from, LinearMixedProfile& result) {
    const bool varies = moments_.parameters() > 0;
    const Index size = width_ * width_;
    const double* const of = products(group);
    by_products_.assign(static_cast<std::size_t>(size), 0.0);
    inner_algebra_.differentiate(of,
                                 kept(group),
                                 from,
                                 {.spherical = result.spherical.col(group).data(),
                                  .by_factor = result.by_factor.inner.data(),
                                  .by_covariance = result.by_covariance.inner.data(),
                                  .by_products = varies ? by_products_.data() : nullptr});
    if (!varies) return;
    for (Index term = 0; term < moments_.terms(); ++term) {
      const double* const by = moments_.term(group, term);
      double sum = 0.0;
      for (Index k = 0; k < size; ++k) sum += by_products_[k] * by[k];
      by_term_[term] += sum;
    }
  }

  const LinearMixedModel& model_;
  const GroupMoments& moments_;
  const VectorXd& displacement_;
  VectorXd term_weights_;
  bool is_displaced_;
  Index width_;
  Level inner_;
  Level outer_;
  LevelAlgebra<kInner, kWidth> inner_algebra_;
  LevelAlgebra<0, 0> outer_algebra_;
  std::vector<double> products_;
  std::vector<double> inner_kept_;
  std::vector<double> outer_kept_;
  std::vector<double> cluster_products_;
  std::vector<double> by_products_;
  LogOfProduct determinant_;
  MatrixXd total_;
  Eigen::LLT<MatrixXd> information_;
  VectorXd by_term_;
};

}  // namespace

GroupMoments::GroupMoments(Index width,
                           Index groups,
                           Index parameters,
                           std::vector<std::pair<Index, Index>> pairs)
    : width_(width), parameters_(parameters), pairs_(std::move(pairs)) {
  products_.setZero(width * width * terms(), groups);
  sum_log_.setZero(terms());
  centre_.setZero(parameters);
}

void GroupMoments::divide_columns(const VectorXd& sizes) {
  VectorXd divisors = VectorXd::Ones(width_);
  divisors.head(width_ - 1) = sizes;
  const VectorXd factor = divisors.cwiseInverse();
  for (Index group = 0; group < groups(); ++group) {
    for (Index t = 0; t < terms(); ++t) {
      Eigen::Map<MatrixXd> products(term(group, t), width_, width_);
      products = factor.asDiagonal() * products * factor.asDiagonal();
    }
  }
}

VectorXd GroupMoments::term_weights(const VectorXd& displacement) const {
  const double s = displacement.dot(centre_);
  VectorXd weights(terms());
  weights[0] = 1.0 + 2.0 * s + 2.0 * s * s;
  weights.segment(1, parameters_) = (1.0 + 2.0 * s) * displacement;
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const auto [i, j] = pairs_[k];
    weights[1 + parameters_ + static_cast<Index>(k)] =
        displacement[i] * displacement[j] * (i == j ? 0.5 : 1.0);
  }
  return std::exp(-2.0 * s) * weights;
}

VectorXd GroupMoments::by_displacement(const VectorXd& by_term,
                                       const VectorXd& displacement) const {
  const double s = displacement.dot(centre_);
  const auto by_first = by_term.segment(1, parameters_);
  VectorXd result = (1.0 + 2.0 * s) * by_first;
  double by_s = -4.0 * s * s * by_term[0] - 4.0 * s * by_first.dot(displacement);
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const auto [i, j] = pairs_[k];
    const double value = by_term[1 + parameters_ + static_cast<Index>(k)];
    result[i] += value * displacement[j];
    if (i != j) result[j] += value * displacement[i];
    by_s -= 2.0 * value * displacement[i] * displacement[j] * (i == j ? 0.5 : 1.0);
  }
  return std::exp(-2.0 * s) * (result + by_s * centre_);
}

double GroupMoments::sum_log_at(const VectorXd& displacement) const {
  double sum = sum_log_[0] + sum_log_.segment(1, parameters_).dot(displacement);
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const auto [i, j] = pairs_[k];
    sum += sum_log_[1 + parameters_ + static_cast<Index>(k)] * displacement[i] * displacement[j] *
           (i == j ? 0.5 : 1.0);
  }
  return sum;
}

VectorXd GroupMoments::sum_log_gradient(const VectorXd& displacement) const {
  VectorXd result = sum_log_.segment(1, parameters_);
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const auto [i, j] = pairs_[k];
    const double value = sum_log_[1 + parameters_ + static_cast<Index>(k)];
    result[i] += value * displacement[j];
    if (i != j) result[j] += value * displacement[i];
  }
  return result;
}

namespace {

template <int kInner>
LinearMixedProfile profile_of_width(const LinearMixedModel& model,
                                    const RelativeFactors& factors,
                                    const VectorXd& displacement,
                                    bool with_derivatives) {
  const auto run = [&]<int kWidth>() {
    return Evaluation<kInner, kWidth>(model, factors, displacement).run(with_derivatives);
  };
  switch (model.moments.width()) {
    case 3:
      return run.template operator()<3>();
    case 4:
      return run.template operator()<4>();
    case 5:
      return run.template operator()<5>();
    case 6:
      return run.template operator()<6>();
    default:
      return run.template operator()<0>();
  }
}

}  // namespace

LinearMixedProfile profile(const LinearMixedModel& model,
                           const RelativeFactors& factors,
                           const VectorXd& displacement,
                           bool with_derivatives) {
  switch (model.random.inner.size()) {
    case 1:
      return profile_of_width<1>(model, factors, displacement, with_derivatives);
    case 2:
      return profile_of_width<2>(model, factors, displacement, with_derivatives);
    case 3:
      return profile_of_width<3>(model, factors, displacement, with_derivatives);
    default:
      return Evaluation<0, 0>(model, factors, displacement).run(with_derivatives);
  }
}

VectorXd expected_squares(const LinearMixedModel& model,
                          const RelativeFactors& factors,
                          const LinearMixedProfile& at) {
  const GroupMoments& moments = model.moments;
  const Index p = moments.width() - 1;
  const MatrixXd effects = factors.inner * at.spherical;
  const MatrixXd outer_effects = factors.outer * at.outer_spherical;
  VectorXd result(moments.groups());
  VectorXd combination(p + 1);
  Index cluster = 0;
  for (Index group = 0; group < moments.groups(); ++group) {
    combination.head(p) = -at.coefficients;
    combination[p] = 1.0;
    for (std::size_t k = 0; k < model.random.inner.size(); ++k) {
      combination[model.random.inner[k]] -= effects(static_cast<Index>(k), group);
    }
    if (!model.random.outer.empty()) {
      while (group >= model.random.cluster_begin[cluster + 1]) ++cluster;
      for (std::size_t k = 0; k < model.random.outer.size(); ++k) {
        combination[model.random.outer[k]] -= outer_effects(static_cast<Index>(k), cluster);
      }
    }
    const Eigen::Map<const MatrixXd> products(moments.term(group, 0), p + 1, p + 1);
    result[group] = combination.dot(products * combination);
  }
  return result;
}

}  // namespace silvafit::fit
