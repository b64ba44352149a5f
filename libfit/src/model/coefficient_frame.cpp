// SPDX-License-Identifier: MIT
#include "model/coefficient_frame.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

namespace silvafit::fit {
namespace {

// A column with a relatively smaller part orthogonal to the others depends on them.
constexpr double kDependent = 1e-11;
// Columns of effects with a larger part orthogonal to the others need no mixing.
constexpr double kNearlyDependent = 0.01;

/// A column less its projection on those before it.
struct OrthogonalColumn {
  VectorXd combination{};  ///< (p) of the columns
  bool is_dependent = false;
};

/// Orthogonalizes columns one after the other (Gram-Schmidt).
class Orthogonalizer {
 public:
  /// \param columns  (m x p)
  explicit Orthogonalizer(const MatrixXd& columns) : columns_(columns) {}

  /// Column j less its projection on those before it, normalized. If it depends on those before it,
  /// column j itself is normalized.
  OrthogonalColumn add(Index j) {
    VectorXd combination = VectorXd::Unit(columns_.cols(), j);
    VectorXd rest = columns_.col(j);
    const double length = rest.norm();
    if (!std::isfinite(length) || length == 0.0) return {combination, true};
    combination /= length;
    rest /= length;
    // The second pass removes the rounding errors of the first.
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t k = 0; k < directions_.size(); ++k) {
        const double share = directions_[k].dot(rest);
        rest -= share * directions_[k];
        combination -= share * combinations_[k];
      }
    }
    const double share = rest.norm();
    if (share <= kDependent) return {combination, true};
    smallest_share_ = std::min(smallest_share_, share);
    directions_.push_back(rest / share);
    combinations_.push_back(combination / share);
    return {combinations_.back()};
  }

  /// The smallest orthogonal part of the columns that do not depend on those before them.
  double smallest_share() const { return smallest_share_; }

 private:
  const MatrixXd& columns_;
  std::vector<VectorXd> directions_;
  std::vector<VectorXd> combinations_;
  double smallest_share_ = 1.0;
};

/// (p x p) R of the QR decomposition of a Jacobian: columns with the same lengths and angles.
MatrixXd same_angles(MatrixXd& jacobian) {
  if (!jacobian.allFinite() || jacobian.rows() < jacobian.cols()) return jacobian;
  // In place: the Jacobian is as long as the data.
  const Eigen::HouseholderQR<Eigen::Ref<MatrixXd>> qr(jacobian);
  return qr.matrixQR().topRows(jacobian.cols()).triangularView<Eigen::Upper>();
}

/// The factor that gives a column the requested length.
double unit_of(const VectorXd& column, double length) {
  const double unit = length / column.stableNorm();
  return std::isfinite(unit) && unit > 0.0 ? unit : 1.0;
}

/// Begins and ends of the blocks of effects whose covariances are free.
template <typename Visit>
void for_each_free_block(const RandomEffects& random, const Visit& visit) {
  if (random.has_equal_variances()) return;
  Index begin = 0;
  for (const int size : random.block_sizes()) {
    if (size > 1) visit(begin, begin + size);
    begin += size;
  }
}

/// (q x q) U of a term.
MatrixXd effect_frame(const NonlinearModel& model,
                      const RandomEffects& random,
                      const MatrixXd& columns,
                      double length) {
  const std::vector<Index> places = model.coefficients_of(random);
  const auto q = static_cast<Index>(places.size());
  MatrixXd result = MatrixXd::Zero(q, q);
  for (Index k = 0; k < q; ++k) {
    result(k, k) = unit_of(columns.col(places[static_cast<std::size_t>(k)]), length);
  }
  for_each_free_block(random, [&](Index begin, Index end) {
    Orthogonalizer block(columns);
    MatrixXd mixed = result;
    for (Index k = end - 1; k >= begin; --k) {
      const OrthogonalColumn column = block.add(places[static_cast<std::size_t>(k)]);
      if (!column.is_dependent) mixed.col(k) = length * column.combination(places);
    }
    if (block.smallest_share() < kNearlyDependent) result = mixed;
  });
  return result;
}

/// Coefficients with random effects that may be mixed with others, block by block: those that are a
/// block of each term. Those with random effects only are not mixed: the fixed effects of others
/// would move their means.
std::vector<std::vector<Index>> blocks_of_columns(const NonlinearModel& model) {
  std::vector<std::vector<std::vector<Index>>> blocks;  // of each term
  for (const RandomEffects& random : model.specification().random) {
    const std::vector<Index> places = model.coefficients_of(random);
    auto& of_term = blocks.emplace_back();
    for_each_free_block(random, [&](Index begin, Index end) {
      of_term.emplace_back(places.begin() + begin, places.begin() + end);
    });
  }
  if (blocks.empty()) return {};
  std::vector<std::vector<Index>> result = blocks.back();
  std::erase_if(result, [&](const std::vector<Index>& block) {
    return std::ranges::any_of(
        blocks, [&](const auto& of) { return std::ranges::find(of, block) == of.end(); });
  });
  for (std::vector<Index>& block : result) {
    std::erase_if(block, [&](Index j) { return j >= model.coefficient_count(); });
  }
  return result;
}

/// (p x p) T such that the columns of J T are orthogonal, as far as this is possible if each column
/// with random effects is a combination of those in its block only; diagonal if no columns are
/// nearly dependent. Columns that depend on others are unchanged.
MatrixXd shared_columns(const NonlinearModel& model, const MatrixXd& columns, double length) {
  const Index p = columns.cols();
  MatrixXd scaled = MatrixXd::Zero(p, p);
  for (Index j = 0; j < p; ++j) scaled(j, j) = unit_of(columns.col(j), length);
  MatrixXd result = scaled;
  for (const std::vector<Index>& block : blocks_of_columns(model)) {
    Orthogonalizer of_block(columns);
    for (auto j = block.rbegin(); j != block.rend(); ++j) {
      const OrthogonalColumn column = of_block.add(*j);
      if (!column.is_dependent) result.col(*j) = length * column.combination;
    }
  }
  // Columns without random effects are last, because they may be mixed with all others.
  std::vector<Index> random;
  const std::vector<std::vector<Index>> terms = model.random_coefficients();
  for (auto places = terms.rbegin(); places != terms.rend(); ++places) {
    std::ranges::copy_if(*places, std::back_inserter(random), [&](Index j) {
      return j < model.coefficient_count();
    });
  }
  Orthogonalizer all(columns);
  for (const Index j : random) all.add(j);
  for (Index j = 0; j < model.coefficient_count(); ++j) {
    if (std::ranges::find(random, j) != random.end()) continue;
    const OrthogonalColumn column = all.add(j);
    if (!column.is_dependent) result.col(j) = length * column.combination;
  }
  return all.smallest_share() < kNearlyDependent ? result : scaled;
}

}  // namespace

CoefficientFrame orthogonal_frame(const NonlinearModel& model, MatrixXd jacobian, double length) {
  const MatrixXd columns = same_angles(jacobian);
  const Index p = model.coefficient_count();
  CoefficientFrame frame{.beta = MatrixXd(p, p)};
  for (const RandomEffects& random : model.specification().random) {
    frame.effects.push_back(effect_frame(model, random, columns, length));
  }
  Orthogonalizer all(columns);
  for (Index j = 0; j < p; ++j) {
    const OrthogonalColumn column = all.add(j);
    frame.beta.col(j) = length * column.combination.head(p);
    if (column.is_dependent) frame.has_full_rank = false;
  }
  return frame;
}

CoefficientFrame shared_frame(const NonlinearModel& model, MatrixXd jacobian, double length) {
  const MatrixXd columns = same_angles(jacobian);
  const MatrixXd all = shared_columns(model, columns, length);
  const Index p = model.coefficient_count();
  CoefficientFrame frame{.beta = all.topLeftCorner(p, p)};
  for (const std::vector<Index>& places : model.random_coefficients()) {
    frame.effects.emplace_back(all(places, places));
  }
  frame.random_only = all.diagonal().tail(all.cols() - p);
  return frame;
}

VectorXd CoefficientFrame::units() const {
  VectorXd result(beta.cols() + random_only.size());
  result << beta.diagonal(), random_only;
  return result;
}

MatrixXd CoefficientFrame::mixing() const {
  if (beta.isDiagonal(0.0)) return {};
  const Index p = beta.cols();
  MatrixXd result = MatrixXd::Identity(p + random_only.size(), p + random_only.size());
  result.topLeftCorner(p, p) = beta * beta.diagonal().cwiseInverse().asDiagonal();
  return result;
}

namespace {

template <typename MakeFrame>
CoefficientFrame made_at(const NonlinearModel& model,
                         const VectorXd& coefficients,
                         const MakeFrame& make) {
  auto [mean, jacobian] = model.curve_at(model.extended(coefficients));
  const double length = (model.response() - mean).norm();
  return make(model, std::move(jacobian), std::isfinite(length) && length > 0.0 ? length : 1.0);
}

}  // namespace

CoefficientFrame frame_at(const NonlinearModel& model, const VectorXd& coefficients) {
  return made_at(model, coefficients, orthogonal_frame);
}

CoefficientFrame shared_frame_at(const NonlinearModel& model, const VectorXd& coefficients) {
  return made_at(model, coefficients, shared_frame);
}

}  // namespace silvafit::fit
