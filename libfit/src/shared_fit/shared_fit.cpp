// SPDX-License-Identifier: MIT
#include "silvafit/fit/shared_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fit_model/doubts.hpp"
#include "likelihood/effect_posteriors.hpp"
#include "likelihood/shared_clusters.hpp"
#include "marginal_likelihood/marginal_search.hpp"
#include "mixed_effects/degrees_of_freedom.hpp"
#include "mixed_effects/mixed_effects_evidence.hpp"
#include "model/response_fingerprint.hpp"
#include "result/group_coefficients.hpp"
#include "result/variance_shares.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/ranks.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/data/row_sums.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/mixed_effects.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {
namespace {

using Eigen::ArrayXd;

Method marginal_method(Method method) {
  if (is_marginal(method)) return method;
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

/// A rank's model and the range of its clusters.
struct SharedModel {
  const NonlinearModel& model;
  const SharedClusters& clusters;

  /// Groups of these clusters.
  Index group_count() const { return model.cluster_begin(clusters.block_begin.back()); }
};

std::vector<std::vector<double>> numbers_of_ranks(const std::vector<double>& own) {
  std::string bytes;
  append_numbers(own.data(), own.size(), bytes);
  std::vector<std::vector<double>> result;
  for (const std::string& of_rank : Ranks::of_process().gather(bytes)) {
    std::string_view rest = of_rank;
    result.push_back(take_numbers(rest));
  }
  return result;
}

/// A sum over the rows of all ranks, block by block.
/// \param columns  (N x k) of this rank
VectorXd sum_of_rows(const SharedModel& shared, const MatrixXd& columns) {
  const NonlinearModel& model = shared.model;
  const std::vector<Index>& begin = shared.clusters.block_begin;
  std::vector<VectorXd> blocks;
  for (std::size_t b = 0; b + 1 < begin.size(); ++b) {
    const Index first = model.group_begin(model.cluster_begin(begin[b]));
    const Index end = model.group_begin(model.cluster_begin(begin[b + 1]));
    VectorXd& sums = blocks.emplace_back(columns.cols());
    // Eigen's sums depend on the memory alignment of the rows.
    for (Index k = 0; k < columns.cols(); ++k) {
      sums[k] = data::sum(columns.col(k).data() + first, static_cast<std::size_t>(end - first));
    }
  }
  return sum_over_ranks(blocks, columns.cols());
}

/// Statistics as fit_statistics() computes them, from sums.
struct ErrorSums {
  double n = 0.0;
  double total = 0.0;     ///< squares of the response around its mean
  double error = 0.0;     ///< sum of the errors
  double absolute = 0.0;  ///< of their sizes
  double squares = 0.0;   ///< of their squares
  double spread = 0.0;    ///< squares around their mean

  FitStatistics statistics() const {
    const double mean_error = error / n;
    return {.r2 = total > 0.0 ? 1.0 - squares / total : kNaN,
            .mean_error = mean_error,
            .rmse = std::sqrt(mean_error * mean_error + (n > 1.0 ? spread / (n - 1.0) : 0.0)),
            .mae = absolute / n};
  }
};

/// Numbers of this rank, added to those of all others.
std::vector<double> added_up(const std::vector<double>& own) {
  std::vector<double> sum(own.size(), 0.0);
  for (const std::vector<double>& numbers : numbers_of_ranks(own)) {
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += numbers[k];
  }
  return sum;
}

std::uint64_t added_up(std::uint64_t own) {
  std::uint64_t sum = 0;
  const std::string_view bytes(reinterpret_cast<const char*>(&own), sizeof own);
  for (const std::string& of_rank : Ranks::of_process().gather(bytes)) {
    std::uint64_t one = 0;
    std::memcpy(&one, of_rank.data(), sizeof one);
    sum += one;
  }
  return sum;
}

/// Texts of all ranks, in the order of the ranks.
std::vector<std::string> joined_texts(const std::vector<std::string>& own) {
  std::string bytes;
  for (const std::string& text : own) append_text(text, bytes);
  std::vector<std::string> result;
  for (const std::string& of_rank : Ranks::of_process().gather(bytes)) {
    std::string_view rest = of_rank;
    while (!rest.empty()) result.push_back(take_text(rest));
  }
  return result;
}

/// Columns of all ranks, in the order of the ranks.
/// \param own  (rows x any)
MatrixXd joined_columns(const MatrixXd& own) {
  const Index rows = own.rows();
  const std::vector<double> values(own.data(), own.data() + own.size());
  const std::vector<std::vector<double>> all = numbers_of_ranks(values);
  Index columns = 0;
  for (const auto& numbers : all) columns += static_cast<Index>(numbers.size()) / rows;
  MatrixXd result(rows, columns);
  double* target = result.data();
  for (const auto& numbers : all) target = std::ranges::copy(numbers, target).out;
  return result;
}

/// Sets the statistics of the fit to all observations: R2, errors, shares of the variance.
/// \param local  the fit with the fitted values of this rank
void add_shared_statistics(const SharedModel& shared,
                           const MixedEffectsFit& local,
                           FittedModel& fit) {
  const NonlinearModel& model = shared.model;
  const ArrayXd response = model.response().array();
  const ArrayXd population = response - local.fitted_population.array();
  const ArrayXd conditional = response - local.fitted_conditional.array();
  const auto [mean, slopes] = model.curve_at(model.extended(fit.estimate));
  MatrixXd columns(model.observations(), 10);
  columns << ArrayXd::Ones(response.size()), response, population, population.abs(),
      population.square(), conditional, conditional.abs(), conditional.square(), mean,
      variance_of_effects(fit, model, slopes);
  const VectorXd sums = sum_of_rows(shared, columns);
  const double n = sums[0];
  MatrixXd around(model.observations(), 5);
  around << (response - sums[1] / n).square(), (population - sums[2] / n).square(),
      (conditional - sums[5] / n).square(), (mean.array() - sums[8] / n).square(),
      local.residual_sd.array().square();
  const VectorXd squares = sum_of_rows(shared, around);
  const auto statistics = [&](Index error, double spread) {
    return ErrorSums{.n = n,
                     .total = squares[0],
                     .error = sums[error],
                     .absolute = sums[error + 1],
                     .squares = sums[error + 2],
                     .spread = spread}
        .statistics();
  };
  fit.population = statistics(2, squares[1]);
  fit.conditional = statistics(5, squares[2]);
  // As variance_shares().
  const double fixed = squares[3] / (n - 1.0);
  const double random = sums[9] / n;
  const double total = fixed + random + squares[4] / n;
  fit.r2_marginal = fixed / total;
  fit.r2_conditional = (fixed + random) / total;
}

/// The smallest and the largest value of each column that the mean uses.
std::vector<ColumnRange> shared_ranges(const SharedModel& shared,
                                       const std::vector<ColumnRange>& of_sample) {
  std::vector<double> own;
  for (const ColumnRange& range : of_sample) {
    const VectorXd values = shared.model.column(range.column);
    own.insert(own.end(), {values.minCoeff(), values.maxCoeff()});
  }
  std::vector<ColumnRange> result = of_sample;
  for (const std::vector<double>& ends : numbers_of_ranks(own)) {
    for (std::size_t k = 0; k < result.size(); ++k) {
      result[k].low = std::min(result[k].low, ends[2 * k]);
      result[k].high = std::max(result[k].high, ends[2 * k + 1]);
    }
  }
  return result;
}

class SharedFit {
 public:
  SharedFit(const ModelSpecification& specification,
            SharedData data,
            const FitModelOptions& options)
      : options_(options),
        method_(marginal_method(options.method.value_or(default_method(specification)))),
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
    MarginalSearch search(model(), method_, marginal, start.estimate, &clusters_);
    search.try_fit(start);
    if (!search.has_optimum()) return without_optimum();
    MixedEffectsFit found = search.result();
    if (search.has_converged()) search.compute_errors(found);
    return described(std::move(found), search.obstacle(), variance);
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
    const VectorXd parameters = variance.parameters(judged.variance);
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
    const EffectPosteriors described =
        describe_effects(model(), fit, clusters_.block_begin, clusters_.typical);
    const EffectUncertainty& own = described.terms.back().uncertainty;
    const Index groups = shared().group_count();
    return {.covariances = joined_columns(own.covariances.leftCols(groups)),
            .sensitivities = joined_columns(own.sensitivities.leftCols(groups))};
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
