// SPDX-License-Identifier: MIT
#include "silvafit/stand/structural_units.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <numbers>
#include <span>

#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "silvafit/data/table.hpp"
#include "units/density_indices.hpp"
#include "units/edge.hpp"
#include "units/neighbor_search.hpp"
#include "units/unit_indices.hpp"
#include "units/unit_option_checks.hpp"
#include "windows/overlapping_plots.hpp"

namespace silvafit::stand {
namespace {

constexpr std::size_t kTreesPerTask = 1024;
constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

/// A label as an integer, if it is one.
bool is_integer(std::string_view label, long long& value) {
  const auto [end, status] = std::from_chars(label.data(), label.data() + label.size(), value);
  return status == std::errc() && end == label.data() + label.size();
}

/// Compares integers by value and other labels by their characters; integers are first. Returns a
/// negative value, zero or a positive value.
int compare_labels(std::string_view left, std::string_view right) {
  long long left_value = 0;
  long long right_value = 0;
  const bool left_is_integer = is_integer(left, left_value);
  const bool right_is_integer = is_integer(right, right_value);
  if (left_is_integer != right_is_integer) return left_is_integer ? -1 : 1;
  if (left_is_integer && left_value != right_value) return left_value < right_value ? -1 : 1;
  return left.compare(right);
}

bool contains(const std::vector<FurtherIndex>& list, FurtherIndex index) {
  return std::ranges::find(list, index) != list.end();
}

/// Fills the units of all trees.
class Calculator {
 public:
  Calculator(const Inventory& inventory, const StructuralUnitOptions& options);
  StructuralUnits run();

 private:
  void find_windows();
  void note_overlapping_plots();
  void set_limit_angles();
  void allocate();
  std::vector<Point> positions() const;
  std::vector<std::vector<std::uint32_t>> groups() const;
  std::optional<Torus> torus_of(std::uint32_t tree) const;
  NeighborSearch search_among(std::vector<std::uint32_t> trees,
                              const std::vector<Point>& positions) const;
  void compute_small_groups(std::vector<std::vector<std::uint32_t>> groups,
                            const std::vector<Point>& positions);
  void compute_large_groups(std::vector<std::vector<std::uint32_t>> groups,
                            const std::vector<Point>& positions);
  bool has_competition_radius() const {
    return hegyi_ != nullptr && options_.competition_radius_m > 0.0;
  }
  bool is_alone(std::size_t tree, std::span<const Neighbor> neighbors) const {
    return neighbors.empty() || !is_at_same_place(inventory_, tree, neighbors[0].distance_m);
  }
  double competitor_count(const NeighborSearch& search, double most) const;
  void refuse_wide_radius(const std::vector<std::optional<NeighborSearch>>& searches) const;
  void compute_trees(const NeighborSearch& search, std::size_t begin, std::size_t end);
  void compute_tree(std::size_t tree, std::span<const Neighbor> neighbors);
  void compute_all();
  std::vector<SampledArea> areas();
  void note_assumed_areas(const PlotWindows& assumed);
  void compute_density();
  std::vector<double>* further(FurtherIndex index);
  bool needs_area() const;
  bool is_placed(std::size_t tree) const {
    return !std::isnan(inventory_.x[tree]) && !std::isnan(inventory_.y[tree]);
  }
  void find_cut_competitors();
  void count_trees();

  const Inventory& inventory_;
  const StructuralUnitOptions& options_;
  PlotWindows windows_{};
  std::vector<char> inside_{};
  std::vector<double> limit_angle_rad_{};  ///< by code of species, the last for missing species
  StructuralUnits units_{};
  std::vector<double>* overlap_ = nullptr;
  std::vector<double>* differentiation_ = nullptr;
  std::vector<double>* hegyi_ = nullptr;
};

Calculator::Calculator(const Inventory& inventory, const StructuralUnitOptions& options)
    : inventory_(inventory), options_(options) {
  units_.neighbors = options.neighbors;
  units_.scope = options.scope;
  units_.edge = options.edge;
  if (options.edge == EdgeCorrection::kBuffer) units_.buffer_m = options.buffer_m;
  units_.alpha0_deg =
      options.alpha0_deg.value_or(360.0 / static_cast<double>(options.neighbors + 1));
}

bool Calculator::needs_area() const {
  return contains(options_.further, FurtherIndex::kBasalAreaLarger) ||
         contains(options_.further, FurtherIndex::kCrownCompetition);
}

void Calculator::find_windows() {
  const bool is_open = options_.windows.empty() && !options_.sampled;
  if (is_open && options_.edge == EdgeCorrection::kNone) {
    // Every tree is a core tree, for any area.
    for (std::size_t i = 0; i < inventory_.size(); ++i) inside_.push_back(is_placed(i) ? 1 : 0);
    windows_.domain_of_plot.resize(inventory_.plot.levels().size());
    return;
  }
  const bool is_torus = options_.edge == EdgeCorrection::kTorus;
  windows_ = plot_windows(inventory_,
                          options_.windows,
                          options_.scope,
                          is_torus ? AssumedWindow::kRectangle : AssumedWindow::kConvexHull,
                          options_.sampled.has_value());
  UnitFindings& findings = units_.findings;
  findings.on_windows = windows_.notes;
  findings.plots_without_window = PlotNames(windows_.plots_without_window);
  findings.plots_in_window_of_stand = windows_.plots_in_window_of_stand;
  inside_ = trees_inside(inventory_, windows_, options_.threads);
}

void Calculator::note_overlapping_plots() {
  if (options_.scope != SearchScope::kStand) return;
  std::string note = note_on_overlapping_plots(inventory_, windows_);
  if (!note.empty()) units_.findings.on_windows.push_back(std::move(note));
}

void Calculator::set_limit_angles() {
  limit_angle_rad_.assign(inventory_.species.levels().size() + 1,
                          units_.alpha0_deg * kRadiansPerDegree);
  for (const auto& [species, degrees] : options_.alpha0_deg_of_species) {
    const std::uint32_t code = inventory_.species.code_of(species);
    // Not in this part of the inventory.
    if (code == data::TextColumn::kMissingCode) continue;
    limit_angle_rad_[code] = degrees * kRadiansPerDegree;
  }
}

std::vector<double>* Calculator::further(FurtherIndex index) {
  const auto found = std::ranges::find(units_.further, index, &FurtherValues::index);
  return found == units_.further.end() ? nullptr : &found->values;
}

void Calculator::allocate() {
  const std::size_t trees = inventory_.size();
  units_.W.assign(trees, data::kMissing);
  units_.M.assign(trees, data::kMissing);
  units_.U.assign(trees, data::kMissing);
  if (!inventory_.cw_m.empty()) units_.C.assign(trees, data::kMissing);
  units_.nearest.assign(trees * options_.neighbors, kNoTree);
  units_.distance_m.assign(trees * options_.neighbors, data::kMissing);
  for (const FurtherIndex index : all_values<FurtherIndex>()) {
    if (!contains(options_.further, index)) continue;
    units_.further.push_back(
        {.index = index, .values = std::vector<double>(trees, data::kMissing)});
  }
  overlap_ = inventory_.cw_m.empty() ? nullptr : further(FurtherIndex::kCrownOverlap);
  differentiation_ = further(FurtherIndex::kDifferentiation);
  hegyi_ = further(FurtherIndex::kHegyi);
}

std::vector<Point> Calculator::positions() const {
  std::vector<Point> positions;
  positions.reserve(inventory_.size());
  for (std::size_t i = 0; i < inventory_.size(); ++i) {
    positions.push_back({inventory_.x[i], inventory_.y[i]});
  }
  return positions;
}

/// The trees that may be neighbors of each other: those of a plot, or all.
std::vector<std::vector<std::uint32_t>> Calculator::groups() const {
  const bool by_plot = options_.scope == SearchScope::kPlot;
  const bool is_torus = options_.edge == EdgeCorrection::kTorus;
  std::vector<std::vector<std::uint32_t>> groups(by_plot ? inventory_.plot.levels().size() : 1);
  if (!by_plot) groups[0].reserve(inventory_.size());
  for (std::size_t i = 0; i < inventory_.size(); ++i) {
    if (is_torus ? inside_[i] == 0 : !is_placed(i)) continue;
    groups[by_plot ? inventory_.plot.code(i) : 0].push_back(static_cast<std::uint32_t>(i));
  }
  std::erase_if(groups, [](const auto& group) { return group.empty(); });
  return groups;
}

/// The torus that a group's trees stand on, if any.
std::optional<Torus> Calculator::torus_of(std::uint32_t tree) const {
  if (options_.edge != EdgeCorrection::kTorus) return std::nullopt;
  if (options_.scope == SearchScope::kStand && windows_.domains.size() > 1) {
    throw UsageError(
        "`edge=torus` needs one window for the stand; for windows of plots use `per=plot`",
        {.column = "`edge`"});
  }
  const Window& window = *windows_.window_of(inventory_, tree);
  if (!window.is_rectangle()) {
    throw UsageError("`edge=torus` needs a rectangular window with sides parallel to x and y",
                     {.column = "`edge`"});
  }
  const double shorter_m =
      std::min(window.high().x - window.low().x, window.high().y - window.low().y);
  if (hegyi_ != nullptr && options_.competition_radius_m > shorter_m / 2.0) {
    throw UsageError(fmt::format("{} m is more than half of the shorter side of the torus, {} m",
                                 options_.competition_radius_m,
                                 shorter_m),
                     {.column = "`competition_radius`"});
  }
  return Torus{.low = window.low(), .high = window.high()};
}

NeighborSearch Calculator::search_among(std::vector<std::uint32_t> trees,
                                        const std::vector<Point>& positions) const {
  const auto smaller_id = [this](std::uint32_t left, std::uint32_t right) {
    const int by_tree = compare_labels(inventory_.tree[left], inventory_.tree[right]);
    if (by_tree != 0) return by_tree < 0;
    const int by_plot = compare_labels(inventory_.plot[left], inventory_.plot[right]);
    return by_plot != 0 ? by_plot < 0 : left < right;
  };
  const std::optional<Torus> torus = torus_of(trees.front());
  return NeighborSearch(std::move(trees), positions, smaller_id, torus);
}

void Calculator::compute_tree(std::size_t tree, std::span<const Neighbor> neighbors) {
  const std::size_t first = tree * options_.neighbors;
  for (std::size_t i = 0; i < neighbors.size(); ++i) {
    units_.nearest[first + i] = neighbors[i].tree;
    units_.distance_m[first + i] = neighbors[i].distance_m;
  }
  if (neighbors.size() < options_.neighbors) return;
  const UnitIndices unit(inventory_, options_, tree);
  const bool has_species = !inventory_.species.is_missing(tree);
  const double limit =
      has_species ? limit_angle_rad_[inventory_.species.code(tree)] : limit_angle_rad_.back();
  units_.W[tree] = unit.uniform_angle(neighbors, limit);
  units_.M[tree] = unit.mingling(neighbors);
  units_.U[tree] = unit.dominance(neighbors);
  if (!units_.C.empty()) units_.C[tree] = unit.crowding(neighbors);
  if (overlap_ != nullptr) (*overlap_)[tree] = unit.crown_overlap(neighbors);
  if (differentiation_ != nullptr) (*differentiation_)[tree] = unit.differentiation(neighbors);
  if (hegyi_ != nullptr && options_.competition_radius_m == 0.0) {
    (*hegyi_)[tree] = unit.hegyi(neighbors);
  }
}

void Calculator::compute_trees(const NeighborSearch& search, std::size_t begin, std::size_t end) {
  std::vector<Neighbor> neighbors;
  NeighborSearch::Scratch scratch;
  for (std::size_t i = begin; i < end; ++i) {
    const std::size_t tree = search.trees()[i];
    search.nearest(i, options_.neighbors, neighbors, scratch);
    compute_tree(tree, neighbors);
    // A stem at the same position makes the index missing; there may be very many such stems.
    if (!has_competition_radius() || !is_alone(tree, neighbors)) continue;
    search.within(i, options_.competition_radius_m, neighbors);
    (*hegyi_)[tree] = UnitIndices(inventory_, options_, tree).hegyi(neighbors);
  }
}

/// About how many competitors all trees of a search have, from some of them.
/// \param most  a larger number need not be exact
double Calculator::competitor_count(const NeighborSearch& search, double most) const {
  constexpr std::size_t kSample = 16;
  const std::size_t trees = search.trees().size();
  const double each = static_cast<double>(trees) / static_cast<double>(kSample);
  double sum = 0.0;
  std::vector<Neighbor> neighbors;
  NeighborSearch::Scratch scratch;
  for (std::size_t k = 0; k < kSample && sum <= most; ++k) {
    const std::size_t i = (2 * k + 1) * trees / (2 * kSample);
    search.nearest(i, 1, neighbors, scratch);
    if (!is_alone(search.trees()[i], neighbors)) continue;
    search.within(i, options_.competition_radius_m, neighbors);
    sum += each * static_cast<double>(neighbors.size());
  }
  return sum;
}

/// The time of Hegyi's index grows with the number of pairs of competitors.
void Calculator::refuse_wide_radius(
    const std::vector<std::optional<NeighborSearch>>& searches) const {
  constexpr double kMostPairs = 1e9;  // some minutes
  double pairs = 0.0;
  for (const auto& search : searches) {
    pairs += competitor_count(*search, kMostPairs - pairs);
    if (pairs <= kMostPairs) continue;
    throw UsageError(
        fmt::format("{} m gives more than {:.0g} pairs of competitors, which would take minutes to "
                    "hours; competitors are usually searched within 10 m",
                    options_.competition_radius_m,
                    kMostPairs),
        {.column = "`competition_radius`"});
  }
}

/// Each search is destroyed with its group: a million of them would need gigabytes.
void Calculator::compute_small_groups(std::vector<std::vector<std::uint32_t>> groups,
                                      const std::vector<Point>& positions) {
  // Runs of groups with about as many trees as one task of a large group.
  std::vector<std::size_t> begins{0};
  std::size_t trees = 0;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    trees += groups[i].size();
    if (trees < kTreesPerTask && i + 1 < groups.size()) continue;
    begins.push_back(i + 1);
    trees = 0;
  }
  parallel_for(begins.size() - 1, options_.threads, [&](std::size_t task) {
    for (std::size_t i = begins[task]; i < begins[task + 1]; ++i) {
      const NeighborSearch search = search_among(std::move(groups[i]), positions);
      compute_trees(search, 0, search.trees().size());
    }
  });
}

/// All are searched first, so that threads share one large group among few.
void Calculator::compute_large_groups(std::vector<std::vector<std::uint32_t>> groups,
                                      const std::vector<Point>& positions) {
  std::vector<std::optional<NeighborSearch>> searches(groups.size());
  parallel_for(groups.size(), options_.threads, [&](std::size_t i) {
    searches[i].emplace(search_among(std::move(groups[i]), positions));
  });
  if (has_competition_radius()) refuse_wide_radius(searches);
  struct Task {
    const NeighborSearch* search;
    std::size_t begin;
    std::size_t end;
  };
  std::vector<Task> tasks;
  for (const auto& search : searches) {
    const std::size_t trees = search->trees().size();
    for (std::size_t begin = 0; begin < trees; begin += kTreesPerTask) {
      tasks.push_back({&*search, begin, std::min(trees, begin + kTreesPerTask)});
    }
  }
  parallel_for(tasks.size(), options_.threads, [&](std::size_t i) {
    compute_trees(*tasks[i].search, tasks[i].begin, tasks[i].end);
  });
}

void Calculator::compute_all() {
  const std::vector<Point> all_positions = positions();
  std::vector<std::vector<std::uint32_t>> small = groups();
  const auto first_large = std::stable_partition(
      small.begin(), small.end(), [](const auto& group) { return group.size() <= kTreesPerTask; });
  std::vector<std::vector<std::uint32_t>> large(std::make_move_iterator(first_large),
                                                std::make_move_iterator(small.end()));
  small.erase(first_large, small.end());
  compute_small_groups(std::move(small), all_positions);
  compute_large_groups(std::move(large), all_positions);
}

/// The areas used by BAL and CCF.
std::vector<SampledArea> Calculator::areas() {
  if (options_.sampled) return *options_.sampled;
  const bool is_given = !options_.windows.empty();
  if (options_.plot_area_m2 && !is_given) {
    return sampled_areas(inventory_, *options_.plot_area_m2);
  }
  if (is_given) return sampled_areas(inventory_, windows_, {});
  const PlotWindows assumed = options_.edge == EdgeCorrection::kNone
                                  ? plot_windows(inventory_, {}, options_.scope)
                                  : windows_;
  note_assumed_areas(assumed);
  return sampled_areas(inventory_, assumed, {});
}

void Calculator::note_assumed_areas(const PlotWindows& assumed) {
  const bool is_torus = options_.edge == EdgeCorrection::kTorus;
  const bool is_per_plot = options_.scope == SearchScope::kPlot;
  UnitFindings& findings = units_.findings;
  std::vector<std::string> names;
  for (const FurtherIndex index :
       {FurtherIndex::kBasalAreaLarger, FurtherIndex::kCrownCompetition}) {
    if (contains(options_.further, index)) names.push_back(word_of(index));
  }
  const std::string indices =
      fmt::format("{} {}", fmt::join(names, " and "), names.size() == 1 ? "is" : "are");
  findings.plots_without_density = PlotNames(assumed.plots_without_window);
  if (assumed.domains.empty() && !is_per_plot) {
    findings.on_windows.push_back(
        fmt::format("trees on one line have no area, so {} missing", indices));
    return;
  }
  findings.on_windows.push_back(
      fmt::format("{} too large: the area is that of the {} {}, which is smaller than the {}; its "
                  "own area needs a window",
                  indices,
                  is_torus ? "rectangle around" : "convex hull of",
                  is_per_plot ? "the trees of each plot" : "all trees",
                  is_per_plot ? "plot" : "stand"));
}

void Calculator::compute_density() {
  if (!needs_area()) return;
  const std::vector<SampledArea> counted_areas = areas();
  if (auto* larger = further(FurtherIndex::kBasalAreaLarger)) {
    *larger = basal_area_of_larger(inventory_, counted_areas);
  }
  if (auto* competition = further(FurtherIndex::kCrownCompetition)) {
    *competition = crown_competition(inventory_, counted_areas, options_.open_grown_crown);
  }
}

void Calculator::find_cut_competitors() {
  if (hegyi_ == nullptr || options_.competition_radius_m == 0.0) return;
  if (options_.edge == EdgeCorrection::kTorus || windows_.domains.empty()) return;
  for (std::size_t tree = 0; tree < inventory_.size(); ++tree) {
    if (units_.core[tree] == 0) continue;
    const Window& window = *windows_.window_of(inventory_, tree);
    const double room_m = window.distance_to_boundary_m({inventory_.x[tree], inventory_.y[tree]});
    const bool is_cut = room_m < options_.competition_radius_m - window.rounding_m();
    if (is_cut) ++units_.findings.with_cut_competitors;
  }
}

void Calculator::count_trees() {
  UnitFindings& findings = units_.findings;
  for (std::size_t tree = 0; tree < inventory_.size(); ++tree) {
    const std::size_t first = tree * options_.neighbors;
    if (!is_placed(tree)) {
      ++findings.without_position;
    } else if (units_.nearest[first + options_.neighbors - 1] == kNoTree) {
      ++findings.with_few_neighbors;
    } else {
      const bool is_coincident = is_at_same_place(inventory_, tree, units_.distance_m[first]);
      if (is_coincident) ++findings.with_neighbor_at_place;
      if (!units_.C.empty() && std::isnan(units_.C[tree])) ++findings.without_crown_width;
    }
  }
  findings.has_no_crown_widths = units_.C.empty();
}

StructuralUnits Calculator::run() {
  find_windows();
  note_overlapping_plots();
  set_limit_angles();
  allocate();
  compute_density();
  compute_all();
  correct_edge(inventory_, windows_, inside_, options_, units_);
  for (std::size_t i = 0; i < inventory_.size(); ++i) {
    if (inventory_.is_neighbor_only(i)) units_.core[i] = 0;
  }
  find_cut_competitors();
  count_trees();
  if (!options_.is_part) {
    units_.notes = notes_of(units_.findings, options_, inventory_.file);
  }
  units_.windows = std::move(windows_);
  return std::move(units_);
}

}  // namespace

StructuralUnits structural_units(const Inventory& inventory, const StructuralUnitOptions& options) {
  check_unit_options(inventory, options);
  return Calculator(inventory, options).run();
}

}  // namespace silvafit::stand
