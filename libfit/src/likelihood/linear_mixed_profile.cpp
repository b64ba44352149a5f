// SPDX-License-Identifier: MIT
#include "likelihood/linear_mixed_profile.hpp"

#include <algorithm>
#include <cmath>

#include "conditional_modes/random_places.hpp"
#include "likelihood/crossed_profile.hpp"
#include "likelihood/level_algebra.hpp"
#include "likelihood/profile_sums.hpp"
#include "silvafit/base/parallel.hpp"

namespace silvafit::fit {

using namespace level_algebra;

namespace {

// Groups per task of a thread, so many that the overhead of a task is small.
constexpr Index kPartGroups = 512;

const std::vector<Index> kNoColumns;

/// A zero matrix of the size of each factor.
RelativeFactors zeros_like(const RelativeFactors& factors) {
  RelativeFactors result;
  for (const MatrixXd& factor : factors) {
    result.emplace_back(MatrixXd::Zero(factor.rows(), factor.rows()));
  }
  return result;
}

void add(const RelativeFactors& part, RelativeFactors& sum) {
  for (std::size_t t = 0; t < sum.size(); ++t) sum[t] += part[t];
}

/// The numbers of the last term; null without terms.
double* numbers_of_last(RelativeFactors& of) { return of.empty() ? nullptr : of.back().data(); }

/// One evaluation: sums over groups and clusters in the first pass, derivatives in the second.
/// Parts of the clusters are processed in parallel and their sums added in order. Effects of groups
/// are those of the last term; those of clusters, if there are two terms, of the first.
template <int kGroup, int kWidth>
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
        factors_(factors),
        group_level_(factors.empty() ? kNoColumns : model.random.terms.back(),
                     factors.empty() ? MatrixXd(0, 0) : factors.back(),
                     width_),
        cluster_level_(factors.size() < 2 ? kNoColumns : model.random.terms.front(),
                       factors.size() < 2 ? MatrixXd(0, 0) : factors.front(),
                       width_),
        group_algebra_(group_level_),
        cluster_algebra_(cluster_level_) {
    cut_into_parts();
  }

  LinearMixedProfile run(bool with_derivatives) {
    sum_up();
    LinearMixedProfile result = sums_.solve(model_, displacement_, held_);
    if (result.is_valid && with_derivatives) differentiate(result);
    return result;
  }

 private:
  /// Consecutive clusters, with their share of all sums.
  struct Part {
    Index begin = 0;  ///< first cluster
    Index end = 0;
    std::vector<double> products{};  ///< memory for the cross products of one group
    std::vector<double> by_products{};
    LogOfProduct determinant{};
    MatrixXd total{};
    RelativeFactors by_factor{};
    RelativeFactors by_covariance{};
    VectorXd by_term{};
  };

  bool has_clusters() const { return cluster_level_.size > 0; }
  Index clusters() const { return static_cast<Index>(model_.random.cluster_begin.size()) - 1; }
  double* kept(Index group) { return group_kept_.data() + group * group_level_.kept(); }
  double* cluster_kept(Index cluster) {
    return cluster_kept_.data() + cluster * cluster_level_.kept();
  }
  double* cluster_products(Index cluster) {
    return cluster_products_.data() + cluster * width_ * width_;
  }
  /// The groups of a cluster; without clusters each group is one.
  Index first_group(Index cluster) const {
    return has_clusters() ? model_.random.cluster_begin[static_cast<std::size_t>(cluster)]
                          : cluster;
  }

  void cut_into_parts() {
    const Index count = has_clusters() ? clusters() : moments_.groups();
    Index begin = 0;
    for (Index cluster = 0; cluster < count; ++cluster) {
      const bool is_last = cluster + 1 == count;
      if (first_group(cluster + 1) - first_group(begin) < kPartGroups && !is_last) continue;
      parts_.push_back({.begin = begin, .end = cluster + 1});
      begin = cluster + 1;
    }
  }

  template <typename Work>
  void for_each_part(const Work& work) {
    parallel_for(parts_.size(), model_.threads, [&](std::size_t k) { work(parts_[k]); });
  }

  /// The cross products of a group at the displacement.
  const double* products(Index group, Part& part) const {
    if (!is_displaced_) return moments_.term(group, 0);
    const Index size = width_ * width_;
    const double* const terms = moments_.term(group, 0);
    part.products.resize(static_cast<std::size_t>(size));
    for (Index k = 0; k < size; ++k) part.products[k] = term_weights_[0] * terms[k];
    for (Index term = 1; term < moments_.terms(); ++term) {
      const double weight = term_weights_[term];
      const double* const of = terms + term * size;
      for (Index k = 0; k < size; ++k) part.products[k] += weight * of[k];
    }
    return part.products.data();
  }

  void sum_up() {
    group_kept_.resize(static_cast<std::size_t>(moments_.groups() * group_level_.kept()));
    if (has_clusters()) {
      cluster_kept_.resize(static_cast<std::size_t>(clusters() * cluster_level_.kept()));
      cluster_products_.assign(static_cast<std::size_t>(clusters() * width_ * width_), 0.0);
    }
    for_each_part([this](Part& part) { sum_up(part); });
    sums_.total.setZero(width_, width_);
    for (const Part& part : parts_) {
      sums_.total += part.total;
      sums_.log_determinant += part.determinant.value();
    }
  }

  void sum_up(Part& part) {
    part.total.setZero(width_, width_);
    for (Index cluster = part.begin; cluster < part.end; ++cluster) {
      double* const sum = has_clusters() ? cluster_products(cluster) : part.total.data();
      for (Index group = first_group(cluster); group < first_group(cluster + 1); ++group) {
        add_group(group, part, sum);
      }
      if (!has_clusters()) continue;
      cluster_algebra_.eliminate(sum, cluster_kept(cluster), part.determinant);
      cluster_algebra_.add_remainder(sum, cluster_kept(cluster), part.total.data());
    }
  }

  void add_group(Index group, Part& part, double* sum) {
    const double* const of = products(group, part);
    group_algebra_.eliminate(of, kept(group), part.determinant);
    group_algebra_.add_remainder(of, kept(group), sum);
  }

  void differentiate(LinearMixedProfile& result) {
    for (std::size_t t = 0; t < factors_.size(); ++t) {
      const bool is_last = t + 1 == factors_.size();
      result.spherical.emplace_back(factors_[t].rows(), is_last ? moments_.groups() : clusters());
    }
    // Stored by rows here, and transposed at the end.
    result.by_factor = result.by_covariance = zeros_like(factors_);
    const Adjoint of_total = sums_.adjoint(model_, result);
    for_each_part([&](Part& part) { differentiate(part, of_total, result); });
    VectorXd by_term = VectorXd::Zero(moments_.terms());
    for (const Part& part : parts_) {
      add(part.by_factor, result.by_factor);
      add(part.by_covariance, result.by_covariance);
      by_term += part.by_term;
    }
    // The residuals were divided by sqrt(2) sigma.
    const double scale = std::sqrt(2.0 * result.sigma2);
    for (MatrixXd& spherical : result.spherical) spherical *= scale;
    for (MatrixXd& by_factor : result.by_factor) by_factor.transposeInPlace();
    result.by_variance =
        moments_.by_displacement(by_term, displacement_) + moments_.sum_log_gradient(displacement_);
  }

  void differentiate(Part& part, const Adjoint& of_total, LinearMixedProfile& result) {
    part.by_factor = part.by_covariance = zeros_like(factors_);
    part.by_term = VectorXd::Zero(moments_.terms());
    for (Index cluster = part.begin; cluster < part.end; ++cluster) {
      Adjoint inside;
      if (has_clusters()) {
        cluster_algebra_.differentiate(cluster_products(cluster),
                                       cluster_kept(cluster),
                                       of_total,
                                       {.spherical = result.spherical.front().col(cluster).data(),
                                        .by_factor = part.by_factor.front().data(),
                                        .by_covariance = part.by_covariance.front().data(),
                                        .inside = &inside});
      }
      const Adjoint& from = has_clusters() ? inside : of_total;
      for (Index group = first_group(cluster); group < first_group(cluster + 1); ++group) {
        differentiate_group(group, from, part, result);
      }
    }
  }

  void differentiate_group(Index group,
                           const Adjoint& from,
                           Part& part,
                           LinearMixedProfile& result) {
    const bool varies = moments_.parameters() > 0;
    const Index size = width_ * width_;
    const double* const of = products(group, part);
    part.by_products.assign(static_cast<std::size_t>(size), 0.0);
    group_algebra_.differentiate(
        of,
        kept(group),
        from,
        {.spherical = factors_.empty() ? nullptr : result.spherical.back().col(group).data(),
         .by_factor = numbers_of_last(part.by_factor),
         .by_covariance = numbers_of_last(part.by_covariance),
         .by_products = varies ? part.by_products.data() : nullptr});
    if (!varies) return;
    for (Index term = 0; term < moments_.terms(); ++term) {
      const double* const by = moments_.term(group, term);
      double sum = 0.0;
      for (Index k = 0; k < size; ++k) sum += part.by_products[k] * by[k];
      part.by_term[term] += sum;
    }
  }

  const LinearMixedModel& model_;
  const HeldParameters& held_;
  const GroupMoments& moments_;
  const VectorXd& displacement_;
  VectorXd term_weights_;
  bool is_displaced_;
  Index width_;
  const RelativeFactors& factors_;
  Level group_level_;
  Level cluster_level_;
  LevelAlgebra<kGroup, kWidth> group_algebra_;
  LevelAlgebra<0, 0> cluster_algebra_;
  std::vector<Part> parts_;
  std::vector<double> group_kept_;
  std::vector<double> cluster_kept_;
  std::vector<double> cluster_products_;
  ProfileSums sums_;
};

template <int kGroup>
LinearMixedProfile profile_of_width(const LinearMixedModel& model,
                                    const RelativeFactors& factors,
                                    const VectorXd& displacement,
                                    bool with_derivatives,
                                    const HeldParameters& held) {
  const auto run = [&]<int kWidth>() {
    return Evaluation<kGroup, kWidth>(model, factors, displacement, held).run(with_derivatives);
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
  if (model.random.crossed) {
    return crossed_profile(model, factors, displacement, with_derivatives, held);
  }
  switch (model.random.terms.empty() ? 0 : model.random.terms.back().size()) {
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
  const Index w = moments.width();
  std::vector<MatrixXd> effects;
  for (std::size_t t = 0; t < factors.size(); ++t) {
    effects.emplace_back(factors[t] * at.spherical[t]);
  }
  if (model.random.crossed) {
    const RandomPlaces places(model.random.terms);
    VectorXd fixed(w);
    fixed << -at.coefficients, VectorXd::Zero(model.random_only), 1.0;
    double sum = fixed.dot(moments.total(0) * fixed);
    for (Index cell = 0; cell < moments.groups(); ++cell) {
      VectorXd change = VectorXd::Zero(places.r());
      for (std::size_t t = 0; t < effects.size(); ++t) {
        const Index of = model.random.of_groups[t][static_cast<std::size_t>(cell)];
        change(places.rows[t]) -= effects[t].col(of);
      }
      const Eigen::Map<const MatrixXd> rows(moments.term(cell, 0), places.r(), w);
      VectorXd both = 2.0 * fixed;
      both(places.all) += change;
      sum += change.dot(rows * both);
    }
    return VectorXd::Constant(1, sum);
  }
  VectorXd result(moments.groups());
  const auto fill = [&](Index begin, Index end) {
    VectorXd combination(w);
    VectorXd product(w);
    for (Index group = begin; group < end; ++group) {
      combination.setZero();
      combination.head(at.coefficients.size()) = -at.coefficients;
      combination[w - 1] = 1.0;
      for (std::size_t t = effects.size(); t-- > 0;) {
        const Index of = model.random.of_groups[t][static_cast<std::size_t>(group)];
        Index row = 0;
        for (const Index column : model.random.terms[t]) {
          combination[column] -= effects[t](row++, of);
        }
      }
      const Eigen::Map<const MatrixXd> products(moments.term(group, 0), w, w);
      product.noalias() = products * combination;
      result[group] = combination.dot(product);
    }
  };
  const auto parts = static_cast<std::size_t>((moments.groups() + kPartGroups - 1) / kPartGroups);
  parallel_for(parts, model.threads, [&](std::size_t part) {
    const Index begin = static_cast<Index>(part) * kPartGroups;
    fill(begin, std::min(begin + kPartGroups, moments.groups()));
  });
  return result;
}

}  // namespace silvafit::fit
