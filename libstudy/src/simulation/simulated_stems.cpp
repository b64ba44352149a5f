// SPDX-License-Identifier: MIT
#include "simulation/simulated_stems.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"

namespace silvafit::study {
namespace {

/// Points in square cells of the minimum distance, so that only nine cells are searched.
class Inhibition {
 public:
  explicit Inhibition(double distance)
      : distance_(distance), cell_(std::max(distance, kSmallestCell)) {}

  bool has_room(double x, double y) const {
    if (distance_ <= 0.0) return true;
    const auto [column, row] = cell(x, y);
    for (std::int64_t i = column - 1; i <= column + 1; ++i) {
      for (std::int64_t j = row - 1; j <= row + 1; ++j) {
        const auto found = cells_.find(key(i, j));
        if (found == cells_.end()) continue;
        for (const auto& [px, py] : found->second) {
          if (std::hypot(px - x, py - y) < distance_) return false;
        }
      }
    }
    return true;
  }

  void add(double x, double y) {
    if (distance_ <= 0.0) return;
    const auto [column, row] = cell(x, y);
    cells_[key(column, row)].emplace_back(x, y);
  }

 private:
  std::pair<std::int64_t, std::int64_t> cell(double x, double y) const {
    return {static_cast<std::int64_t>(std::floor(x / cell_)),
            static_cast<std::int64_t>(std::floor(y / cell_))};
  }
  static std::uint64_t key(std::int64_t column, std::int64_t row) {
    return (static_cast<std::uint64_t>(column) << 32U) ^
           (static_cast<std::uint64_t>(row) & 0xffffffffU);
  }

  /// Stems are placed to the centimeter.
  static constexpr double kSmallestCell = 0.01;

  double distance_;
  double cell_;
  std::unordered_map<std::uint64_t, std::vector<std::pair<double, double>>> cells_;
};

/// The probability that a species accepts a candidate position.
class Habitat {
 public:
  Habitat(double patchiness, double patch_length_m, Random& random)
      : patchiness_(patchiness), field_(patch_length_m, random) {}

  double acceptance(double x, double y) const {
    // Larger values, which are rare, are treated as this number of standard deviations.
    constexpr double kHighest = 2.5;
    if (patchiness_ == 0.0) return 1.0;
    return std::exp(patchiness_ * (std::min(field_(x, y), kHighest) - kHighest));
  }

 private:
  double patchiness_;
  SmoothField field_;
};

/// Draws plots with probabilities in proportion to their areas.
class PlotsByArea {
 public:
  explicit PlotsByArea(const std::vector<PlotDesign>& plots) {
    double sum = 0.0;
    for (const PlotDesign& plot : plots) ends_.push_back(sum += plot.area_m2());
  }
  double total_m2() const { return ends_.back(); }
  std::size_t draw(Random& random) const {
    const auto last = ends_.end() - 1;
    const double at = random.uniform(0.0, total_m2());
    return static_cast<std::size_t>(std::upper_bound(ends_.begin(), last, at) - ends_.begin());
  }

 private:
  std::vector<double> ends_{};  ///< sums of areas up to each plot [m2]
};

/// The species of all stems, in random order.
std::vector<std::size_t> shuffled_species(const SimulationDesign& design,
                                          double area_m2,
                                          Random& random) {
  constexpr double kSquareMetersPerHectare = 10000.0;
  const double hectares = area_m2 / kSquareMetersPerHectare;
  std::vector<std::size_t> result;
  for (std::size_t s = 0; s < design.species.size(); ++s) {
    const double count = std::round(design.species[s].density_per_ha * hectares);
    result.insert(result.end(), static_cast<std::size_t>(count), s);
  }
  for (std::size_t i = result.size(); i > 1; --i) std::swap(result[i - 1], result[random.below(i)]);
  return result;
}

/// A position in the plot, rounded to the centimeter without leaving the plot.
double place_between(double low, double high, Random& random) {
  return std::clamp(rounded(random.uniform(low, high), 100.0), low, high);
}

}  // namespace

double rounded(double value, double per_unit) { return std::round(value * per_unit) / per_unit; }

std::vector<Stem> place_stems(const SimulationDesign& design, std::uint64_t seed) {
  // Limits of attempts, for one stem and for all; a few seconds at most.
  constexpr int kAttempts = 20000;
  constexpr std::size_t kAttemptsOfAll = 10'000'000;
  constexpr std::size_t kAttemptsOfEach = 100;
  std::vector<Habitat> habitats;
  for (std::size_t s = 0; s < design.species.size(); ++s) {
    Random patches(seed, stream_of(Draw::kPatches, s));
    habitats.emplace_back(design.species[s].patchiness, design.stems.patch_length_m, patches);
  }
  Random random(seed, stream_of(Draw::kStems));
  const PlotsByArea plots(design.plots);
  Inhibition inhibition(design.stems.minimum_distance_m);
  std::vector<Stem> stems;
  const std::vector<std::size_t> species_of_stems =
      shuffled_species(design, plots.total_m2(), random);
  std::size_t left_of_all = kAttemptsOfAll + kAttemptsOfEach * species_of_stems.size();
  for (const std::size_t species : species_of_stems) {
    int attempts_left = kAttempts;
    for (; attempts_left > 0 && left_of_all > 0; --attempts_left, --left_of_all) {
      const std::size_t plot = plots.draw(random);
      const PlotDesign& rectangle = design.plots[plot];
      const double x = place_between(rectangle.x0, rectangle.x1, random);
      const double y = place_between(rectangle.y0, rectangle.y1, random);
      if (random.uniform() >= habitats[species].acceptance(x, y)) continue;
      if (!inhibition.has_room(x, y)) continue;
      inhibition.add(x, y);
      stems.push_back({.plot = plot, .species = species, .x = x, .y = y});
      break;
    }
    if (attempts_left == 0 || left_of_all == 0) {
      throw InputError(fmt::format("after {} of {} stems there is no room for another stem at {} m "
                                   "from all others, or hardly any; reduce the density, the "
                                   "distance or the patchiness",
                                   stems.size(),
                                   species_of_stems.size(),
                                   design.stems.minimum_distance_m),
                       {.column = "stems.minimum_distance"});
    }
  }
  std::stable_sort(
      stems.begin(), stems.end(), [](const Stem& a, const Stem& b) { return a.plot < b.plot; });
  return stems;
}

std::vector<double> draw_plot_factors(const SimulationDesign& design,
                                      std::size_t species,
                                      std::uint64_t seed) {
  Random random(seed, stream_of(Draw::kDbh, species, 1));
  const double sd = design.species[species].dbh.plot_log_sd;
  std::vector<double> factors;
  for (std::size_t plot = 0; plot < design.plots.size(); ++plot) {
    factors.push_back(std::exp(random.normal(-0.5 * sd * sd, sd)));
  }
  return factors;
}

std::vector<double> draw_dbh(const SimulationDesign& design,
                             const std::vector<Stem>& stems,
                             const std::vector<std::vector<double>>& plot_factors,
                             std::uint64_t seed) {
  std::vector<Random> randoms;
  for (std::size_t s = 0; s < design.species.size(); ++s) {
    randoms.emplace_back(seed, stream_of(Draw::kDbh, s));
  }
  std::vector<double> result;
  result.reserve(stems.size());
  for (const Stem& stem : stems) {
    const DbhDesign& dbh = design.species[stem.species].dbh;
    const double mean = dbh.mean_cm - dbh.minimum_cm;
    // Var(F G) = (1 + v)(s^2 + m^2) - m^2 for a factor F of mean 1 and variance v, and a gamma
    // variate G of mean m and variance s^2; s is chosen such that this is sd^2.
    const double v = std::expm1(dbh.plot_log_sd * dbh.plot_log_sd);
    const double variance = std::max(0.0, dbh.sd_cm * dbh.sd_cm - mean * mean * v) / (1.0 + v);
    const double shape = mean * mean / variance;
    const double gamma =
        std::isfinite(shape) ? randoms[stem.species].gamma(shape, variance / mean) : mean;
    const double above = plot_factors[stem.species][stem.plot] * gamma;
    result.push_back(rounded(dbh.minimum_cm + above, 10.0));
  }
  return result;
}

std::vector<double> draw_elevation(const SimulationDesign& design,
                                   const std::vector<Stem>& stems,
                                   std::uint64_t seed) {
  const TerrainDesign& terrain = design.terrain;
  Random random(seed, stream_of(Draw::kTerrain));
  const SmoothField hills(terrain.hill_length_m, random);
  std::vector<double> steps;
  for (std::size_t plot = 0; plot < design.plots.size(); ++plot) {
    steps.push_back(random.normal(0.0, terrain.plot_sd_m));
  }
  std::vector<double> result;
  result.reserve(stems.size());
  for (const Stem& stem : stems) {
    const double plane =
        terrain.base_m + terrain.slope_east * stem.x + terrain.slope_north * stem.y;
    const double z = plane + terrain.hill_sd_m * hills(stem.x, stem.y) + steps[stem.plot];
    result.push_back(rounded(z, 100.0));
  }
  return result;
}

SmoothField::SmoothField(double length_m, Random& random) {
  constexpr std::size_t kWaves = 64;
  waves_.resize(kWaves);
  for (Wave& wave : waves_) {
    wave.kx = random.normal(0.0, 1.0 / length_m);
    wave.ky = random.normal(0.0, 1.0 / length_m);
    wave.phase = random.uniform(0.0, 2.0 * std::numbers::pi);
  }
}

double SmoothField::operator()(double x, double y) const {
  double sum = 0.0;
  for (const Wave& wave : waves_) sum += std::cos(wave.kx * x + wave.ky * y + wave.phase);
  return std::sqrt(2.0 / static_cast<double>(waves_.size())) * sum;
}

}  // namespace silvafit::study
