// SPDX-License-Identifier: MIT
#include "lindstrom_bates/linear_mixed_profile.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "lindstrom_bates/level_algebra.hpp"

namespace silvafit::fit {

using namespace level_algebra;

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// One evaluation: sums over groups and clusters on the way up, derivatives on the way down.
template <int kInner, int kWidth>
class Evaluation {
 public:
  Evaluation(const LinearMixedModel& model,
             const RelativeFactors& factors,
             const VectorXd& displacement,
             const HeldParameters& held)
      : model_(model),
        held_(held),
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
    if (held_.coefficients.size() > 0) {
      const VectorXd away = held_.coefficients - result.coefficients;
      result.sum_of_squares += away.dot(result.information * away);
      result.coefficients = held_.coefficients;
    }
    const double freedom = static_cast<double>(model_.observations - (model_.restricted ? p : 0));
    result.sigma2 = held_.sigma2 > 0.0 ? held_.sigma2 : result.sum_of_squares / freedom;
    if (!(result.sigma2 > 0.0)) return result;
    result.minus_log_likelihood =
        0.5 * freedom * (std::log(2.0 * std::numbers::pi * result.sigma2) + 1.0) +
        determinant_.value() + moments_.sum_log_at(displacement_);
    if (held_.sigma2 > 0.0) {
      result.minus_log_likelihood += 0.5 * (result.sum_of_squares / result.sigma2 - freedom);
    }
    result.by_coefficients = (result.information * result.coefficients - right) / result.sigma2;
    result.by_log_sigma = freedom - result.sum_of_squares / result.sigma2;
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
  const HeldParameters& held_;
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

template <int kInner>
LinearMixedProfile profile_of_width(const LinearMixedModel& model,
                                    const RelativeFactors& factors,
                                    const VectorXd& displacement,
                                    bool with_derivatives,
                                    const HeldParameters& held) {
  const auto run = [&]<int kWidth>() {
    return Evaluation<kInner, kWidth>(model, factors, displacement, held).run(with_derivatives);
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
                           bool with_derivatives,
                           const HeldParameters& held) {
  switch (model.random.inner.size()) {
    case 1:
      return profile_of_width<1>(model, factors, displacement, with_derivatives, held);
    case 2:
      return profile_of_width<2>(model, factors, displacement, with_derivatives, held);
    case 3:
      return profile_of_width<3>(model, factors, displacement, with_derivatives, held);
    default:
      return Evaluation<0, 0>(model, factors, displacement, held).run(with_derivatives);
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
