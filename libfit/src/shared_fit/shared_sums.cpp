// SPDX-License-Identifier: MIT
#include "shared_fit/shared_sums.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "result/variance_shares.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/ranks.hpp"
#include "silvafit/data/row_sums.hpp"

namespace silvafit::fit {
namespace {

using Eigen::ArrayXd;

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

}  // namespace

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

}  // namespace silvafit::fit
