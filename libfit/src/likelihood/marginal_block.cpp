// SPDX-License-Identifier: MIT
#include "likelihood/marginal_block.hpp"

#include <cmath>

#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
MarginalValue MarginalValue::zero(const MarginalPoint& point) {
  MarginalValue value{.by_beta = VectorXd::Zero(point.observation.beta.size()),
                      .by_variance = VectorXd::Zero(point.observation.variance.size())};
  for (const MatrixXd& factor : point.factors) {
    value.by_factors.emplace_back(MatrixXd::Zero(factor.rows(), factor.cols()));
  }
  return value;
}

VectorXd MarginalValue::numbers() const {
  Index count = 2 + by_beta.size() + by_variance.size();
  for (const MatrixXd& by_factor : by_factors) count += by_factor.size();
  VectorXd result(count);
  result.head(2) << minus_log_likelihood, by_log_sigma;
  Index at = 2;
  const auto put = [&](const auto& source) {
    result.segment(at, source.size()) = source;
    at += source.size();
  };
  put(by_beta);
  put(by_variance);
  for (const MatrixXd& by_factor : by_factors) put(by_factor.reshaped());
  return result;
}

void MarginalValue::set_numbers(const VectorXd& numbers) {
  minus_log_likelihood = numbers[0];
  by_log_sigma = numbers[1];
  Index at = 2;
  const auto take = [&](auto&& target) {
    target = numbers.segment(at, target.size());
    at += target.size();
  };
  take(by_beta);
  take(by_variance);
  for (MatrixXd& by_factor : by_factors) take(by_factor.reshaped());
}

void MarginalValue::add(const MarginalValue& other) {
  minus_log_likelihood += other.minus_log_likelihood;
  by_beta += other.by_beta;
  by_variance += other.by_variance;
  by_log_sigma += other.by_log_sigma;
  for (std::size_t t = 0; t < by_factors.size(); ++t) by_factors[t] += other.by_factors[t];
}

MarginalBlock::MarginalBlock(const NonlinearModel& model,
                             const EffectLayout& layout,
                             const GroupSums& sums,
                             const RandomPlaces& places,
                             const QuadratureRule* rule,
                             Index first,
                             Index last)
    : model_(model),
      sums_(sums),
      places_(places),
      rule_(rule),
      r_(sums.random_count()),
      modes_(layout, sums, first, last),
      determinants_(sums.has_approximation() ? static_cast<std::size_t>(last - first) : 0) {}

MarginalValue MarginalBlock::value(const MarginalPoint& point,
                                   const RandomDesign& design,
                                   VectorXd& modes,
                                   MatrixXd& effects,
                                   GroupSums::Workspace& workspace,
                                   bool with_gradient) {
  MarginalValue result = MarginalValue::zero(point);
  if (!modes_.search(design, modes, effects, workspace) || !factorize_determinants(design) ||
      !has_clear_modes()) {
    result.minus_log_likelihood = kInfinity;
    return result;
  }
  if (rule_ != nullptr) {
    integrate(point, design, effects, workspace, result, with_gradient);
  } else {
    result.minus_log_likelihood = modes_.objective();
    for (Index c = 0; c < modes_.cluster_count(); ++c) {
      result.minus_log_likelihood += 0.5 * determinant(c).log_determinant();
    }
  }
  if (with_gradient && std::isfinite(result.minus_log_likelihood)) {
    differentiate(design, effects, workspace, result);
  }
  return result;
}

bool MarginalBlock::find_modes(const RandomDesign& design,
                               VectorXd& modes,
                               MatrixXd& effects,
                               GroupSums::Workspace& workspace,
                               const VectorXd* known,
                               VectorXd& objectives) {
  if (!modes_.search(design, modes, effects, workspace, known)) return false;
  if (!factorize_determinants(design) || !has_clear_modes()) return false;
  for (Index c = 0; c < modes_.cluster_count(); ++c) {
    objectives[modes_.first_cluster() + c] = modes_.is_known(c) ? kInfinity : modes_.objective(c);
  }
  return true;
}

bool MarginalBlock::factorize_determinants(const RandomDesign& design) {
  for (std::size_t c = 0; c < determinants_.size(); ++c) {
    const auto cluster = static_cast<Index>(c);
    if (modes_.is_known(cluster)) continue;
    if (!determinants_[c].compute(modes_.pattern(cluster), design, modes_.approximations(cluster)))
      return false;
  }
  return true;
}

/// Near a point where a distribution becomes bimodal, its log-determinant goes to minus infinity,
/// and the likelihood would seem to be unbounded. Quadrature has no such limit, but there its mode
/// is not a smooth function of the parameters.
bool MarginalBlock::has_clear_modes() const {
  const double clear = rule_ == nullptr ? 0.05 : 0.005;
  for (Index c = 0; c < modes_.cluster_count(); ++c) {
    if (modes_.is_known(c)) continue;
    if (rule_ == nullptr && !modes_.is_minimum(c)) return false;
    if (determinant(c).smallest_pivot() < clear) return false;
  }
  return true;
}

const EffectFactor& MarginalBlock::determinant(Index cluster) const {
  return determinants_.empty() ? modes_.hessian(cluster)
                               : determinants_[static_cast<std::size_t>(cluster)];
}

EffectFactor& MarginalBlock::determinant(Index cluster) {
  return determinants_.empty() ? modes_.hessian(cluster)
                               : determinants_[static_cast<std::size_t>(cluster)];
}

// ---- adaptive quadrature, for one grouping: each cluster is one group ----

/// Where the nodes of all groups are: mode + C^-T x.
void MarginalBlock::place_nodes(const RandomDesign& design) {
  const Index q = design.joint.cols();
  scales_.clear();
  nodes_.resize(static_cast<std::size_t>(modes_.cluster_count()));
  for (std::size_t g = 0; g < nodes_.size(); ++g) {
    const auto group = static_cast<Index>(g);
    const SmallMatrix curvature = unpacked(modes_.curvatures(group).col(0).data(), r_);
    const SmallMatrix bent = curvature.lazyProduct(design.joint);
    SmallMatrix hessian = design.joint.transpose().lazyProduct(bent);
    hessian += SmallMatrix::Identity(q, q);
    const NodeScale& scale = scales_.emplace_back(hessian);
    nodes_[g] = rule_->nodes;
    scale.lower().transpose().triangularView<Eigen::Upper>().solveInPlace(nodes_[g]);
    nodes_[g].colwise() += modes_.of_cluster(modes_.modes(), group);
  }
}

void MarginalBlock::evaluate_nodes(const RandomDesign& design,
                                   MatrixXd& effects,
                                   GroupSums::Workspace& workspace,
                                   std::vector<MatrixXd>& node_sums,
                                   bool with_gradient) {
  const Index nodes = rule_->weights.size();
  const Index begin = modes_.first_group();
  const Index groups = modes_.end_group() - begin;
  shares_.resize(nodes, groups);
  const MatrixXd at_modes = effects.middleCols(begin, groups);
  const auto node = [&](Index group, Index k) {
    return nodes_[static_cast<std::size_t>(group)].col(k);
  };
  for (Index k = 0; k < nodes; ++k) {
    MatrixXd& here = node_sums[static_cast<std::size_t>(k)];
    for (Index g = 0; g < groups; ++g)
      effects.col(begin + g) = design.joint.lazyProduct(node(g, k));
    if (with_gradient) {
      sums_.slopes(begin, begin + groups, effects, here, workspace);
    } else {
      sums_.density(begin, begin + groups, effects, here, workspace);
    }
    const double constant = std::log(rule_->weights[k]) + 0.5 * rule_->nodes.col(k).squaredNorm();
    for (Index g = 0; g < groups; ++g) {
      shares_(k, g) = std::isfinite(here(0, g))
                          ? constant - here(0, g) - 0.5 * node(g, k).squaredNorm()
                          : -kInfinity;
    }
  }
  effects.middleCols(begin, groups) = at_modes;
}

void MarginalBlock::integrate(const MarginalPoint& point,
                              const RandomDesign& design,
                              MatrixXd& effects,
                              GroupSums::Workspace& workspace,
                              MarginalValue& result,
                              bool with_gradient) {
  // With many nodes this is much memory, which only one block at a time may have.
  std::vector<MatrixXd> node_sums(static_cast<std::size_t>(rule_->weights.size()));
  place_nodes(design);
  evaluate_nodes(design, effects, workspace, node_sums, with_gradient);
  const Index groups = shares_.cols();
  for (Index g = 0; g < groups; ++g) {
    auto shares = shares_.col(g).array();
    const double largest = shares.maxCoeff();
    shares = (shares - largest).exp();
    result.minus_log_likelihood -= largest + std::log(shares.sum());
    result.minus_log_likelihood += 0.5 * scales_[static_cast<std::size_t>(g)].log_determinant();
    shares /= shares.sum();
  }
  if (!with_gradient) return;
  const Index q = design.joint.cols();
  spread_.resize(q * q, groups);
  follow_.resize(q * groups);
  for (Index g = 0; g < groups; ++g) add_node_slopes(point, node_sums, g, result);
  const Index begin = modes_.first_group();
  sums_.slopes(begin, begin + groups, effects, mode_slopes_, workspace);
}

/// The contribution of the integrand's derivatives at the nodes to the gradient, and the derivative
/// of the value by the positions of the nodes.
void MarginalBlock::add_node_slopes(const MarginalPoint& point,
                                    const std::vector<MatrixXd>& node_sums,
                                    Index g,
                                    MarginalValue& result) {
  const Index p = result.by_beta.size();
  const Index m = result.by_variance.size();
  const MatrixXd& factor = point.factors.front();
  const Index q = factor.rows();
  const NodeScale& scale = scales_[static_cast<std::size_t>(g)];
  const SmallMatrix& lower = scale.lower();
  const MatrixXd& nodes = nodes_[static_cast<std::size_t>(g)];
  SmallMatrix by_lower = SmallMatrix::Zero(q, q);
  auto follow = modes_.of_cluster(follow_, g);
  follow.setZero();
  for (Index k = 0; k < shares_.rows(); ++k) {
    const double share = shares_(k, g);
    // Where the formula is not finite, the density is zero and its slopes mean nothing. The
    // exponential function of vectors is not exactly zero there.
    constexpr double kNone = 1e-300;
    if (share < kNone) continue;
    const auto here = node_sums[static_cast<std::size_t>(k)].col(g);
    result.by_beta += share * here.segment(1, p);
    result.by_variance += share * here.segment(1 + p, m);
    result.by_log_sigma += share * here[1 + p + m];
    SmallVector by_effects(q);
    for (Index i = 0; i < q; ++i) {
      by_effects[i] = share * here[1 + places_.terms.front()[static_cast<std::size_t>(i)]];
    }
    result.by_factors.front() += by_effects.lazyProduct(nodes.col(k).transpose());
    const SmallVector slope = factor.transpose().lazyProduct(by_effects) + share * nodes.col(k);
    follow += slope;
    by_lower -=
        (nodes.col(k) - modes_.of_cluster(modes_.modes(), g)).lazyProduct(slope.transpose());
  }
  lower.transpose().triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(by_lower);
  by_lower.diagonal() += lower.diagonal().cwiseInverse();
  Eigen::Map<MatrixXd>(spread_.col(g).data(), q, q) = 2.0 * scale.by_hessian(by_lower);
}

// ---- gradient ----

void MarginalBlock::differentiate(const RandomDesign& design,
                                  MatrixXd& effects,
                                  GroupSums::Workspace& workspace,
                                  MarginalValue& result) {
  const Index begin = modes_.first_group();
  const Index end = modes_.end_group();
  weigh(design.joint, weights_);
  sums_.total(begin, end, effects, weights_, totals_, workspace);
  follow_modes(design);
  for (Index c = 0; c < modes_.cluster_count(); ++c) {
    for (Index g = modes_.group_begin(c); g < modes_.group_begin(c + 1); ++g) {
      add_group(design, c, g, result);
    }
  }
}

/// The matrices M = Lambda H^-1 Lambda' of all groups.
void MarginalBlock::weigh(const SmallMatrix& joint, MatrixXd& weights) {
  const Index groups = modes_.end_group() - modes_.first_group();
  const Index size = joint.cols();
  weights.resize(r_ * (r_ + 1) / 2, groups);
  if (rule_ == nullptr) spread_.resize(size * size, groups);
  for (Index c = 0; c < modes_.cluster_count(); ++c) {
    if (rule_ == nullptr) determinant(c).invert();
    for (Index g = modes_.group_begin(c); g < modes_.group_begin(c + 1); ++g) {
      Eigen::Map<MatrixXd> spread(spread_.col(g).data(), size, size);
      if (rule_ == nullptr) spread = determinant(c).inverse_block(g - modes_.group_begin(c));
      const SmallMatrix half = joint.lazyProduct(spread);
      const SmallMatrix matrix = half.lazyProduct(joint.transpose());
      Index packed = 0;
      for (Index column = 0; column < r_; ++column) {
        for (Index row = column; row < r_; ++row) weights(packed++, g) = matrix(row, column);
      }
    }
  }
}

/// Solves for the derivatives by the modes: H^-1 times the value's derivatives by them.
void MarginalBlock::follow_modes(const RandomDesign& design) {
  if (rule_ == nullptr) follow_.setZero(modes_.modes().size());
  for (Index c = 0; c < modes_.cluster_count(); ++c) {
    auto follow = modes_.of_cluster(follow_, c);
    for (Index k = 0; k < modes_.group_count(c); ++k) {
      const auto turn = totals_.col(modes_.group_begin(c) + k).head(r_);
      const SmallVector own = design.joint.transpose().lazyProduct(turn);
      modes_.add_to_group(follow, c, k, own);
    }
    modes_.hessian(c).solve(follow);
  }
}

void MarginalBlock::add_group(const RandomDesign& design,
                              Index cluster,
                              Index group,
                              MarginalValue& result) const {
  const SmallMatrix& joint = design.joint;
  const Index k = group - modes_.group_begin(cluster);
  const auto turn = totals_.col(group).head(r_);
  const auto slope = modes_.slope(group);
  const SmallVector mode = modes_.of_group(modes_.of_cluster(modes_.modes(), cluster), cluster, k);
  const SmallVector follow = modes_.of_group(modes_.of_cluster(follow_, cluster), cluster, k);
  const SmallVector shift = joint.lazyProduct(follow);
  const SmallMatrix curvature = unpacked(modes_.curvatures(cluster).col(k).data(), r_);
  const SmallVector bend = curvature.lazyProduct(shift);

  add_coefficients(group, shift, bend, result);
  const SmallMatrix approximation = unpacked(modes_.approximations(cluster).col(k).data(), r_);
  const Eigen::Map<const MatrixXd> spread(spread_.col(group).data(), joint.cols(), joint.cols());
  const SmallMatrix bent = approximation.lazyProduct(joint);
  SmallMatrix by_design = bent.lazyProduct(spread);
  SmallVector along_mode = turn - bend;
  // With quadrature the direct derivatives are those of the nodes, which are included already.
  if (rule_ == nullptr) along_mode += slope;
  by_design += along_mode.lazyProduct(mode.transpose());
  by_design -= slope.lazyProduct(follow.transpose());
  Index column = 0;
  for (std::size_t t = 0; t < places_.rows.size(); ++t) {
    for (std::size_t i = 0; i < places_.rows[t].size(); ++i) {
      result.by_factors[t].row(static_cast<Index>(i)) +=
          by_design.row(places_.rows[t][i]).segment(column, places_.q(t));
    }
    column += places_.q(t);
  }
}

/// \param shift  (r) change of the random coefficients with the modes
/// \param bend   (r) the curvature times the shift
void MarginalBlock::add_coefficients(Index group,
                                     const SmallVector& shift,
                                     const SmallVector& bend,
                                     MarginalValue& result) const {
  const Index p = result.by_beta.size();
  const Index m = result.by_variance.size() + 1;
  const auto others = static_cast<Index>(sums_.others().size());
  const auto total = totals_.col(group);
  const auto other_random = total.segment(r_ + others + m, others * r_);
  const auto variance_random = total.tail(m * r_);
  const bool at_nodes = rule_ != nullptr;
  if (others < p) {
    const auto slope = modes_.slope(group);
    for (Index c = 0; c < r_; ++c) {
      const Index j = sums_.random()[static_cast<std::size_t>(c)];
      result.by_beta[j] += total[c] - bend[c] + (at_nodes ? 0.0 : slope[c]);
    }
  }
  for (Index o = 0; o < others; ++o) {
    const Index j = sums_.others()[static_cast<std::size_t>(o)];
    result.by_beta[j] += total[r_ + o] - other_random.segment(o * r_, r_).dot(shift) -
                         (at_nodes ? mode_slopes_(1 + j, group) : 0.0);
  }
  for (Index e = 0; e < m; ++e) {
    double& target = e + 1 < m ? result.by_variance[e] : result.by_log_sigma;
    target += total[r_ + others + e] - variance_random.segment(e * r_, r_).dot(shift) -
              (at_nodes ? mode_slopes_(1 + p + e, group) : 0.0);
  }
}

// ---- derivatives of the modes by the parameters ----

void MarginalBlock::keep(const RandomDesign& design) {
  kept_design_ = design;
  kept_modes_ = modes_.modes();
  kept_density_ = modes_.density();
  kept_totals_ = totals_;
}

SmallVector MarginalBlock::slope_change(const PointChange& change,
                                        const SmallMatrix& curvature,
                                        Index cluster,
                                        Index group) const {
  const VectorXd& beta = change.observation.beta;
  const auto others = static_cast<Index>(sums_.others().size());
  const Index m = change.observation.variance.size() + 1;
  const SmallVector mode = modes_.of_group(
      modes_.of_cluster(kept_modes_, cluster), cluster, group - modes_.group_begin(cluster));
  SmallVector shift = change.design.joint.lazyProduct(mode);
  if (others < beta.size()) {
    for (Index c = 0; c < r_; ++c) shift[c] += beta[sums_.random()[static_cast<std::size_t>(c)]];
  }
  SmallVector result = curvature.lazyProduct(shift);
  const auto mixed = kept_totals_.col(group).tail((others + m) * r_);
  for (Index o = 0; o < others; ++o) {
    const double moved = beta[sums_.others()[static_cast<std::size_t>(o)]];
    result += moved * mixed.segment(o * r_, r_);
  }
  for (Index e = 0; e < m; ++e) {
    const double moved = e + 1 < m ? change.observation.variance[e] : change.observation.log_sigma;
    result += moved * mixed.segment((others + e) * r_, r_);
  }
  return result;
}

void MarginalBlock::follow(const PointChange& change, VectorXd& modes) {
  // At a mode the gradient of the objective is zero: the mode moves by -H^-1 times the change of
  // the gradient by the parameters.
  constexpr double kFar = 1.0;  // squared standard deviation
  VectorXd step;
  for (Index c = 0; c < modes_.cluster_count(); ++c) {
    const Index begin = modes_.group_begin(c);
    const Index groups = modes_.group_count(c);
    const auto curvatures = kept_density_.block(1 + r_, begin, r_ * (r_ + 1) / 2, groups);
    if (!kept_hessian_.compute(modes_.pattern(c), kept_design_, curvatures)) continue;
    step.setZero(modes_.size_of(c));
    for (Index k = 0; k < groups; ++k) {
      const SmallMatrix curvature = unpacked(curvatures.col(k).data(), r_);
      const SmallVector turn = slope_change(change, curvature, c, begin + k);
      const auto slope = kept_density_.col(begin + k).segment(1, r_);
      SmallVector own = -kept_design_.joint.transpose().lazyProduct(turn);
      own -= change.design.joint.transpose().lazyProduct(slope);
      modes_.add_to_group(step, c, k, own);
    }
    const VectorXd right = step;
    kept_hessian_.solve(step);
    if (!(right.dot(step) < kFar)) continue;
    modes.segment(modes_.layout().begin(modes_.first_cluster() + c), step.size()) += step;
  }
}

}  // namespace silvafit::fit
