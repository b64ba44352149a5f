// SPDX-License-Identifier: MIT
#include "likelihood/marginal_likelihood.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"

namespace silvafit::fit {
namespace {

// Rows of a block of clusters, so few that their data fit into the cache during searches.
constexpr Index kCacheRows = 4096;

}  // namespace

Curvature curvature_of(Method method) {
  if (method == Method::kFirstOrder) return Curvature::kFirstOrder;
  return method == Method::kInteraction ? Curvature::kExpected : Curvature::kFull;
}

MarginalLikelihood::MarginalLikelihood(const NonlinearModel& model,
                                       const VarianceModel& variance,
                                       Curvature curvature,
                                       int points,
                                       const SharedClusters* shared)
    : model_(model),
      shared_(shared),
      places_(model),
      layout_(model),
      sums_(make_group_sums(model, variance, curvature, places_.all)),
      workspaces_(worker_count(model.threads())) {
  if (points > 1) rule_ = gauss_hermite(points, places_.q(0));
  modes_.setZero(layout_.size());
  effects_.setZero(sums_->random_count(), model.group_count());
  cut_into_blocks();
}

void MarginalLikelihood::cut_into_blocks() {
  const QuadratureRule* const rule = rule_.weights.size() > 0 ? &rule_ : nullptr;
  if (shared_ != nullptr) {
    const std::vector<Index>& begin = shared_->block_begin;
    for (std::size_t b = 0; b + 1 < begin.size(); ++b) add_block(rule, begin[b], begin[b + 1]);
    return;
  }
  Index first = 0;
  Index rows = 0;
  for (Index c = 0; c < model_.cluster_count(); ++c) {
    rows += model_.group_begin(model_.cluster_begin(c + 1)) -
            model_.group_begin(model_.cluster_begin(c));
    if (rows < kCacheRows && c + 1 < model_.cluster_count()) continue;
    add_block(rule, first, c + 1);
    first = c + 1;
    rows = 0;
  }
}

void MarginalLikelihood::add_block(const QuadratureRule* rule, Index first, Index last) {
  blocks_.push_back(
      std::make_unique<MarginalBlock>(model_, layout_, *sums_, places_, rule, first, last));
}

RandomDesign MarginalLikelihood::design_of(const MarginalPoint& point) const {
  return {.joint = places_.joint(point.factors),
          .shared = layout_.joint_count() - layout_.count(layout_.terms() - 1)};
}

void MarginalLikelihood::set_modes(VectorXd modes) {
  modes_ = std::move(modes);
  starts_from_kept_ = false;
}

void MarginalLikelihood::keep_modes(const MarginalPoint& point) {
  kept_ = modes_;
  kept_at_ = point;
  const RandomDesign design = design_of(point);
  for (const auto& block : blocks_) block->keep(design);
}

void MarginalLikelihood::set_kept_modes() {
  modes_ = kept_;
  starts_from_kept_ = true;
}

MarginalValue MarginalLikelihood::evaluate(const MarginalPoint& point, bool with_gradient) {
  if (!std::exchange(starts_from_kept_, false)) return value(point, with_gradient, nullptr);
  const RandomDesign now = design_of(point);
  const RandomDesign then = design_of(kept_at_);
  const ObservationPoint& at = point.observation;
  const ObservationPoint& from = kept_at_.observation;
  const PointChange change{.observation = {.beta = at.beta - from.beta,
                                           .variance = at.variance - from.variance,
                                           .log_sigma = at.log_sigma - from.log_sigma},
                           .design = {.joint = now.joint - then.joint, .shared = now.shared}};
  MarginalValue result = value(point, with_gradient, &change);
  if (std::isfinite(result.minus_log_likelihood)) return result;
  return value(point, with_gradient, nullptr);
}

/// The sum over the blocks of all ranks.
MarginalValue MarginalLikelihood::total_of(const std::vector<MarginalValue>& parts,
                                           const MarginalPoint& point) const {
  if (shared_ != nullptr) {
    MarginalValue total = MarginalValue::zero(point);
    std::vector<VectorXd> own;
    own.reserve(parts.size());
    for (const MarginalValue& part : parts) own.push_back(part.numbers());
    total.set_numbers(sum_over_ranks(own, total.numbers().size()));
    return total;
  }
  MarginalValue total = parts.front();
  for (std::size_t b = 1; b < parts.size(); ++b) total.add(parts[b]);
  return total;
}

/// \param change  from the point of the stored modes, from which the search starts; or null
MarginalValue MarginalLikelihood::value(const MarginalPoint& point,
                                        bool with_gradient,
                                        const PointChange* change) {
  model_.check_stop();
  sums_->set_point(point.observation);
  const RandomDesign design = design_of(point);
  VectorXd modes = modes_;
  std::vector<MarginalValue> parts(blocks_.size());
  parallel_for(parts.size(), model_.threads(), [&](std::size_t b, std::size_t worker) {
    if (change != nullptr) blocks_[b]->follow(*change, modes);
    parts[b] =
        blocks_[b]->value(point, design, modes, effects_, workspaces_[worker], with_gradient);
  });
  MarginalValue total = total_of(parts, point);
  const Index observations = shared_ != nullptr ? shared_->observations : model_.observations();
  total.minus_log_likelihood +=
      0.5 * static_cast<double>(observations) * std::log(2.0 * std::numbers::pi);
  if (std::isfinite(total.minus_log_likelihood)) {
    std::swap(modes_, modes);
  } else {
    total.minus_log_likelihood = kInfinity;
  }
  return total;
}

std::optional<VectorXd> MarginalLikelihood::find_modes(const MarginalPoint& point,
                                                       VectorXd& modes,
                                                       const VectorXd* known) {
  model_.check_stop();
  sums_->set_point(point.observation);
  const RandomDesign design = design_of(point);
  VectorXd objectives = VectorXd::Constant(model_.cluster_count(), kInfinity);
  std::vector<char> is_found(blocks_.size(), 0);
  parallel_for(blocks_.size(), model_.threads(), [&](std::size_t b, std::size_t worker) {
    const bool found =
        blocks_[b]->find_modes(design, modes, effects_, workspaces_[worker], known, objectives);
    is_found[b] = found ? 1 : 0;
  });
  const bool fails = std::ranges::find(is_found, 0) != is_found.end();
  if (shared_ != nullptr ? is_on_any_rank(fails) : fails) return std::nullopt;
  return objectives;
}

}  // namespace silvafit::fit
