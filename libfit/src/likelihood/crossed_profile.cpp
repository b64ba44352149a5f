// SPDX-License-Identifier: MIT
#include "likelihood/crossed_profile.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <functional>

#include "conditional_modes/effect_factor.hpp"
#include "conditional_modes/effect_layout.hpp"
#include "conditional_modes/random_places.hpp"
#include "likelihood/profile_sums.hpp"

namespace silvafit::fit {
namespace {

/// The effects of one cluster, eliminated.
struct ClusterElimination {
  EffectFactor factor{};
  MatrixXd curvatures{};  ///< (triangle x cells)
  MatrixXd solved{};      ///< (effects x width) H^-1 L'Z'[X w]
};

/// One evaluation, cluster by cluster.
class Elimination {
 public:
  /// \param total  (width x width) cross products of all cells
  /// \param rows   (r width x cells) those of the random columns with all, of each cell
  Elimination(const RandomColumns& random,
              const RelativeFactors& factors,
              const MatrixXd& total,
              const Eigen::Ref<const MatrixXd>& rows)
      : random_(random),
        layout_(*random.crossed),
        factors_(factors),
        width_(total.rows()),
        total_(total),
        rows_(rows),
        columns_(random.terms),
        design_{.joint = columns_.joint(factors)},
        clusters_(random.cluster_begin.size() - 1) {}

  /// \returns false if a matrix cannot be factorized
  bool sum_up(ProfileSums& sums) {
    sums.total = total_;
    sums.log_determinant = 0.0;
    for (std::size_t c = 0; c < clusters_.size(); ++c) {
      if (!eliminate(c, sums)) return false;
    }
    return true;
  }

  /// Adds the derivatives.
  /// \param by_rows  called with the number of each cell and the derivative by its rows beside that
  ///   by the total; or none
  void differentiate(const Adjoint& from,
                     LinearMixedProfile& result,
                     const std::function<void(Index, const MatrixXd&)>& by_rows) {
    spherical_.setZero(layout_.size());
    by_design_.setZero(std::ssize(columns_.all), layout_.joint_count());
    slopes_.setZero(layout_.size(), from.count);
    for (std::size_t c = 0; c < clusters_.size(); ++c) differentiate(c, from, by_rows);
    result.spherical = layout_.by_term(spherical_);
    Index column = 0;
    for (std::size_t t = 0; t < factors_.size(); ++t) {
      const Index q = factors_[t].rows();
      MatrixXd by_factor = by_design_(columns_.rows[t], Eigen::all).middleCols(column, q);
      result.by_factor.emplace_back(by_factor.triangularView<Eigen::Lower>());
      column += q;
    }
    add_by_covariance(result);
  }

 private:
  Index first_cell(std::size_t cluster) const { return random_.cluster_begin[cluster]; }
  Index cells(std::size_t cluster) const { return first_cell(cluster + 1) - first_cell(cluster); }

  /// (r x width)
  Eigen::Map<const MatrixXd> rows_of(std::size_t c, Index k) const {
    return {rows_.col(first_cell(c) + k).data(), columns_.r(), width_};
  }

  MatrixXd curvatures_of(std::size_t c) const {
    const Index r = columns_.r();
    MatrixXd result(r * (r + 1) / 2, cells(c));
    for (Index k = 0; k < result.cols(); ++k) {
      const auto rows = rows_of(c, k);
      Index at = 0;
      for (Index b = 0; b < r; ++b) {
        for (Index a = b; a < r; ++a) {
          result(at++, k) = rows(a, columns_.all[static_cast<std::size_t>(b)]);
        }
      }
    }
    return result;
  }

  bool eliminate(std::size_t c, ProfileSums& sums) {
    ClusterElimination& of = clusters_[c];
    const auto number = static_cast<Index>(c);
    of.curvatures = curvatures_of(c);
    if (!of.factor.compute(layout_.pattern(number), design_, of.curvatures)) return false;
    MatrixXd right = MatrixXd::Zero(layout_.size_of(number), width_);
    MatrixXd own(layout_.joint_count(), width_);
    for (Index k = 0; k < cells(c); ++k) {
      own.noalias() = design_.joint.transpose() * rows_of(c, k);
      for (Index j = 0; j < width_; ++j) {
        layout_.add_to_group(right.col(j), number, k, own.col(j));
      }
    }
    of.solved = right;
    for (Index j = 0; j < width_; ++j) of.factor.solve(of.solved.col(j));
    sums.total -= right.transpose() * of.solved;
    sums.log_determinant += 0.5 * of.factor.log_determinant();
    return true;
  }

  /// With t = f - L v for a vector f of the adjoint and its effects v, the products P of a cell
  /// have the derivative t t', and the design -2 P t v'; the determinant adds its own. Of t t', f
  /// f' is the same in all cells.
  void differentiate(std::size_t c,
                     const Adjoint& from,
                     const std::function<void(Index, const MatrixXd&)>& by_rows) {
    ClusterElimination& of = clusters_[c];
    const auto number = static_cast<Index>(c);
    of.factor.invert();
    const Eigen::Map<const MatrixXd> vectors(from.vectors.data(), width_, from.count);
    const MatrixXd effects = of.solved * vectors;
    const Index begin = layout_.begin(number);
    spherical_.segment(begin, layout_.size_of(number)) = effects.col(0);
    for (Index k = 0; k < cells(c); ++k) {
      const auto rows = rows_of(c, k);
      const SmallMatrix inverse = of.factor.inverse_block(k);
      const SmallMatrix curvature = unpacked(of.curvatures.col(k).data(), std::ssize(columns_.all));
      by_design_ += curvature * design_.joint * inverse;
      MatrixXd by_cell;
      if (by_rows) {
        by_cell.setZero(columns_.r(), width_);
        by_cell(Eigen::all, columns_.all) =
            0.5 * design_.joint * inverse * design_.joint.transpose();
      }
      for (Index f = 0; f < from.count; ++f) {
        const SmallVector v = layout_.of_group(effects.col(f), number, k);
        const SmallVector change = -design_.joint * v;
        SmallVector slope = rows * vectors.col(f);
        slope += curvature * change;
        by_design_ -= 2.0 * slope * v.transpose();
        if (by_rows) {
          by_cell += 2.0 * change * vectors.col(f).transpose();
          by_cell(Eigen::all, columns_.all) += change * change.transpose();
        }
        add_slopes(slope, number, k, f);
      }
      if (by_rows) by_rows(first_cell(c) + k, by_cell);
    }
  }

  /// Sums of the slopes by b of each group's effects.
  void add_slopes(const SmallVector& slope, Index cluster, Index k, Index f) {
    SmallVector own(layout_.joint_count());
    Index row = 0;
    for (const std::vector<Index>& term : columns_.rows) {
      for (const Index place : term) own[row++] = slope[place];
    }
    layout_.add_to_group(
        slopes_.col(f).segment(layout_.begin(cluster), layout_.size_of(cluster)), cluster, k, own);
  }

  /// dF/dD of each term: -s s' for the slopes s of each group, and Z'V^-1 Z / 2 of the determinant,
  /// which is L^-T (I - H^-1) L^-1 / 2. Where L is singular, a small one takes its place, which
  /// changes V so little that it does not matter for the sign of the derivative.
  void add_by_covariance(LinearMixedProfile& result) {
    bool is_floored = false;
    RelativeFactors floored;
    for (std::size_t t = 0; t < factors_.size(); ++t) {
      floored.push_back(with_floor(t, is_floored));
    }
    if (is_floored) {
      design_.joint = columns_.joint(floored);
      for (std::size_t c = 0; c < clusters_.size(); ++c) {
        EffectFactor& factor = clusters_[c].factor;
        const SparsePattern* const pattern = layout_.pattern(static_cast<Index>(c));
        if (!factor.compute(pattern, design_, clusters_[c].curvatures)) {
          // Without a slope no covariance is moved into its interior.
          for (const MatrixXd& zero : factors_) {
            result.by_covariance.emplace_back(MatrixXd::Zero(zero.rows(), zero.rows()));
          }
          return;
        }
        factor.invert();
      }
    }
    for (std::size_t t = 0; t < factors_.size(); ++t) {
      const Index q = factors_[t].rows();
      MatrixXd& sum = result.by_covariance.emplace_back(MatrixXd::Zero(q, q));
      for (Index f = 0; f < slopes_.cols(); ++f) {
        const MatrixXd slopes = layout_.by_term(slopes_.col(f))[t];
        sum -= slopes * slopes.transpose();
      }
      sum += 0.5 * of_determinant(t, floored[t]);
    }
  }

  /// (q x q) the sum of Z'V^-1 Z over the groups of a term.
  MatrixXd of_determinant(std::size_t t, const MatrixXd& factor) const {
    const Index q = factor.rows();
    Index row = 0;
    for (std::size_t before = 0; before < t; ++before) row += factors_[before].rows();
    MatrixXd open = MatrixXd::Zero(q, q);
    std::vector<bool> is_done(static_cast<std::size_t>(layout_.size()), false);
    for (std::size_t c = 0; c < clusters_.size(); ++c) {
      const auto number = static_cast<Index>(c);
      for (Index k = 0; k < cells(c); ++k) {
        const Index place = layout_.begin(number) + layout_.pattern(number)->place(row, k);
        if (is_done[static_cast<std::size_t>(place)]) continue;
        is_done[static_cast<std::size_t>(place)] = true;
        open +=
            MatrixXd::Identity(q, q) - clusters_[c].factor.inverse_block(k).block(row, row, q, q);
      }
    }
    const MatrixXd half = factor.transpose().partialPivLu().solve(open);
    return factor.transpose().partialPivLu().solve(half.transpose());
  }

  /// A factor with singular values of at least a thousandth of what the information of the data on
  /// the effects of a typical group corresponds to.
  MatrixXd with_floor(std::size_t t, bool& is_floored) const {
    double information = 0.0;
    const std::vector<Index>& groups = random_.of_groups[t];
    for (std::size_t c = 0; c < clusters_.size(); ++c) {
      for (Index k = 0; k < cells(c); ++k) {
        const SmallMatrix curvature =
            unpacked(clusters_[c].curvatures.col(k).data(), std::ssize(columns_.all));
        for (const Index r : columns_.rows[t]) information += curvature(r, r);
      }
    }
    const auto count = static_cast<double>(1 + *std::ranges::max_element(groups));
    constexpr double kSmall = 1e-3;
    const double floor =
        kSmall / std::sqrt(information / (count * static_cast<double>(factors_[t].rows())));
    const Eigen::JacobiSVD<MatrixXd> svd(factors_[t], Eigen::ComputeFullU | Eigen::ComputeFullV);
    if (svd.singularValues().minCoeff() >= floor || !std::isfinite(floor)) return factors_[t];
    is_floored = true;
    return svd.matrixU() * svd.singularValues().cwiseMax(floor).asDiagonal() *
           svd.matrixV().transpose();
  }

  const RandomColumns& random_;
  const EffectLayout& layout_;
  const RelativeFactors& factors_;
  Index width_;
  const MatrixXd& total_;
  Eigen::Ref<const MatrixXd> rows_;
  RandomPlaces columns_;
  RandomDesign design_;
  std::vector<ClusterElimination> clusters_;
  VectorXd spherical_;
  MatrixXd by_design_;
  MatrixXd slopes_;  ///< (effects x vectors) Z'V^-1 of the vectors of the adjoint
};

}  // namespace

LinearMixedProfile crossed_profile(const LinearMixedModel& model,
                                   const RelativeFactors& factors,
                                   const VectorXd& displacement,
                                   bool with_derivatives,
                                   const HeldParameters& held) {
  const GroupMoments& moments = model.moments;
  MatrixXd total = moments.total(0);
  MatrixXd displaced;
  if (displacement.size() > 0 && !displacement.isZero(0.0)) {
    const VectorXd weights = moments.term_weights(displacement);
    total *= weights[0];
    displaced = weights[0] * moments.term(0);
    for (Index term = 1; term < moments.terms(); ++term) {
      total += weights[term] * moments.total(term);
      displaced += weights[term] * moments.term(term);
    }
  }
  using Rows = Eigen::Ref<const MatrixXd>;
  const Rows rows = displaced.size() > 0 ? Rows(displaced) : Rows(moments.term(0));
  Elimination elimination(model.random, factors, total, rows);
  ProfileSums sums;
  if (!elimination.sum_up(sums)) return {};
  LinearMixedProfile result = sums.solve(model, displacement, held);
  if (!result.is_valid || !with_derivatives) return result;
  const Adjoint from = sums.adjoint(model, result);
  VectorXd by_term = VectorXd::Zero(moments.terms());
  std::function<void(Index, const MatrixXd&)> add_rows;
  if (moments.parameters() > 0) {
    const Eigen::Map<const MatrixXd> vectors(from.vectors.data(), moments.width(), from.count);
    for (Index term = 0; term < moments.terms(); ++term) {
      by_term[term] = vectors.cwiseProduct(moments.total(term) * vectors).sum();
    }
    add_rows = [&](Index cell, const MatrixXd& by_rows) {
      for (Index term = 0; term < moments.terms(); ++term) {
        by_term[term] += by_rows.reshaped().dot(moments.term(term).col(cell));
      }
    };
  }
  elimination.differentiate(from, result, add_rows);
  // The residuals were divided by sqrt(2) sigma.
  for (MatrixXd& spherical : result.spherical) spherical *= std::sqrt(2.0 * result.sigma2);
  result.by_variance =
      moments.by_displacement(by_term, displacement) + moments.sum_log_gradient(displacement);
  return result;
}

MatrixXd without_crossed_effects(const RandomColumns& random,
                                 const RelativeFactors& factors,
                                 const GroupMoments& moments) {
  ProfileSums sums;
  const MatrixXd total = moments.total(0);
  Elimination elimination(random, factors, total, moments.term(0));
  if (!elimination.sum_up(sums)) sums.total.setConstant(std::nan(""));
  return sums.total;
}

}  // namespace silvafit::fit
