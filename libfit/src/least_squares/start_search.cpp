// SPDX-License-Identifier: MIT
#include "least_squares/start_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "least_squares/levenberg_marquardt.hpp"
#include "least_squares/location_coefficients.hpp"
#include "least_squares/periodic_coefficients.hpp"
#include "optimization/candidate_points.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"

namespace silvafit::fit {
namespace {

constexpr Index kSampleRows = 200;
constexpr std::size_t kCandidatesPerCoefficient = 300;
constexpr std::size_t kDescents = 8;
/// Candidates within this factor in all coefficients count as the same place.
constexpr double kCandidateFactor = 2.5;
constexpr double kStartFactor = 1.001;

}  // namespace

std::vector<VectorXd> complete_starts(const NonlinearModel& model,
                                      const std::map<std::string, double>& values) {
  VectorXd start(model.coefficient_count());
  for (Index j = 0; j < start.size(); ++j) {
    const auto found = values.find(model.coefficient_names()[static_cast<std::size_t>(j)]);
    if (found == values.end()) return {};
    start[j] = found->second;
  }
  return {start};
}

std::vector<VectorXd> points_across_kinks(const NonlinearModel& model,
                                          const VectorXd& optimum,
                                          const VectorXd& errors) {
  constexpr int kQuarters = 12;
  std::vector<VectorXd> result;
  for (Index j = 0; j < optimum.size(); ++j) {
    if (!model.has_kink_in(j) || !std::isfinite(errors[j])) continue;
    for (int quarter = -kQuarters; quarter <= kQuarters; ++quarter) {
      if (quarter == 0) continue;
      result.push_back(optimum);
      result.back()[j] += 0.25 * quarter * errors[j];
    }
  }
  return result;
}

std::vector<Index> even_sample(const VectorXd& response, Index count) {
  std::vector<Index> chosen;
  if (response.size() <= count) {
    chosen.resize(static_cast<std::size_t>(response.size()));
    std::iota(chosen.begin(), chosen.end(), Index{0});
    return chosen;
  }
  // Of equal values the earlier observation comes first.
  std::vector<std::pair<double, Index>> all;
  all.reserve(static_cast<std::size_t>(response.size()));
  for (Index i = 0; i < response.size(); ++i) all.emplace_back(response[i], i);
  std::ranges::sort(all);
  for (Index k = 0; k < count; ++k) {
    chosen.push_back(all[static_cast<std::size_t>(k * (response.size() - 1) / (count - 1))].second);
  }
  std::ranges::sort(chosen);
  return chosen;
}

namespace {

struct Candidate {
  VectorXd nonlinear{};
  VectorXd coefficients{};
  double sum_of_squares = kInfinity;
};

class StartSearch {
 public:
  StartSearch(const NonlinearModel& model, const StartSearchOptions& options)
      : model_(model),
        options_(options),
        part_(model.subset(even_sample(model.response(), kSampleRows))),
        projected_(part_),
        periodic_(static_cast<std::size_t>(projected_.size())),
        locations_(static_cast<std::size_t>(projected_.size())) {
    const std::vector<Index>& nonlinear = projected_.split().nonlinear;
    if (nonlinear.empty()) return;
    for (const LocationCoefficient& found : location_coefficients(model)) {
      const auto place = std::ranges::find(nonlinear, found.coefficient);
      if (place == nonlinear.end()) continue;
      locations_[static_cast<std::size_t>(place - nonlinear.begin())] = found;
    }
    for (const PeriodicCoefficient& found : periodic_coefficients(model)) {
      const auto place = std::ranges::find(nonlinear, found.coefficient);
      const bool is_given = options.fixed.contains(
          model.coefficient_names()[static_cast<std::size_t>(found.coefficient)]);
      if (place != nonlinear.end() && !is_given) {
        periodic_[static_cast<std::size_t>(place - nonlinear.begin())] = found;
      }
    }
  }

  std::vector<VectorXd> run() {
    scan();
    std::vector<Candidate> starts = best_of(candidates_, effort(kDescents), kCandidateFactor);
    if (rule_) starts.push_back(*rule_);
    std::vector<Candidate> reached;
    reached.reserve(starts.size());
    for (const Candidate& start : starts) reached.push_back(descended(start));
    hop(reached);
    std::size_t count = options_.count;
    for (Candidate& found : frequency_minima()) {
      reached.push_back(std::move(found));
      ++count;
    }
    leave_out_aliases(reached);
    std::vector<VectorXd> result;
    for (const Candidate& candidate : best_of(std::move(reached), count, kStartFactor)) {
      result.push_back(candidate.coefficients);
    }
    return result;
  }

 private:
  std::size_t effort(std::size_t usual) const { return usual / options_.divisor; }

  bool are_near(double a, double b, std::size_t k, double factor) const {
    if (factor == kCandidateFactor) {
      if (periodic_[k]) return periodic_[k]->are_near(a, b);
      constexpr double kShare = 0.25;  // of the range of the observations
      if (locations_[k]) {
        return std::abs(a - b) < kShare * (locations_[k]->highest - locations_[k]->lowest);
      }
    }
    const double ratio = a / b;
    return ratio <= factor && ratio >= 1.0 / factor;
  }

  /// True if each nonlinear coefficient has the same sign and a size within a factor, or belongs to
  /// the same peak.
  bool are_near(const Candidate& a, const Candidate& b, double factor) const {
    if (are_different_waves(a, b)) return false;
    for (Index k = 0; k < a.nonlinear.size(); ++k) {
      if (!are_near(a.nonlinear[k], b.nonlinear[k], static_cast<std::size_t>(k), factor)) {
        return false;
      }
    }
    return true;
  }

  /// With a given phase, frequencies of opposite signs belong to different waves. If they belong to
  /// the same one, it has the same sum of squares.
  bool are_different_waves(const Candidate& a, const Candidate& b) const {
    constexpr double kSameWave = 1e-9;
    if (a.nonlinear.size() != 1 || !periodic_[0] || a.nonlinear[0] * b.nonlinear[0] > 0.0) {
      return false;
    }
    return std::abs(a.sum_of_squares - b.sum_of_squares) > kSameWave * b.sum_of_squares;
  }

  /// The best candidates, no two of them near each other.
  std::vector<Candidate> best_of(std::vector<Candidate> candidates,
                                 std::size_t count,
                                 double factor) const {
    std::ranges::stable_sort(candidates, {}, &Candidate::sum_of_squares);
    std::vector<Candidate> chosen;
    for (Candidate& candidate : candidates) {
      if (chosen.size() == count) break;
      const bool is_new = std::ranges::none_of(
          chosen, [&](const Candidate& other) { return are_near(candidate, other, factor); });
      if (is_new) chosen.push_back(std::move(candidate));
    }
    return chosen;
  }

  void scan() {
    const Index q = projected_.size();
    if (!options_.rule.empty() && try_candidate(rule_values())) rule_ = candidates_.back();
    if (q == 0) {
      try_candidate(VectorXd(0));
      return;
    }
    const CandidatePoints points(model_, q);
    for (const double scale : points.scales()) try_candidate(VectorXd::Constant(q, scale));
    if (q == 1) {
      scan_line();
    } else {
      const std::size_t count = effort(kCandidatesPerCoefficient) * static_cast<std::size_t>(q);
      for (std::size_t i = 1; i <= count; ++i) try_candidate(placed(points(i), i));
    }
    scan_frequencies(points);
  }

  /// Every second point gets the locations of observations.
  VectorXd placed(VectorXd point, std::size_t number) const {
    if (number % 2 == 0) return point;
    constexpr std::uint64_t kSeed = 4;
    Random random(kSeed, number);
    for (Index k = 0; k < point.size(); ++k) {
      if (locations_[static_cast<std::size_t>(k)]) point[k] = somewhere_on(k, random);
    }
    return point;
  }

  /// A location within the range of the observations, or a little beyond.
  double somewhere_on(Index k, Random& random) const {
    constexpr double kBeyond = 0.1;
    const LocationCoefficient& location = *locations_[static_cast<std::size_t>(k)];
    const double margin = kBeyond * (location.highest - location.lowest);
    return random.uniform(location.lowest - margin, location.highest + margin);
  }

  /// The identifiable frequencies of both signs, which differ if the phase is given, each with two
  /// values of the other coefficients.
  void scan_frequencies(const CandidatePoints& points) {
    const Index q = projected_.size();
    const std::vector<double>& scales = points.scales();
    for (Index k = 0; k < q; ++k) {
      const auto& periodic = periodic_[static_cast<std::size_t>(k)];
      for (std::size_t number = 1; periodic && number <= periodic->count; ++number) {
        const double at = periodic->value(static_cast<double>(number));
        for (const double value : {at, -at}) {
          VectorXd point = VectorXd::Constant(q, scales[number % scales.size()]);
          point[k] = value;
          try_candidate(point);
          if (q == 1) continue;
          point = points(number);
          point[k] = value;
          try_candidate(std::move(point));
        }
      }
    }
  }

  /// With few distinct observations, a frequency with a given phase may have many minima of nearly
  /// the same height, which are half as far apart as peaks are wide. If it is the only nonlinear
  /// coefficient, all minima along a fine grid are nearly as cheap as one.
  std::vector<Candidate> frequency_minima() {
    constexpr int kPointsPerStep = 4;
    constexpr std::size_t kMostSteps = 100;
    constexpr double kNearlyAsLow = 1.01;
    if (projected_.size() != 1 || !periodic_[0] || periodic_[0]->count > kMostSteps) return {};
    const int most = kPointsPerStep * static_cast<int>(periodic_[0]->count);
    std::vector<Candidate> line;
    for (int point = -most; point <= most; ++point) {
      if (point == 0) continue;
      const double number = static_cast<double>(point) / kPointsPerStep;
      const VectorXd value = VectorXd::Constant(1, periodic_[0]->value(number));
      if (!projected_.evaluate(value)) return {};
      line.push_back({.nonlinear = value, .sum_of_squares = projected_.residuals().squaredNorm()});
    }
    std::vector<Candidate> result;
    for (std::size_t i = 1; i + 1 < line.size(); ++i) {
      const double here = line[i].sum_of_squares;
      const bool is_lowest =
          here <= line[i - 1].sum_of_squares && here < line[i + 1].sum_of_squares;
      if (is_lowest) result.push_back(descended(line[i]));
    }
    const auto lowest = std::ranges::min_element(result, {}, &Candidate::sum_of_squares);
    if (lowest == result.end()) return {};
    const double limit = kNearlyAsLow * lowest->sum_of_squares;
    std::erase_if(result, [&](const Candidate& found) { return found.sum_of_squares > limit; });
    return result;
  }

  /// Removes frequencies that are aliases of lower ones, to which descents may have led.
  void leave_out_aliases(std::vector<Candidate>& reached) const {
    const auto is_alias = [&](const Candidate& found) { return !is_distinct(found.nonlinear); };
    if (!std::ranges::all_of(reached, is_alias)) std::erase_if(reached, is_alias);
  }

  /// Whether no frequency is an alias of a lower one.
  bool is_distinct(const VectorXd& nonlinear) const {
    for (Index k = 0; k < nonlinear.size(); ++k) {
      const auto& periodic = periodic_[static_cast<std::size_t>(k)];
      if (periodic && !periodic->contains(nonlinear[k])) return false;
    }
    return true;
  }

  /// One coefficient: a grid of both signs, four points per decade; of a location also one over the
  /// range of the observations.
  void scan_line() {
    constexpr int kLocations = 60;
    for (int step = 0; locations_[0] && step <= kLocations; ++step) {
      const double share = static_cast<double>(step) / kLocations;
      try_candidate(
          VectorXd::Constant(1, std::lerp(locations_[0]->lowest, locations_[0]->highest, share)));
    }
    for (int step = -40; step <= 40; ++step) {
      const double magnitude = std::pow(10.0, step / 4.0);
      try_candidate(VectorXd::Constant(1, magnitude));
      try_candidate(VectorXd::Constant(1, -magnitude));
    }
  }

  /// With many nonlinear coefficients, such as those of sums of peaks, or with kinks, points spread
  /// over all of them miss most minima. Some coefficients of the lowest point change at random, and
  /// the descent begins again. Source: basin hopping, Wales and Doye 1997, J. Phys. Chem. A 101,
  /// 5111-5116, at temperature zero.
  void hop(std::vector<Candidate>& reached) {
    constexpr Index kFew = 2;
    constexpr std::size_t kHopsPerCoefficient = 15;
    const Index q = projected_.size();
    if (q == 0 || reached.empty()) return;
    const int usual = q > kFew || !model_.fixed_kinks().empty()
                          ? static_cast<int>(effort(kHopsPerCoefficient)) * static_cast<int>(q)
                          : 0;
    Candidate lowest = *std::ranges::min_element(reached, {}, &Candidate::sum_of_squares);
    const int hops = usual + options_.further_hops;
    const std::vector<Candidate> others =
        best_of(candidates_, kDescents + static_cast<std::size_t>(hops), kCandidateFactor);
    for (int k = 0; k < hops; ++k) {
      constexpr std::uint64_t kSeed = 1;
      Random random(kSeed, static_cast<std::uint64_t>(k));
      const std::size_t next = kDescents + static_cast<std::size_t>(k / 2);
      // If the lowest point diverges to infinity, no change of it leads back.
      Candidate start = k % 2 == 1 && next < others.size()
                            ? others[next]
                            : Candidate{.nonlinear = moved(lowest.nonlinear, random)};
      if (!is_distinct(start.nonlinear) || !projected_.evaluate(start.nonlinear)) continue;
      Candidate found = descended(start);
      if (found.coefficients.size() == 0) continue;
      if (found.sum_of_squares < lowest.sum_of_squares) lowest = found;
      reached.push_back(std::move(found));
    }
  }

  /// A point with one to three coefficients multiplied by a random factor, or drawn from the range
  /// of a column.
  VectorXd moved(VectorXd point, Random& random) const {
    const auto count = 1 + random.below(3);
    const MatrixXd& columns = part_.variable_values();
    for (std::uint64_t k = 0; k < count; ++k) {
      const auto place = static_cast<Index>(random.below(static_cast<std::uint64_t>(point.size())));
      double& value = point[place];
      if (locations_[static_cast<std::size_t>(place)]) {
        value = somewhere_on(place, random);
        continue;
      }
      if (random.uniform() < 0.5 || columns.cols() < 2) {
        value *= std::exp(random.normal()) * (random.uniform() < 0.2 ? -1.0 : 1.0);
        continue;
      }
      // The first column is the response.
      const auto column =
          static_cast<Index>(1 + random.below(static_cast<std::uint64_t>(columns.cols() - 1)));
      value = random.uniform(columns.col(column).minCoeff(), columns.col(column).maxCoeff());
    }
    return point;
  }

  VectorXd rule_values() const {
    VectorXd point = VectorXd::Ones(projected_.size());
    set_named(options_.rule, point);
    return point;
  }

  void set_named(const std::map<std::string, double>& values, VectorXd& point) const {
    for (Index k = 0; k < point.size(); ++k) {
      const Index coefficient = projected_.split().nonlinear[static_cast<std::size_t>(k)];
      const auto found =
          values.find(part_.coefficient_names()[static_cast<std::size_t>(coefficient)]);
      if (found != values.end()) point[k] = found->second;
    }
  }

  bool try_candidate(VectorXd nonlinear) {
    set_named(options_.fixed, nonlinear);
    if (!is_distinct(nonlinear) || !projected_.evaluate(nonlinear)) return false;
    candidates_.push_back({.nonlinear = std::move(nonlinear),
                           .coefficients = projected_.coefficients(),
                           .sum_of_squares = projected_.residuals().squaredNorm()});
    return true;
  }

  Candidate descended(const Candidate& start) {
    const Descent descent =
        descend(projected_, start.nonlinear, {.maximum_iterations = 50, .tolerance = 1e-9});
    return {.nonlinear = projected_.nonlinear_part(descent.coefficients),
            .coefficients = descent.coefficients,
            .sum_of_squares = descent.sum_of_squares};
  }

  const NonlinearModel& model_;
  const StartSearchOptions& options_;
  NonlinearModel part_;
  ProjectedModel projected_;
  std::vector<std::optional<PeriodicCoefficient>> periodic_;   ///< by nonlinear coefficient
  std::vector<std::optional<LocationCoefficient>> locations_;  ///< the same
  std::vector<Candidate> candidates_;
  std::optional<Candidate> rule_;
};

}  // namespace

std::vector<VectorXd> search_starts(const NonlinearModel& model,
                                    const StartSearchOptions& options) {
  return StartSearch(model, options).run();
}

void check_domain(const NonlinearModel& model) {
  constexpr std::size_t kPoints = 64;
  const CandidatePoints points(model, model.coefficient_count());
  std::vector<bool> never_finite(static_cast<std::size_t>(model.observations()), true);
  for (std::size_t number = 1; number <= kPoints; ++number) {
    const auto [mean, jacobian] = model.curve_at(points(number));
    for (Index i = 0; i < mean.size(); ++i) {
      if (std::isfinite(mean[i]) && jacobian.row(i).allFinite()) {
        never_finite[static_cast<std::size_t>(i)] = false;
      }
    }
  }
  const auto found = std::ranges::find(never_finite, true);
  if (found == never_finite.end()) return;
  const Index row = found - never_finite.begin();
  const Place place = model.place(row);
  throw DomainError(
      fmt::format("the formula is not finite, or has no finite derivative, for {} and any "
                  "coefficients; correct or exclude the row",
                  place.line ? "this row"
                             : fmt::format("row {} of the table",
                                           model.rows()[static_cast<std::size_t>(row)] + 1)),
      place);
}

}  // namespace silvafit::fit
