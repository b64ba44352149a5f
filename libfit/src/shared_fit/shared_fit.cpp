// SPDX-License-Identifier: MIT
#include "silvafit/fit/shared_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "fit_model/doubts.hpp"
#include "likelihood/effect_posteriors.hpp"
#include "likelihood/integration_method.hpp"
#include "marginal_likelihood/marginal_search.hpp"
#include "mixed_effects/degrees_of_freedom.hpp"
#include "mixed_effects/mixed_effects_evidence.hpp"
#include "model/response_fingerprint.hpp"
#include "result/group_coefficients.hpp"
#include "shared_fit/shared_sums.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/program.hpp"

namespace silvafit::fit {
namespace {

Integration shared_integration(Method method) {
  if (const auto integration = integration_of(method)) return *integration;
  throw UsageError(
      fmt::format("groups can be shared for the methods foce, focei, laplace and agq, not for {}; "
                  "use `method=laplace`",
                  word_of(method)));
}

void check(const ModelSpecification& specification, const FitModelOptions& options) {
  if (specification.random.size() != 1 || are_crossed(specification.random)) {
    throw UsageError("shared groups need random effects of one grouping");
  }
  for (const VarianceFactor& factor : specification.variance.factors) {
    if (!factor.stratum.empty()) {
      throw UsageError("groups cannot be shared for a variance function with strata");
    }
  }
  if (specification.correlation) {
    throw UsageError("groups cannot be shared with correlated residuals");
  }
  if (!options.fixed.empty() || !options.bounds.empty()) {
    throw UsageError("groups cannot be shared for coefficients that are fixed or bounded");
  }
}

/// Rows without missing values, which a model can use.
bool has_observations(const ModelSpecification& specification, const data::Table& table) {
  std::vector<std::string> columns = specification.predictors();
  columns.push_back(specification.formula.left);
  for (const VarianceFactor& factor : specification.variance.factors) {
    if (!factor.column.empty()) columns.push_back(factor.column);
  }
  std::vector<std::vector<double>> values;
  values.reserve(columns.size());
  for (const std::string& column : columns) values.push_back(data::variable_values(column, table));
  const data::TextColumn groups = table.labels(specification.random.front().group);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const bool is_complete = !groups.is_missing(row) && std::ranges::none_of(values, [&](auto& of) {
      return std::isnan(of[row]);
    });
    if (is_complete) return true;
  }
  return false;
}

/// Labels determine the columns of a factor, so that all ranks need the same ones.
void check_levels(const NonlinearModel& own, const NonlinearModel& sample) {
  for (const auto& [column, labels] : own.levels()) {
    const auto known = sample.levels().find(column);
    for (const std::string& label : labels) {
      if (known != sample.levels().end() && known->second.contains(label)) continue;
      throw InputError(fmt::format("the label '{}' is too rare for shared groups; remove its rows "
                                   "with `where`, or give them another label",
                                   label),
                       {.file = own.place(0).file, .column = column});
    }
  }
}

/// First clusters of the parts that have observations, and the end.
std::vector<Index> blocks_of(const NonlinearModel& model, const std::vector<std::size_t>& parts) {
  std::vector<Index> begin{0};
  const auto part_of = [&](Index cluster) {
    const Index row = model.group_begin(model.cluster_begin(cluster));
    return parts[model.rows()[static_cast<std::size_t>(row)]];
  };
  for (Index c = 1; c < model.cluster_count(); ++c) {
    if (part_of(c) != part_of(c - 1)) begin.push_back(c);
  }
  begin.push_back(model.cluster_count());
  return begin;
}

/// Without a method of its own a sample might be fitted by another one than the whole data.
FitModelOptions by(Method method, FitModelOptions options) {
  options.method = method;
  return options;
}

class SharedFit {
 public:
  SharedFit(const ModelSpecification& specification,
            SharedData data,
            const FitModelOptions& options)
      : options_(options),
        method_(options.method.value_or(default_method(specification))),
        integration_(shared_integration(method_)),
        sample_fit_(fit_model(specification, data.sample, by(method_, options)).fit),
        sample_(specification, data.sample, options.threads, options.stop) {
    if (data.own && has_observations(specification, *data.own)) {
      own_.emplace(specification, *data.own, options.threads, options.stop);
      check_levels(*own_, sample_);
      clusters_.block_begin = blocks_of(*own_, data.parts);
    }
    excluded_ = data.own ? static_cast<double>(data.own->rows()) : 0.0;
    if (own_) excluded_ -= static_cast<double>(own_->observations());
    data.own.reset();
  }

  FittedModel fit() {
    if (!sample_fit_.estimate.allFinite() || !(sample_fit_.sigma > 0.0)) return sample_fit_;
    count();
    MixedEffectsFit start;
    static_cast<Estimates&>(start) = static_cast<const Estimates&>(sample_fit_);
    clusters_.frame = frame_at(sample_, start.estimate);
    const VarianceModel variance(sample_.specification().variance, VarianceData::of(sample_));
    clusters_.typical = variance.typical_values();
    start.random.back().effects =
        MatrixXd::Zero(start.random.back().effects.rows(), model().group_count());
    const MixedEffectsOptions marginal{.quadrature_points = options_.quadrature_points,
                                       .trace = options_.trace};
    MarginalSearch search(model(), integration_, marginal, start.estimate, &clusters_);
    search.try_fit(start);
    if (!search.has_optimum()) return without_optimum();
    return described(search.result(), search.obstacle(), variance);
  }

 private:
  /// A rank without observations has the model of the sample with zero clusters.
  const NonlinearModel& model() const { return own_ ? *own_ : sample_; }
  SharedModel shared() const { return {.model = model(), .clusters = clusters_}; }

  void count() {
    const double rows = own_ ? static_cast<double>(own_->observations()) : 0.0;
    const std::vector<double> own{static_cast<double>(shared().group_count()), rows, excluded_};
    counts_ = added_up(own);
    clusters_.observations = static_cast<Index>(counts_[1]);
  }

  FittedModel without_optimum() {
    FittedModel fit = sample_fit_;
    fit.convergence.conclude(ConvergenceStatus::kInvalidApproximation,
                             {.kind = Finding::Kind::kInvalidForSample,
                              .values = {static_cast<double>(sample_.observations())}});
    return fit;
  }

  FittedModel described(MixedEffectsFit local,
                        const Obstacle& obstacle,
                        const VarianceModel& variance) {
    FittedModel fit = sample_fit_;
    add_shared_statistics_of(local, fit);
    EstimatedEffects& effects = local.random.back();
    MatrixXd own_effects = effects.effects;
    effects.effects = joined_columns(effects.effects.leftCols(shared().group_count()));
    const std::vector<std::string>& own_labels = model().group_labels();
    const std::vector<std::string> labels =
        joined_texts({own_labels.begin(), own_labels.begin() + shared().group_count()});
    const auto floored = static_cast<std::uint64_t>(own_ ? local.floored_variances : 0);

    // The sample shows whether the parameters are identifiable.
    MixedEffectsFit judged = local;
    judged.random.back().effects =
        effects_by_label(labels, effects.effects, sample_.group_labels());
    const Eigen::VectorXd parameters = variance.parameters(judged.variance);
    fill_in_fitted(
        sample_, variance, judged.sigma / variance.sigma_factor(parameters), parameters, judged);
    describe(sample_, judged);
    judged.floored_variances = static_cast<Index>(added_up(floored));
    judge_with_sample(obstacle, judged);
    judged.degrees_of_freedom =
        fixed_freedom_at(sample_, judged.estimate, {counts_[0], counts_[1]}).of_tests;
    judged.random.back().labels = labels;
    static_cast<Estimates&>(fit) = std::move(judged);
    fit.random.back().effects = std::move(own_effects);
    fit.random.back().uncertainty = uncertainty_of(fit);
    fit.random.back().effects = std::move(effects.effects);
    if (sample_.observations() < clusters_.observations) {
      fit.convergence.find({.kind = Finding::Kind::kSampleStart,
                            .values = {static_cast<double>(sample_.observations())}});
    }
    return fit;
  }

  /// Scales the covariance to the size of the sample: otherwise small standard errors, impossible
  /// with so few groups, would be treated as those of a singular information matrix.
  void judge_with_sample(const Obstacle& obstacle, MixedEffectsFit& fit) const {
    const double size = counts_[0] / static_cast<double>(sample_.group_count());
    const MatrixXd covariance = fit.covariance;
    fit.covariance *= size;
    judge(sample_, fit, Rounds::kEvaluations, false, obstacle);
    // Coefficients that are not identifiable have none now.
    fit.covariance = fit.covariance.array().isNaN().select(fit.covariance, covariance);
  }

  /// Of the random effects of all groups.
  /// \param fit  with those of this rank
  EffectUncertainty uncertainty_of(const FittedModel& fit) {
    const std::vector<EffectPosterior> described =
        describe_effects(model(), fit, clusters_.block_begin, clusters_.typical);
    const EffectUncertainty& own = described.back().uncertainty;
    const Index groups = shared().group_count();
    EffectUncertainty result{.covariances = joined_columns(own.covariances.leftCols(groups)),
                             .sensitivities = joined_columns(own.sensitivities.leftCols(groups))};
    result.cross_covariances.resize(0, result.covariances.cols());
    return result;
  }

  /// The results that do not need the names of the groups.
  void add_shared_statistics_of(const MixedEffectsFit& local, FittedModel& fit) {
    fit.excluded = static_cast<Index>(counts_[2]);
    fit.response_fingerprint =
        response_fingerprint(added_up(own_ ? response_sum(own_->response()) : std::uint64_t{0}));
    fit.ranges = shared_ranges(shared(), fit.ranges);
    fit.estimate = local.estimate;
    fit.random.back().covariance = local.random.back().covariance;
    add_shared_statistics(shared(), local, fit);
  }

  const FitModelOptions& options_;
  Method method_;
  Integration integration_;
  FittedModel sample_fit_;
  NonlinearModel sample_;
  std::optional<NonlinearModel> own_{};
  SharedClusters clusters_{};
  double excluded_ = 0.0;         ///< rows of this rank
  std::vector<double> counts_{};  ///< of all ranks: groups, observations, rows that are excluded
};

}  // namespace

FittedModel fit_shared(const ModelSpecification& specification,
                       SharedData data,
                       const FitModelOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  check(specification, options);
  FittedModel fit = SharedFit(specification, std::move(data), options).fit();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  fit.seconds = elapsed.count();
  add_name_doubts(options, fit);
  return fit;
}

}  // namespace silvafit::fit
