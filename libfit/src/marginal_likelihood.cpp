// SPDX-License-Identifier: MIT
#include "marginal_likelihood.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Rows of a block of clusters: their data stay in the cache while modes are searched.
constexpr Index kBlockRows = 4096;
// Squared distance to the mode in standard deviations at which a search ends.
constexpr double kModeDecrement = 1e-20;
// Below this, a decrement that no longer falls is rounding.
constexpr double kRoundedDecrement = 1e-12;
constexpr int kModeSteps = 100;

std::vector<Index> coefficients_of(const NonlinearModel& model,
                                   const std::optional<RandomEffects>& random) {
  std::vector<Index> columns;
  if (!random) return columns;
  for (const std::string& name : random->coefficients) {
    columns.push_back(model.coefficient_index(name));
  }
  return columns;
}

std::vector<Index> united(std::vector<Index> a, const std::vector<Index>& b) {
  a.insert(a.end(), b.begin(), b.end());
  std::ranges::sort(a);
  a.erase(std::unique(a.begin(), a.end()), a.end());
  return a;
}

std::vector<Index> places(const std::vector<Index>& of, const std::vector<Index>& in) {
  std::vector<Index> result;
  for (const Index value : of) result.push_back(std::ranges::find(in, value) - in.begin());
  return result;
}

/// The symmetric matrix of a lower triangle stored by columns.
template <typename Packed>
SmallMatrix unpacked(const Packed& triangle, Index size) {
  SmallMatrix result(size, size);
  Index k = 0;
  for (Index column = 0; column < size; ++column) {
    for (Index row = column; row < size; ++row, ++k) {
      result(row, column) = result(column, row) = triangle[k];
    }
  }
  return result;
}

Index triangle_size(Index size) { return size * (size + 1) / 2; }

/// (s x r) rows of L placed where its effects are among the random coefficients.
SmallMatrix placed(const MatrixXd& factor, const std::vector<Index>& rows, Index r) {
  SmallMatrix result = SmallMatrix::Zero(r, factor.cols());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    result.row(rows[k]) += factor.row(static_cast<Index>(k));
  }
  return result;
}

}  // namespace

/// Some clusters: the search for their modes and what they add to the value and the gradient.
class MarginalLikelihood::Block {
 public:
  Block(MarginalLikelihood& whole,
        const MarginalPoint& point,
        const RandomDesign& design,
        MatrixXd& effects,
        Index first,
        Index last)
      : whole_(whole),
        point_(point),
        design_(design),
        effects_(effects),
        first_(first),
        last_(last),
        begin_(whole.model_.cluster_begin(first)),
        end_(whole.model_.cluster_begin(last)),
        r_(whole.sums_.random_count()),
        clusters_(static_cast<std::size_t>(last - first)) {}

  MarginalValue value(bool with_gradient) {
    MarginalValue result = zero();
    if (!find_modes()) {
      result.minus_log_likelihood = std::numeric_limits<double>::infinity();
      return result;
    }
    prepare_weights();
    if (whole_.has_quadrature_) {
      integrate(result, with_gradient);
    } else {
      for (const Cluster& cluster : clusters_) {
        result.minus_log_likelihood +=
            cluster.objective + 0.5 * cluster.determinant.log_determinant();
      }
    }
    if (with_gradient && std::isfinite(result.minus_log_likelihood)) differentiate(result);
    return result;
  }

 private:
  struct Cluster {
    double objective = 0.0;  ///< rho + v'v / 2
    double decrement = std::numeric_limits<double>::infinity();
    double length = 1.0;
    bool is_done = false;
    SmallVector outer{};  ///< mode u
    SmallVector outer_step{};
    std::vector<SmallVector> inner{};  ///< modes v_k
    std::vector<SmallVector> inner_step{};
    ArrowFactor hessian{};      ///< of the joint density at the mode
    ArrowFactor determinant{};  ///< with K in place of its curvature
    /// What takes the place of H^-1 in the derivatives of the log-determinant, by group.
    std::vector<SmallMatrix> spread{};
    SmallVector outer_pull{};  ///< derivative of the integral by u, beyond the determinant's
    std::vector<SmallVector> inner_pull{};
  };

  MarginalValue zero() const {
    const Index p = whole_.model_.coefficient_count();
    return {.by_beta = VectorXd::Zero(p),
            .by_variance = VectorXd::Zero(point_.observation.variance.size()),
            .by_outer_factor = MatrixXd::Zero(outer_size(), outer_size()),
            .by_inner_factor = MatrixXd::Zero(inner_size(), inner_size())};
  }

  Index outer_size() const { return design_.outer.cols(); }
  Index inner_size() const { return design_.inner.cols(); }
  Index group_begin(std::size_t cluster) const {
    return whole_.model_.cluster_begin(first_ + static_cast<Index>(cluster));
  }
  std::size_t group_count(std::size_t cluster) const {
    return static_cast<std::size_t>(group_begin(cluster + 1) - group_begin(cluster));
  }
  /// The sums of a group at its mode.
  auto density_sums(Index group) const { return density_.col(group - begin_); }
  auto slope_sums(Index group) const { return density_sums(group).segment(1, r_); }
  SmallMatrix curvature(Index group) const {
    return unpacked(density_sums(group).segment(1 + r_, triangle_size(r_)), r_);
  }
  SmallMatrix approximation(Index group) const {
    if (!whole_.sums_.has_approximation()) return curvature(group);
    return unpacked(density_sums(group).segment(1 + r_ + triangle_size(r_), triangle_size(r_)), r_);
  }

  bool find_modes() {
    for (std::size_t c = 0; c < clusters_.size(); ++c) start(c);
    density_.resize(1 + r_ + triangle_size(r_) * (whole_.sums_.has_approximation() ? 2 : 1),
                    end_ - begin_);
    for (int step = 0; step < kModeSteps; ++step) {
      if (!evaluate_open_clusters()) return true;
      for (std::size_t c = 0; c < clusters_.size(); ++c) {
        if (!clusters_[c].is_done && !advance(c)) return false;
      }
    }
    return !evaluate_open_clusters();
  }

  void start(std::size_t c) {
    Cluster& cluster = clusters_[c];
    const std::size_t groups = group_count(c);
    cluster.outer = whole_.outer_modes_.col(first_ + static_cast<Index>(c));
    cluster.outer_step = SmallVector::Zero(outer_size());
    cluster.inner.resize(groups);
    cluster.inner_step.assign(groups, SmallVector::Zero(inner_size()));
    for (std::size_t k = 0; k < groups; ++k) {
      cluster.inner[k] = whole_.inner_modes_.col(group_begin(c) + static_cast<Index>(k));
    }
    cluster.objective = std::numeric_limits<double>::infinity();
  }

  void place_effects(std::size_t c) {
    const Cluster& cluster = clusters_[c];
    const SmallVector shared = design_.outer * cluster.outer;
    for (std::size_t k = 0; k < cluster.inner.size(); ++k) {
      effects_.col(group_begin(c) + static_cast<Index>(k)) =
          shared + design_.inner * cluster.inner[k];
    }
  }

  /// Sums at the trial modes of all clusters that are still searched; false if there are none.
  bool evaluate_open_clusters() {
    bool any = false;
    for (std::size_t c = 0; c < clusters_.size();) {
      if (clusters_[c].is_done) {
        ++c;
        continue;
      }
      any = true;
      const std::size_t from = c;
      for (; c < clusters_.size() && !clusters_[c].is_done; ++c) place_effects(c);
      whole_.sums_.density(group_begin(from), group_begin(c), effects_, trial_, workspace_);
      density_.middleCols(group_begin(from) - begin_, trial_.cols()) = trial_;
    }
    return any;
  }

  double objective(std::size_t c) const {
    const Cluster& cluster = clusters_[c];
    double sum = 0.5 * cluster.outer.squaredNorm();
    for (std::size_t k = 0; k < cluster.inner.size(); ++k) {
      sum += density_sums(group_begin(c) + static_cast<Index>(k))[0] +
             0.5 * cluster.inner[k].squaredNorm();
    }
    return sum;
  }

  /// Takes the trial modes if they are better, and proposes the next; else goes back half way.
  bool advance(std::size_t c) {
    Cluster& cluster = clusters_[c];
    const double reached = objective(c);
    const double rounding = 1e-13 * (1.0 + std::abs(cluster.objective));
    if (!(reached <= cluster.objective + rounding)) {
      if (!std::isfinite(cluster.objective)) return false;
      cluster.length *= 0.5;
      if (cluster.length < 1e-9) return false;
      move(cluster, -cluster.length);
      return true;
    }
    cluster.objective = reached;
    const double last = cluster.decrement;
    if (!propose(c)) return false;
    const bool is_rounding =
        cluster.decrement < kRoundedDecrement && cluster.decrement >= 0.25 * last;
    if (cluster.decrement < kModeDecrement || is_rounding) {
      cluster.is_done = true;
      return true;
    }
    cluster.length = 1.0;
    move(cluster, 1.0);
    return true;
  }

  static void move(Cluster& cluster, double length) {
    cluster.outer += length * cluster.outer_step;
    for (std::size_t k = 0; k < cluster.inner.size(); ++k) {
      cluster.inner[k] += length * cluster.inner_step[k];
    }
  }

  /// The Newton step from the current modes.
  bool propose(std::size_t c) {
    Cluster& cluster = clusters_[c];
    const Index begin = group_begin(c);
    matrices_.resize(cluster.inner.size());
    SmallVector shared = SmallVector::Zero(r_);
    for (std::size_t k = 0; k < cluster.inner.size(); ++k) {
      const Index group = begin + static_cast<Index>(k);
      matrices_[k] = curvature(group);
      const SmallVector slope = slope_sums(group);
      shared += slope;
      cluster.inner_step[k] = -(design_.inner.transpose() * slope) - cluster.inner[k];
    }
    cluster.outer_step = -(design_.outer.transpose() * shared) - cluster.outer;
    if (!factorise(cluster)) return false;
    right_ = cluster.inner_step;
    const SmallVector outer_right = cluster.outer_step;
    cluster.hessian.solve(cluster.outer_step, cluster.inner_step);
    cluster.decrement = outer_right.dot(cluster.outer_step);
    for (std::size_t k = 0; k < right_.size(); ++k) {
      cluster.decrement += right_[k].dot(cluster.inner_step[k]);
    }
    return std::isfinite(cluster.decrement);
  }

  /// Away from the mode the Hessian may have to be made positive definite.
  bool factorise(Cluster& cluster) {
    if (cluster.hessian.compute(design_, matrices_)) return true;
    constexpr double kLargestRidge = 1e12;
    for (double ridge = 1e-2; ridge < kLargestRidge; ridge *= 4.0) {
      if (cluster.hessian.compute(design_, matrices_, ridge)) return true;
    }
    return false;
  }

  /// Keeps the modes, and factorises I + L'KL.
  void prepare_weights() {
    for (std::size_t c = 0; c < clusters_.size(); ++c) {
      Cluster& cluster = clusters_[c];
      const Index begin = group_begin(c);
      whole_.outer_modes_.col(first_ + static_cast<Index>(c)) = cluster.outer;
      for (std::size_t k = 0; k < cluster.inner.size(); ++k) {
        whole_.inner_modes_.col(begin + static_cast<Index>(k)) = cluster.inner[k];
      }
      place_effects(c);
      if (!whole_.sums_.has_approximation()) {
        cluster.determinant = cluster.hessian;
      } else {
        matrices_.resize(cluster.inner.size());
        for (std::size_t k = 0; k < cluster.inner.size(); ++k) {
          matrices_[k] = approximation(begin + static_cast<Index>(k));
        }
        cluster.determinant.compute(design_, matrices_);
      }
      cluster.outer_pull = SmallVector::Zero(outer_size());
      cluster.inner_pull.assign(cluster.inner.size(), SmallVector::Zero(inner_size()));
    }
  }

  // ---- adaptive quadrature: one grouping, each cluster is a group ----

  void integrate(MarginalValue& result, bool with_gradient) {
    const Index nodes = whole_.rule_.weights.size();
    const Index p = whole_.model_.coefficient_count();
    const Index m = point_.observation.variance.size();
    std::vector<SmallMatrix> lower;
    for (const Cluster& cluster : clusters_) lower.push_back(cluster.hessian.lower(0));
    MatrixXd at_node(effects_.rows(), effects_.cols());
    MatrixXd exponents(nodes, end_ - begin_);
    std::vector<MatrixXd> sums(static_cast<std::size_t>(nodes));
    for (Index k = 0; k < nodes; ++k) {
      for (std::size_t c = 0; c < clusters_.size(); ++c) {
        at_node.col(group_begin(c)) = design_.inner * node(c, lower[c], k);
      }
      MatrixXd& here = sums[static_cast<std::size_t>(k)];
      if (with_gradient) {
        whole_.sums_.slopes(begin_, end_, at_node, here, workspace_);
      } else {
        whole_.sums_.density(begin_, end_, at_node, here, workspace_);
      }
      for (std::size_t c = 0; c < clusters_.size(); ++c) {
        exponents(k, static_cast<Index>(c)) =
            std::log(whole_.rule_.weights[k]) + 0.5 * whole_.rule_.nodes.col(k).squaredNorm() -
            here(0, static_cast<Index>(c)) - 0.5 * node(c, lower[c], k).squaredNorm();
      }
    }
    for (std::size_t c = 0; c < clusters_.size(); ++c) {
      const auto column = static_cast<Index>(c);
      const double largest = exponents.col(column).maxCoeff();
      const VectorXd shares = (exponents.col(column).array() - largest).exp();
      result.minus_log_likelihood -= largest + std::log(shares.sum());
      result.minus_log_likelihood += 0.5 * clusters_[c].hessian.log_determinant();
      exponents.col(column) = shares / shares.sum();
    }
    if (!with_gradient) return;
    node_slopes_.setZero(r_, end_ - begin_);
    for (std::size_t c = 0; c < clusters_.size(); ++c) {
      const auto column = static_cast<Index>(c);
      Cluster& cluster = clusters_[c];
      SmallMatrix by_lower = SmallMatrix::Zero(inner_size(), inner_size());
      SmallVector pull = SmallVector::Zero(inner_size());
      for (Index k = 0; k < nodes; ++k) {
        const double share = exponents(k, column);
        const auto here = sums[static_cast<std::size_t>(k)].col(column);
        result.by_beta += share * here.segment(1, p);
        result.by_variance += share * here.segment(1 + p, m);
        result.by_log_sigma += share * here[1 + p + m];
        const SmallVector v = node(c, lower[c], k);
        SmallVector slope(inner_size());
        SmallVector in_rows(static_cast<Index>(whole_.inner_.size()));
        for (std::size_t i = 0; i < whole_.inner_.size(); ++i) {
          in_rows[static_cast<Index>(i)] = here[1 + whole_.inner_[i]];
        }
        result.by_inner_factor += share * in_rows * v.transpose();
        slope = point_.inner_factor.transpose() * in_rows + v;
        pull += share * slope;
        const SmallVector distance = v - cluster.inner[0];
        by_lower -=
            share * distance * lower[c].triangularView<Eigen::Lower>().solve(slope).transpose();
      }
      by_lower.diagonal() += lower[c].diagonal().cwiseInverse();
      cluster.spread.assign(1, 2.0 * by_cholesky(lower[c], by_lower));
      cluster.inner_pull[0] = pull;
    }
  }

  SmallVector node(std::size_t c, const SmallMatrix& lower, Index k) const {
    const SmallVector x = whole_.rule_.nodes.col(k);
    return clusters_[c].inner[0] +
           SmallVector(lower.transpose().triangularView<Eigen::Upper>().solve(x));
  }

  /// The derivative by H from that by its Cholesky factor C.
  /// Source: Murray 2016, Differentiation of the Cholesky decomposition, arXiv:1602.07527.
  static SmallMatrix by_cholesky(const SmallMatrix& lower, const SmallMatrix& by_lower) {
    SmallMatrix inside = lower.transpose() * by_lower;
    inside = inside.triangularView<Eigen::Lower>().toDenseMatrix().eval();
    inside.diagonal() *= 0.5;
    SmallMatrix result = inside + inside.transpose();
    lower.transpose().triangularView<Eigen::Upper>().solveInPlace(result);
    result.transposeInPlace();
    lower.transpose().triangularView<Eigen::Upper>().solveInPlace(result);
    return 0.5 * result;
  }

  // ---- gradient ----

  void differentiate(MarginalValue& result) {
    MatrixXd weights(triangle_size(r_), effects_.cols());
    for (std::size_t c = 0; c < clusters_.size(); ++c) weigh(c, weights);
    MatrixXd sums;
    whole_.sums_.total(begin_, end_, effects_, weights, sums, workspace_);
    for (std::size_t c = 0; c < clusters_.size(); ++c) differentiate(c, sums, result);
  }

  /// (r x s + q) how the spherical effects of a group move the coefficients.
  SmallMatrix joint_design() const {
    SmallMatrix joint(r_, outer_size() + inner_size());
    joint << design_.outer, design_.inner;
    return joint;
  }

  /// The matrices M of a cluster's groups.
  void weigh(std::size_t c, MatrixXd& weights) {
    Cluster& cluster = clusters_[c];
    const SmallMatrix joint = joint_design();
    if (!whole_.has_quadrature_) {
      cluster.spread.resize(cluster.inner.size());
      for (std::size_t k = 0; k < cluster.inner.size(); ++k) {
        cluster.spread[k] = cluster.determinant.inverse_block(k);
      }
    }
    for (std::size_t k = 0; k < cluster.inner.size(); ++k) {
      const SmallMatrix matrix = joint * cluster.spread[k] * joint.transpose();
      Index packed = 0;
      for (Index column = 0; column < r_; ++column) {
        for (Index row = column; row < r_; ++row) {
          weights(packed++, group_begin(c) + static_cast<Index>(k)) = matrix(row, column);
        }
      }
    }
  }

  void differentiate(std::size_t c, const MatrixXd& sums, MarginalValue& result) {
    Cluster& cluster = clusters_[c];
    const Index s = outer_size();
    const Index q = inner_size();
    const Index p = whole_.model_.coefficient_count();
    const Index m = point_.observation.variance.size() + 1;
    const Index begin = group_begin(c) - begin_;
    // How the modes would move the value, solved for how they follow the parameters.
    SmallVector outer = cluster.outer_pull;
    std::vector<SmallVector>& inner = cluster.inner_pull;
    for (std::size_t k = 0; k < inner.size(); ++k) {
      const SmallVector turn = sums.col(begin + static_cast<Index>(k)).head(r_);
      outer += design_.outer.transpose() * turn;
      inner[k] += design_.inner.transpose() * turn;
    }
    cluster.hessian.solve(outer, inner);

    const SmallMatrix joint = joint_design();
    SmallMatrix by_design = SmallMatrix::Zero(r_, s + q);
    for (std::size_t k = 0; k < inner.size(); ++k) {
      const Index group = begin_ + begin + static_cast<Index>(k);
      const auto here = sums.col(begin + static_cast<Index>(k));
      const SmallVector turn = here.head(r_);
      const SmallVector shift = design_.outer * outer + design_.inner * inner[k];
      const auto fixed_random = here.segment(r_ + p + m, p * r_);
      const auto variance_random = here.segment(r_ + p + m + p * r_, m * r_);
      // With quadrature the direct slopes are those of the nodes, which are in the value already.
      const VectorXd direct = whole_.has_quadrature_
                                  ? VectorXd(here.segment(r_, p + m) - mode_slopes(group))
                                  : VectorXd(here.segment(r_, p + m));
      for (Index j = 0; j < p; ++j) {
        result.by_beta[j] += direct[j] - fixed_random.segment(j * r_, r_).dot(shift);
      }
      for (Index e = 0; e + 1 < m; ++e) {
        result.by_variance[e] += direct[p + e] - variance_random.segment(e * r_, r_).dot(shift);
      }
      result.by_log_sigma += direct[p + m - 1] - variance_random.tail(r_).dot(shift);

      SmallVector mode(s + q);
      mode << cluster.outer, cluster.inner[k];
      SmallVector follow(s + q);
      follow << outer, inner[k];
      const SmallVector slope = slope_sums(group);
      by_design += approximation(group) * joint * cluster.spread[k];
      by_design += turn * mode.transpose() - slope * follow.transpose();
      by_design -= curvature(group) * shift * mode.transpose();
      if (!whole_.has_quadrature_) by_design += slope * mode.transpose();
    }
    for (std::size_t i = 0; i < whole_.outer_rows_.size(); ++i) {
      result.by_outer_factor.row(static_cast<Index>(i)) +=
          by_design.row(whole_.outer_rows_[i]).head(s);
    }
    for (std::size_t i = 0; i < whole_.inner_rows_.size(); ++i) {
      result.by_inner_factor.row(static_cast<Index>(i)) +=
          by_design.row(whole_.inner_rows_[i]).tail(q);
    }
  }

  /// (p + m + 1) the slopes of rho at the mode of a group, for quadrature.
  VectorXd mode_slopes(Index group) {
    if (mode_slopes_.cols() == 0) {
      whole_.sums_.slopes(begin_, end_, effects_, mode_slopes_, workspace_);
    }
    return mode_slopes_.col(group - begin_).tail(mode_slopes_.rows() - 1);
  }

  MarginalLikelihood& whole_;
  const MarginalPoint& point_;
  const RandomDesign& design_;
  MatrixXd& effects_;  ///< (r x G) of all groups; a block writes its own
  Index first_;
  Index last_;
  Index begin_;  ///< groups
  Index end_;
  Index r_;
  std::vector<Cluster> clusters_;
  MatrixXd density_;  ///< sums at the modes
  MatrixXd trial_;
  MatrixXd node_slopes_;
  MatrixXd mode_slopes_;
  std::vector<SmallMatrix> matrices_;
  std::vector<SmallVector> right_;
  ObservationSums::Workspace workspace_;
};

MarginalLikelihood::MarginalLikelihood(const NonlinearModel& model,
                                       const VarianceModel& variance,
                                       Curvature curvature,
                                       int points,
                                       unsigned threads)
    : model_(model),
      outer_(coefficients_of(model, model.specification().outer_random)),
      inner_(coefficients_of(model, model.specification().random)),
      sums_(model, variance, curvature, united(outer_, inner_)),
      has_quadrature_(points > 1),
      threads_(threads) {
  const auto effects = static_cast<int>(outer_.size() + inner_.size());
  if (effects > kMostRandomEffects) {
    throw UsageError(fmt::format("there are {} random effects a group; at most {} can be fitted",
                                 effects,
                                 kMostRandomEffects));
  }
  outer_rows_ = places(outer_, sums_.random());
  inner_rows_ = places(inner_, sums_.random());
  if (has_quadrature_) rule_ = gauss_hermite(points, static_cast<Index>(inner_.size()));
  outer_modes_.setZero(static_cast<Index>(outer_.size()), model.cluster_count());
  inner_modes_.setZero(static_cast<Index>(inner_.size()), model.group_count());
  cut_into_blocks();
}

void MarginalLikelihood::cut_into_blocks() {
  Index rows = kBlockRows;
  for (Index c = 0; c < model_.cluster_count(); ++c) {
    if (rows >= kBlockRows) {
      block_begin_.push_back(c);
      rows = 0;
    }
    rows += model_.group_begin(model_.cluster_begin(c + 1)) -
            model_.group_begin(model_.cluster_begin(c));
  }
  block_begin_.push_back(model_.cluster_count());
}

RandomDesign MarginalLikelihood::design_of(const MarginalPoint& point) const {
  const Index r = sums_.random_count();
  return {.outer = placed(point.outer_factor, outer_rows_, r),
          .inner = placed(point.inner_factor, inner_rows_, r)};
}

void MarginalLikelihood::set_modes(MatrixXd outer, MatrixXd inner) {
  outer_modes_ = std::move(outer);
  inner_modes_ = std::move(inner);
}

MarginalValue MarginalLikelihood::evaluate(const MarginalPoint& point, bool with_gradient) {
  sums_.set_point(point.observation);
  const RandomDesign design = design_of(point);
  MatrixXd effects = MatrixXd::Zero(sums_.random_count(), model_.group_count());
  const MatrixXd outer_before = outer_modes_;
  const MatrixXd inner_before = inner_modes_;
  std::vector<MarginalValue> parts(block_begin_.size() - 1);
  parallel_for(parts.size(), threads_, [&](std::size_t b) {
    Block block(*this, point, design, effects, block_begin_[b], block_begin_[b + 1]);
    parts[b] = block.value(with_gradient);
  });
  MarginalValue total = std::move(parts.front());
  for (std::size_t b = 1; b < parts.size(); ++b) {
    total.minus_log_likelihood += parts[b].minus_log_likelihood;
    total.by_beta += parts[b].by_beta;
    total.by_variance += parts[b].by_variance;
    total.by_log_sigma += parts[b].by_log_sigma;
    total.by_outer_factor += parts[b].by_outer_factor;
    total.by_inner_factor += parts[b].by_inner_factor;
  }
  total.minus_log_likelihood +=
      0.5 * static_cast<double>(model_.observations()) * std::log(2.0 * std::numbers::pi);
  if (!std::isfinite(total.minus_log_likelihood)) {
    total.minus_log_likelihood = std::numeric_limits<double>::infinity();
    outer_modes_ = outer_before;
    inner_modes_ = inner_before;
  }
  return total;
}

}  // namespace silvafit::fit
