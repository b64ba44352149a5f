// SPDX-License-Identifier: MIT
#include "model/correlated_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "silvafit/base/words.hpp"

namespace silvafit::fit {
namespace {

using Kind = Correlation::Kind;
using Block = CorrelatedRows::Block;

// A Cholesky factorization of more rows takes more than a gigabyte and a minute a step.
constexpr Index kLargestDense = 5000;
// A symmetric structure has T (T - 1) / 2 parameters.
constexpr std::size_t kMostTimes = 16;
// phi is the correlation at a difference of 1: if differences are shorter, even weak correlations
// make it smaller than any number; if they are longer, it rounds to 1.
constexpr double kShortestStep = 0.01;
constexpr double kLongestStep = 1e5;
// A moving average has a table of the correlations at all differences.
constexpr double kLongestTable = 1e5;

/// The structure within the groups of a column.
std::string first_word(Correlation example) {
  example.group = "plot";
  return example.text();
}

class Builder {
 public:
  Builder(const NonlinearModel& model, const Correlation& correlation)
      : model_(model),
        correlation_(correlation),
        places_(model.observations(), std::max<Index>(1, std::ssize(correlation.columns))) {
    for (Index k = 0; k < std::ssize(correlation.columns); ++k) {
      places_.col(k) = model.column(correlation.columns[static_cast<std::size_t>(k)]);
    }
  }

  void build() {
    for (Index group = 0; group < model_.group_count(); ++group) {
      first_block_.push_back(blocks_.size());
      add_blocks(group);
    }
    first_block_.push_back(blocks_.size());
  }

  /// The typical nearest and the farthest distance, and the size of the largest block.
  CorrelationScale scale() const {
    CorrelationScale result{.largest = 1};
    double sum = 0.0;
    double count = 0.0;
    for (const Block& block : blocks_) {
      const Index n = block.places.rows();
      result.largest = std::max(result.largest, n);
      const VectorXd extent = block.places.colwise().maxCoeff() - block.places.colwise().minCoeff();
      result.farthest = std::max(result.farthest, extent.norm());
      for (Index i = 1; i < n; ++i) {
        const Index from = block.places.cols() == 1 ? i - 1 : 0;
        const double nearest =
            (block.places.middleRows(from, i - from).rowwise() - block.places.row(i))
                .rowwise()
                .norm()
                .minCoeff();
        if (nearest > 0.0) sum += std::log(nearest);
        if (nearest > 0.0) ++count;
        if (std::fmod(nearest, 2.0) != 0.0) result.is_even = false;
      }
    }
    if (count > 0.0) result.unit = std::exp(sum / count);
    return result;
  }

  /// The distinct times, ascending.
  std::vector<double> times() const {
    std::vector<double> result;
    for (const Block& block : blocks_) {
      for (const double time : block.places.col(0)) {
        const auto at = std::ranges::lower_bound(result, time);
        if (at == result.end() || *at != time) result.insert(at, time);
      }
    }
    return result;
  }

  std::vector<Block> blocks_;
  std::vector<std::size_t> first_block_;

 private:
  void add_blocks(Index group) {
    // Without a grouping of its own all rows of the model's group are one block.
    std::map<Index, Block> own;
    const NonlinearModel::Strata* const strata =
        correlation_.group.empty() ? nullptr : &model_.strata(correlation_.group);
    for (Index i = model_.group_begin(group); i < model_.group_begin(group + 1); ++i) {
      const Index code = strata == nullptr ? 0 : strata->of_rows[static_cast<std::size_t>(i)];
      own[code].rows.push_back(i);
    }
    for (auto& [code, block] : own) {
      const std::string label = strata == nullptr
                                    ? model_.group_labels()[static_cast<std::size_t>(group)]
                                    : strata->labels[static_cast<std::size_t>(code)];
      finish(label, block);
      blocks_.push_back(std::move(block));
    }
  }

  void finish(const std::string& label, Block& block) {
    if (correlation_.columns.empty()) {
      block.places = VectorXd::LinSpaced(
          std::ssize(block.rows), 0.0, static_cast<double>(std::ssize(block.rows)) - 1.0);
      return;
    }
    for (const Index i : block.rows) require_place(label, i);
    if (correlation_.columns.size() == 1) {
      std::ranges::stable_sort(block.rows, {}, [this](Index i) { return places_(i, 0); });
    }
    block.places = places_(block.rows, Eigen::all);
    require_distinct(label, block);
  }

  /// "group M01" or "the data".
  static std::string named(const std::string& label) {
    return label.empty() ? "the data, which are one group" : "group " + label;
  }

  void require_place(const std::string& label, Index i) const {
    const Kind kind = correlation_.kind;
    const bool is_order = kind == Kind::kAr1 || kind == Kind::kArma;
    for (Index k = 0; k < places_.cols(); ++k) {
      const double value = places_(i, k);
      Place place = model_.place(i);
      place.column = correlation_.columns[static_cast<std::size_t>(k)];
      if (std::isnan(value)) {
        throw InputError(
            fmt::format("no value in a row of {}; `correlation` needs one in each row of the fit",
                        named(label)),
            place);
      }
      if (is_order && value != std::round(value)) {
        throw InputError(fmt::format("{} in {} is not an integer, which ar1 and arma need; use "
                                     "car1({})",
                                     value,
                                     named(label),
                                     place.column),
                         place);
      }
    }
  }

  std::string remedy_of_repetition(bool is_one_group) const {
    Correlation with_nugget = correlation_;
    with_nugget.has_nugget = true;
    const std::string nugget = correlation_.kind >= Kind::kExponential
                                   ? fmt::format("give a nugget, as in {}", with_nugget.text())
                                   : "";
    if (!is_one_group) return nugget.empty() ? "correct it, or give finer groups" : nugget;
    return fmt::format("{}{}give the column of the groups, as in {}",
                       nugget,
                       nugget.empty() ? "" : ", or ",
                       first_word(correlation_));
  }

  /// With a nugget two rows may be at one place.
  void require_distinct(const std::string& label, const Block& block) const {
    if (correlation_.has_nugget) return;
    std::vector<Index> order(block.rows.size());
    std::iota(order.begin(), order.end(), Index{0});
    const auto is_before = [&](Index a, Index b) {
      return std::lexicographical_compare(block.places.row(a).begin(),
                                          block.places.row(a).end(),
                                          block.places.row(b).begin(),
                                          block.places.row(b).end());
    };
    std::ranges::stable_sort(order, is_before);
    for (std::size_t k = 1; k < order.size(); ++k) {
      if (is_before(order[k - 1], order[k])) continue;
      const Place first = model_.place(block.rows[static_cast<std::size_t>(order[k - 1])]);
      Place second = model_.place(block.rows[static_cast<std::size_t>(order[k])]);
      const auto where = [](const Place& of) {
        return of.line ? fmt::format(" (line {} has it, too)", *of.line) : std::string();
      };
      second.column = fmt::format("{}", fmt::join(correlation_.columns, ", "));
      throw InputError(
          fmt::format(
              "{} is repeated in {}{}; `correlation` needs another value in each row of a group: "
              "{}",
              fmt::join(block.places.row(order[k]).begin(), block.places.row(order[k]).end(), ", "),
              named(label),
              where(first),
              remedy_of_repetition(label.empty())),
          second);
    }
  }

  const NonlinearModel& model_;
  const Correlation& correlation_;
  MatrixXd places_;  ///< (N x d)
};

/// \throws InputError if the unit of time is far from the differences of times
void require_near_unit(const Correlation& correlation, const CorrelationScale& scale) {
  if (correlation.kind > Kind::kArma || correlation.columns.empty()) return;
  const bool is_long = correlation.kind == Kind::kArma && scale.farthest > kLongestTable;
  if (scale.unit >= kShortestStep && scale.unit <= kLongestStep && !is_long) return;
  const std::string& time = correlation.columns.front();
  throw InputError(fmt::format(
      "{0}: times of successive rows differ by about {1:.2g}, and the parameters of {2} are for a "
      "difference of 1{3}; give the time in a unit near the differences, as in "
      "`columns=time={0}/{1:.2g}`",
      time,
      scale.unit,
      correlation.text(),
      is_long ? fmt::format(" (the largest difference is {:.2g})", scale.farthest) : "",
      scale.unit));
}

/// \throws InputError if a coordinate is a latitude in degrees: the other one, a longitude, has
///   shorter degrees. Columns of this name can have other units, in which rows are not so near.
void require_lengths(const NonlinearModel& model,
                     const Correlation& correlation,
                     const CorrelationScale& scale) {
  constexpr double kPole = 90.0;
  constexpr double kNearDegrees = 0.01;  // a kilometer
  if (correlation.kind < Kind::kExponential || correlation.columns.size() < 2) return;
  for (const std::string& column : correlation.columns) {
    const std::string name = in_lower_case(column);
    if (name != "lat" && name != "latitude") continue;
    if (scale.unit > kNearDegrees || model.column(column).cwiseAbs().maxCoeff() > kPole) continue;
    throw InputError(
        fmt::format("{} seems to be in degrees, of which {} makes no distances; give coordinates "
                    "in m, such as those of UTM",
                    column,
                    correlation.text()));
  }
}

void require_possible(const NonlinearModel& model,
                      const Correlation& correlation,
                      const CorrelationScale& scale,
                      std::size_t groups) {
  if (scale.largest < 2) {
    throw InputError(
        fmt::format("no group has two rows, so that {} cannot be estimated", correlation.text()));
  }
  const bool has_order = correlation.kind < Kind::kCompoundSymmetry;
  if (groups < 2 && !has_order && correlation.kind < Kind::kExponential) {
    throw InputError(fmt::format(
        "all rows are one group, in which the correlation of {} cannot be told from the mean; give "
        "the column of the groups as in {}",
        correlation.text(),
        first_word(correlation)));
  }
  require_lengths(model, correlation, scale);
  require_near_unit(correlation, scale);
  if (correlation.kind == Kind::kSymmetric && scale.times.size() > kMostTimes) {
    throw InputError(fmt::format(
        "{} has {} different times; at most {} can have correlations of their own. Use ar1, car1 "
        "or arma",
        correlation.text(),
        scale.times.size(),
        kMostTimes));
  }
  const bool is_markov = CorrelationStructure(correlation, scale).is_markov();
  if (is_markov || scale.largest <= kLargestDense) return;
  throw InputError(
      fmt::format("{} has a group of {} rows, for which the computation takes too long; at most {} "
                  "are possible. Give smaller groups as in {}, or use ar1 or car1",
                  correlation.text(),
                  scale.largest,
                  kLargestDense,
                  "exponential(x, y | plot)"));
}

/// The rows of a fit have correlations that can be used; those of a prediction may not.
/// \throws InputError with the first row of a group whose rows are too near each other
void require_regular(const NonlinearModel& model,
                     const CorrelationStructure& structure,
                     const std::vector<Block>& blocks,
                     const VectorXd& values) {
  const auto pairs = structure.at(structure.unconstrained(values));
  for (const Block& block : blocks) {
    if (structure.factor(block.places, *pairs) != nullptr) continue;
    Place place = model.place(block.rows.front());
    place.column = fmt::format("{}", fmt::join(structure.correlation().columns, ", "));
    throw InputError(
        fmt::format("some of the {} rows of the group are so near each other that their "
                    "residuals by {} depend on each other; give rows at one place once",
                    block.rows.size(),
                    structure.correlation().text()),
        place);
  }
}

}  // namespace

void require_known_time(const CorrelationStructure& structure, double time, Place place) {
  const Correlation& correlation = structure.correlation();
  if (correlation.kind != Kind::kSymmetric || structure.place(time) >= 0.0) return;
  if (!correlation.columns.empty()) place.column = correlation.columns.front();
  throw InputError(
      fmt::format("{} has no correlation for {}, which is none of the times of the fit "
                  "({}); leave such rows out, or fit ar1, car1 or arma",
                  correlation.text(),
                  time,
                  fmt::join(structure.scale().times, ", ")),
      place);
}

std::shared_ptr<const CorrelatedRows> CorrelatedRows::of(const NonlinearModel& model,
                                                         const CorrelationEstimate* known) {
  const auto& correlation = model.specification().correlation;
  if (!correlation) return nullptr;
  if (model.crossed() != nullptr) {
    throw UsageError(
        "`correlation` is not available with crossed groups or more than two levels; "
        "use one grouping or two nested ones");
  }
  Builder builder(model, *correlation);
  builder.build();
  CorrelationScale scale = builder.scale();
  if (correlation->kind == Kind::kSymmetric) scale.times = builder.times();
  if (known != nullptr) {
    scale.unit = known->unit;
    scale.largest = std::max(scale.largest, known->largest);
    scale.times = known->times;
  } else {
    require_possible(model, *correlation, scale, builder.blocks_.size());
  }
  CorrelationStructure structure(*correlation, scale);
  for (Block& block : builder.blocks_) {
    for (Index i = 0; i < block.places.rows(); ++i) {
      require_known_time(
          structure, block.places(i, 0), model.place(block.rows[static_cast<std::size_t>(i)]));
      for (double& place : block.places.row(i)) place = structure.place(place);
    }
  }
  if (known != nullptr && known->values.allFinite()) {
    require_regular(model, structure, builder.blocks_, known->values);
  }
  return std::shared_ptr<const CorrelatedRows>(new CorrelatedRows(
      std::move(structure), std::move(builder.blocks_), std::move(builder.first_block_)));
}

void whiten(const NonlinearModel& model,
            const VarianceEstimate& estimate,
            Eigen::Ref<MatrixXd> rows) {
  if (!estimate.correlation) return;
  const auto correlated = CorrelatedRows::of(model, &*estimate.correlation);
  const CorrelatedRows::Factors factors = correlated->factors(*estimate.correlation);
  correlated->change(
      factors, rows, [](const CorrelationFactor& factor, MatrixXd& part) { factor.whiten(part); });
}

CorrelatedRows::Factors CorrelatedRows::factors(const CorrelationEstimate& estimate) const {
  Factors result = factors(structure_.unconstrained(estimate.values), 1);
  if (!result.empty()) return result;
  throw NumericalError(
      fmt::format("the correlations of the rows by {} are not a positive definite matrix",
                  estimate.correlation.text()));
}

CorrelatedRows::Factors CorrelatedRows::factors(const VectorXd& parameters,
                                                unsigned threads) const {
  Factors result(blocks_.size());
  const std::unique_ptr<PairCorrelation> pairs = structure_.at(parameters);
  parallel_for(blocks_.size(), threads, [&](std::size_t k) {
    result[k] = structure_.factor(blocks_[k].places, *pairs);
  });
  const auto is_singular = [](const auto& factor) { return factor == nullptr; };
  if (std::ranges::any_of(result, is_singular)) return {};
  return result;
}

}  // namespace silvafit::fit
