// SPDX-License-Identifier: MIT
#include "conditional_modes/calibration_search.hpp"

#include <algorithm>
#include <utility>

#include "conditional_modes/calibration_block.hpp"
#include "model/covariance_factor.hpp"
#include "result/group_coefficients.hpp"
#include "result/nested_effects.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/parallel.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Rows of a block of clusters: their data stay in the cache while effects are searched.
constexpr Index kBlockRows = 4096;

/// (r x k) rows of a root placed where its effects are among the random coefficients.
void place(const MatrixXd& root, const std::vector<Index>& rows, SmallMatrix& target) {
  if (root.cols() == 0) return;  // rows of nothing have no address
  for (std::size_t k = 0; k < rows.size(); ++k) {
    target.row(rows[k]) += root.row(static_cast<Index>(k));
  }
}

RandomDesign design_of(const EffectRoots& roots, const EffectPlaces& places) {
  const auto r = static_cast<Index>(places.random.size());
  RandomDesign design{.outer = SmallMatrix::Zero(r, places.s()),
                      .inner = SmallMatrix::Zero(r, places.q())};
  place(roots.outer, places.outer_rows, design.outer);
  place(roots.coupling, places.inner_rows, design.outer);
  place(roots.inner, places.inner_rows, design.inner);
  return design;
}

EffectPosteriors empty_posteriors(const NonlinearModel& model, const EffectPlaces& places) {
  const Index s = places.s();
  const Index q = places.q();
  const Index p = model.coefficient_count();
  const Index groups = model.group_count();
  const Index clusters = s > 0 ? model.cluster_count() : 0;
  EffectPosteriors result;
  result.inner.setConstant(q, groups, kNaN);
  result.inner_uncertainty = {.covariances = MatrixXd::Constant(q * q, groups, kNaN),
                              .sensitivities = MatrixXd::Constant(q * p, groups, kNaN),
                              .cross_covariances = MatrixXd::Constant(q * s, groups, kNaN)};
  result.outer.setConstant(s, clusters, kNaN);
  result.outer_uncertainty = {.covariances = MatrixXd::Constant(s * s, clusters, kNaN),
                              .sensitivities = MatrixXd::Constant(s * p, clusters, kNaN)};
  return result;
}

/// \param known  (r x G) effects that are taken for the solution, or null to search
EffectPosteriors run(const NonlinearModel& model,
                     const FittedModel& fit,
                     const EffectPriors& priors,
                     unsigned threads,
                     const MatrixXd* known) {
  const EffectPlaces places(fit);
  const CalibrationTerms terms(model, fit, places.random);
  CalibrationSetting shared{.model = model,
                            .priors = priors,
                            .terms = terms,
                            .places = places,
                            .is_linearized = fit.method == Method::kLindstromBates};
  for (const EffectRoots& roots : priors.roots) shared.designs.push_back(design_of(roots, places));
  const auto r = static_cast<Index>(places.random.size());
  shared.offsets.setZero(r, model.group_count());
  add_group_effects(model,
                    {.rows = places.inner_rows, .effects = priors.inner_mean},
                    {.rows = places.outer_rows, .effects = priors.outer_mean},
                    shared.offsets);
  EffectPosteriors result = empty_posteriors(model, places);
  std::vector<std::pair<Index, Index>> ranges;
  for (Index first = 0, c = 0; c < model.cluster_count(); ++c) {
    const Index rows = model.group_begin(model.cluster_begin(c + 1)) -
                       model.group_begin(model.cluster_begin(first));
    if (rows < kBlockRows && c + 1 < model.cluster_count()) continue;
    ranges.emplace_back(first, c + 1);
    first = c + 1;
  }
  MatrixXd effects = known != nullptr ? *known : MatrixXd(r, model.group_count());
  VectorXd held(terms.holds_weights() ? model.observations() : 0);
  VectorXd own = held;
  held.setOnes();
  parallel_for(ranges.size(), threads, [&](std::size_t b) {
    calibrate_block(
        shared, ranges[b].first, ranges[b].second, known != nullptr, effects, held, own, result);
  });
  return result;
}

}  // namespace

EffectPlaces::EffectPlaces(const FittedModel& fit) {
  const auto place_of = [&](const std::string& name) -> Index {
    return std::ranges::find(fit.coefficient_names, name) - fit.coefficient_names.begin();
  };
  for (const auto& names : {coarser(fit).names, finer(fit).names}) {
    for (const std::string& name : names) random.push_back(place_of(name));
  }
  std::ranges::sort(random);
  random.erase(std::unique(random.begin(), random.end()), random.end());
  const auto row_of = [&](const std::string& name) -> Index {
    return std::ranges::find(random, place_of(name)) - random.begin();
  };
  for (const std::string& name : coarser(fit).names) outer_rows.push_back(row_of(name));
  for (const std::string& name : finer(fit).names) inner_rows.push_back(row_of(name));
}

EffectPriors unseen_priors(const NonlinearModel& model, const FittedModel& fit) {
  const auto q = static_cast<Index>(finer(fit).names.size());
  const auto s = static_cast<Index>(coarser(fit).names.size());
  EffectPriors priors;
  priors.roots.push_back({.outer = covariance_factor(coarser(fit).covariance),
                          .coupling = MatrixXd::Zero(q, s),
                          .inner = covariance_factor(finer(fit).covariance)});
  priors.roots_of.assign(static_cast<std::size_t>(model.group_count()), 0);
  priors.inner_mean.setZero(q, model.group_count());
  priors.outer_mean.setZero(s, s > 0 ? model.cluster_count() : 0);
  return priors;
}

EffectPosteriors find_effects(const NonlinearModel& model,
                              const FittedModel& fit,
                              const EffectPriors& priors,
                              unsigned threads) {
  return run(model, fit, priors, threads, nullptr);
}

EffectPosteriors describe_effects(const NonlinearModel& model, const FittedModel& fit) {
  const EffectPlaces places(fit);
  MatrixXd effects = MatrixXd::Zero(static_cast<Index>(places.random.size()), model.group_count());
  add_group_effects(model,
                    {.rows = places.inner_rows, .effects = finer(fit).effects},
                    {.rows = places.outer_rows, .effects = coarser(fit).effects},
                    effects);
  return run(model, fit, unseen_priors(model, fit), model.threads(), &effects);
}

}  // namespace silvafit::fit
