// SPDX-License-Identifier: MIT
#include "silvafit/study/scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/study/predict_responses.hpp"

namespace silvafit::study {
namespace {

constexpr std::size_t kNeighbors = 4;
constexpr double kMiddle = 0.5;
// Above the DBH of any known tree, so that a mistyped value does not affect the result.
constexpr double kThickestCentimeters = 2000.0;
/// In the order in which they occur in a scene's name.
constexpr std::array<const char*, 4> kIndices{"C", "M", "U", "W"};

/// The structural indices of a reference tree.
using Indices = std::array<double, 4>;

double& value_of(Indices& indices, const std::string& name) {
  return indices[static_cast<std::size_t>(std::ranges::find(kIndices, name) - kIndices.begin())];
}

/// The number of neighbors with the property of an index.
std::size_t count_of(double index) {
  return static_cast<std::size_t>(std::lround(index * static_cast<double>(kNeighbors)));
}

struct Size {
  double dbh_cm = 0.0;
  double h_m = 0.0;
  double hcb_m = 0.0;
  double cw_m = 0.0;
};

/// Sizes that a library predicts for given species, diameters and indices.
class Sizes {
 public:
  Sizes(const ModelLibrary& library, const SceneOptions& options)
      : library_(library), options_(options) {}

  void add(const std::string& species, double dbh_cm, const Indices& indices) {
    species_.append(species);
    dbh_cm_.push_back(dbh_cm);
    for (std::size_t i = 0; i < kIndices.size(); ++i) indices_[i].push_back(indices[i]);
  }

  std::vector<Size> predict() {
    data::Table table(dbh_cm_.size());
    table.set("species", species_);
    table.set("dbh", dbh_cm_);
    for (std::size_t i = 0; i < kIndices.size(); ++i) table.set(kIndices[i], indices_[i]);
    const PredictedResponses predicted =
        predict_responses(library_, table_with_group(table), how());
    std::vector<Size> sizes;
    for (std::size_t row = 0; row < dbh_cm_.size(); ++row) {
      sizes.push_back({.dbh_cm = dbh_cm_[row],
                       .h_m = value(predicted, "h", row),
                       .hcb_m = value(predicted, "hcb", row),
                       .cw_m = value(predicted, "cw", row)});
      check(sizes.back(), row);
    }
    return sizes;
  }

 private:
  PredictionSettings how() const {
    return {.level = options_.group.empty() ? fit::Level::kPopulation : fit::Level::kConditional,
            .new_groups = fit::NewGroups::kError,
            .role = options_.role};
  }

  /// The values of all group columns are the group of the options.
  data::Table table_with_group(data::Table table) const {
    if (options_.group.empty()) return table;
    for (const std::string& column : text_columns(library_)) {
      if (column == "species") continue;
      data::TextColumn labels;
      for (std::size_t row = 0; row < table.rows(); ++row) labels.append(options_.group);
      table.set(column, std::move(labels));
    }
    return table;
  }

  static double value(const PredictedResponses& predicted,
                      const std::string& response,
                      std::size_t row) {
    const auto found =
        std::ranges::find(predicted.responses, response, &PredictedResponse::response);
    if (found == predicted.responses.end()) {
      throw UsageError(
          fmt::format("the library has no model for {}; scenes need h, hcb and cw", response));
    }
    return found->value[row];
  }

  void check(const Size& size, std::size_t row) const {
    constexpr double kBreastHeight = 1.3;
    const bool is_tree =
        size.h_m > kBreastHeight && size.hcb_m >= 0.0 && size.hcb_m < size.h_m && size.cw_m > 0.0;
    if (is_tree) return;
    throw NumericalError(
        fmt::format("the prediction for a {} of {} cm with C = {}, M = {}, U = {}, W = {} is not a "
                    "possible tree: height {:.2f} m, crown base {:.2f} m, crown width {:.2f} m",
                    species_[row],
                    size.dbh_cm,
                    indices_[0][row],
                    indices_[1][row],
                    indices_[2][row],
                    indices_[3][row],
                    size.h_m,
                    size.hcb_m,
                    size.cw_m));
  }

  const ModelLibrary& library_;
  const SceneOptions& options_;
  data::TextColumn species_;
  std::vector<double> dbh_cm_;
  std::array<std::vector<double>, 4> indices_;
};

/// Azimuths of four neighbors for a value of W: the number of angles smaller than 72 degrees.
std::array<double, kNeighbors> azimuths_deg(double uniform_angle_index) {
  constexpr std::array<std::array<double, kNeighbors>, kNeighbors + 1> kAzimuths{
      {{45, 135, 225, 315},
       {45, 105, 205, 305},
       {45, 105, 225, 285},
       {45, 100, 155, 210},
       {45, 65, 85, 105}}};
  return kAzimuths[count_of(uniform_angle_index)];
}

/// The properties of a neighbor for the indices of its scene. The three properties start at
/// different neighbors, so that they do not always occur together.
struct Neighbor {
  bool overlaps = false;
  bool is_other_species = false;
  bool is_larger = false;
};

Neighbor neighbor(const Indices& indices, std::size_t number) {
  return {.overlaps = number < count_of(indices[0]),
          .is_other_species = (number + 1) % kNeighbors < count_of(indices[1]),
          .is_larger = (number + 2) % kNeighbors < count_of(indices[2])};
}

/// The rows of all scenes.
class SceneTable {
 public:
  void add(const std::string& scene,
           std::size_t tree,
           const std::string& species,
           double x_m,
           double y_m,
           const Size& size,
           const Indices& indices) {
    plot_.append(scene);
    tree_.append(std::to_string(tree));
    species_.append(species);
    const std::array<double, kColumns.size()> values{x_m,
                                                     y_m,
                                                     size.dbh_cm,
                                                     size.h_m,
                                                     size.hcb_m,
                                                     size.cw_m,
                                                     indices[3],
                                                     indices[1],
                                                     indices[2],
                                                     indices[0]};
    for (std::size_t i = 0; i < values.size(); ++i) columns_[i].push_back(values[i]);
  }

  data::Table table() const {
    data::Table result(columns_.front().size());
    result.set("plot", plot_);
    result.set("tree", tree_);
    result.set("species", species_);
    for (std::size_t i = 0; i < kColumns.size(); ++i) result.set(kColumns[i], columns_[i]);
    return result;
  }

 private:
  static constexpr std::array<const char*, 10> kColumns{
      "x", "y", "dbh", "h", "hcb", "cw", "W", "M", "U", "C"};
  data::TextColumn plot_;
  data::TextColumn tree_;
  data::TextColumn species_;
  std::array<std::vector<double>, kColumns.size()> columns_;
};

class SceneMaker {
 public:
  SceneMaker(const ModelLibrary& library, const SceneOptions& options)
      : library_(library), options_(options), all_species_(species_of_library()) {}

  Scenes make() {
    Scenes result;
    if (all_species_.empty()) {
      throw UsageError(fmt::format("the library has no models with the role {}", options_.role));
    }
    for (const auto& [species, dbh] : options_.dbh_cm) check_species(species);
    const std::vector<std::string>& chosen =
        options_.species.empty() ? all_species_ : options_.species;
    for (const std::string& species : chosen) result.species.push_back(add_species(species));
    result.trees = table_.table();
    return result;
  }

 private:
  bool counts(const LibraryModel& model) const {
    return model.role.empty() || model.role == options_.role;
  }

  std::vector<std::string> species_of_library() const {
    std::vector<std::string> species;
    for (const LibraryModel& model : library_.models) {
      if (!counts(model) || std::ranges::find(species, model.species) != species.end()) continue;
      species.push_back(model.species);
    }
    return species;
  }

  void check_species(const std::string& species) const {
    if (std::ranges::find(all_species_, species) != all_species_.end()) return;
    throw UsageError(
        fmt::format("the library has no models for {} with the role {}; available: {}",
                    species,
                    options_.role,
                    data::list_of(std::vector(all_species_.begin(), all_species_.end()))));
  }

  double dbh_of(const std::string& species) const {
    for (const auto& known : {options_.dbh_cm, library_.inventory.commonest_dbh_cm}) {
      const auto found = known.find(species);
      if (found == known.end()) continue;
      if (!(found->second > 0.0)) throw UsageError("the DBH of " + species + " must be positive");
      return found->second;
    }
    if (species.empty()) {
      throw UsageError(
          "the models of the library have no species; scenes need the library of a study, with "
          "models for h, hcb and cw of each species");
    }
    throw UsageError(fmt::format(
        "the library does not store the most frequent DBH of {0}; give one, such as {0}=20",
        species));
  }

  std::vector<std::string> indices_of(const std::string& species) const {
    std::vector<std::string> result;
    for (const std::string index : kIndices) {
      const bool is_used = std::ranges::any_of(library_.models, [&](const LibraryModel& model) {
        const std::vector<std::string> read = model.fit.specification.predictors();
        return model.species == species && counts(model) &&
               std::ranges::find(read, index) != read.end();
      });
      if (is_used) result.push_back(index);
    }
    return result;
  }

  /// All combinations of the classes of some indices, the last one running fastest.
  std::vector<Indices> combinations(const std::vector<std::string>& names) const {
    std::vector<Indices> result{{kMiddle, kMiddle, kMiddle, options_.uniform_angle_index}};
    for (const std::string& name : names) {
      std::vector<Indices> finer;
      for (Indices indices : result) {
        for (std::size_t k = 0; k <= kNeighbors; ++k) {
          value_of(indices, name) = static_cast<double>(k) / kNeighbors;
          finer.push_back(indices);
        }
      }
      result = std::move(finer);
    }
    return result;
  }

  static std::string name_of(const std::string& species,
                             const std::vector<std::string>& names,
                             Indices indices) {
    std::string name = species.empty() ? "all" : species;
    for (const std::string& index : names) {
      name += fmt::format("-{}{}", index, value_of(indices, index));
    }
    return name;
  }

  /// The species of neighbors of another species: the next one in the library.
  std::string other_than(const std::string& species) const {
    if (all_species_.size() < 2) return "other";
    const auto own = std::ranges::find(all_species_, species);
    return own + 1 == all_species_.end() ? all_species_.front() : *(own + 1);
  }

  /// Sizes of neighbors, by whether they are of another species and whether they are larger.
  std::array<std::array<Size, 2>, 2> neighbor_sizes(const std::string& species, double dbh_cm) {
    constexpr std::array<double, 2> kRelativeDbh{0.8, 1.25};
    const bool has_other = all_species_.size() > 1;
    Sizes sizes(library_, options_);
    for (const bool is_other : {false, true}) {
      for (const double relative : kRelativeDbh) {
        sizes.add(is_other && has_other ? other_than(species) : species,
                  relative * dbh_cm,
                  {kMiddle, kMiddle, kMiddle, kMiddle});
      }
    }
    const std::vector<Size> predicted = sizes.predict();
    return {{{predicted[0], predicted[1]}, {predicted[2], predicted[3]}}};
  }

  SpeciesScenes add_species(const std::string& species) {
    check_species(species);
    SpeciesScenes result{
        .species = species, .dbh_cm = dbh_of(species), .indices = indices_of(species)};
    const std::vector<Indices> combined = combinations(result.indices);
    result.scenes = combined.size();
    Sizes sizes(library_, options_);
    for (const Indices& indices : combined) sizes.add(species, result.dbh_cm, indices);
    const std::vector<Size> reference = sizes.predict();
    const auto neighbors = neighbor_sizes(species, result.dbh_cm);
    // Up to 25 scenes form a square of five in a row, more of them rows of 25.
    const std::size_t columns = combined.size() <= 25 ? 5 : 25;
    for (std::size_t i = 0; i < combined.size(); ++i) {
      const std::size_t row = i / columns;
      const double x_m = options_.spacing_m * static_cast<double>(i % columns);
      const double y_m = north_m_ + options_.spacing_m * static_cast<double>(row);
      const std::string scene = name_of(species, result.indices, combined[i]);
      table_.add(scene, 1, species, x_m, y_m, reference[i], combined[i]);
      for (std::size_t k = 0; k < kNeighbors; ++k) {
        add_neighbor(scene, species, k, x_m, y_m, reference[i], combined[i], neighbors);
      }
    }
    const std::size_t rows = (combined.size() - 1) / columns + 1;
    north_m_ += options_.spacing_m * static_cast<double>(rows);
    return result;
  }

  void add_neighbor(const std::string& scene,
                    const std::string& species,
                    std::size_t number,
                    double x_m,
                    double y_m,
                    const Size& reference,
                    const Indices& indices,
                    const std::array<std::array<Size, 2>, 2>& sizes) {
    const Neighbor is = neighbor(indices, number);
    const Size& size = sizes[is.is_other_species ? 1 : 0][is.is_larger ? 1 : 0];
    // Crowns touch at the sum of their radii; this margin is larger than rounding errors.
    constexpr double kOverlapping = 0.75;
    constexpr double kApart = 1.2;
    const double distance =
        (is.overlaps ? kOverlapping : kApart) * 0.5 * (reference.cw_m + size.cw_m);
    const double azimuth = azimuths_deg(indices[3])[number] * std::numbers::pi / 180.0;
    constexpr double kUnknown = data::kMissing;
    table_.add(scene,
               number + 2,
               is.is_other_species ? other_than(species) : species,
               x_m + distance * std::sin(azimuth),
               y_m + distance * std::cos(azimuth),
               size,
               {kUnknown, kUnknown, kUnknown, kUnknown});
  }

  const ModelLibrary& library_;
  const SceneOptions& options_;
  std::vector<std::string> all_species_;
  SceneTable table_;
  double north_m_ = 0.0;
};

void check_options(const SceneOptions& options) {
  const double quarters = options.uniform_angle_index * kNeighbors;
  if (!(quarters >= 0.0 && quarters <= kNeighbors) || quarters != std::round(quarters)) {
    throw UsageError("W must be 0, 0.25, 0.5, 0.75 or 1");
  }
  if (!(options.spacing_m > 0.0) || !std::isfinite(options.spacing_m)) {
    throw UsageError("the spacing of scenes must be positive");
  }
}

}  // namespace

Scenes scenes_of(const ModelLibrary& library, const SceneOptions& options) {
  check_options(options);
  return SceneMaker(library, options).make();
}

double commonest_dbh_cm(const std::vector<double>& diameters_cm) {
  std::vector<double> values;
  std::ranges::copy_if(
      diameters_cm, std::back_inserter(values), [](double value) { return !std::isnan(value); });
  if (values.empty()) throw UsageError("no diameter is known");
  const double low = std::ranges::min(values);
  std::erase_if(values, [](double value) { return value > kThickestCentimeters; });
  if (values.empty()) return low;
  const auto n = static_cast<double>(values.size());
  double mean = 0.0;
  for (const double value : values) mean += value / n;
  double square = 0.0;
  for (const double value : values) square += (value - mean) * (value - mean) / n;
  const double bandwidth = 1.06 * std::sqrt(square) * std::pow(n, -0.2);
  if (!(bandwidth > 0.0)) return low;
  // Diameters are measured to 0.1 cm: equal ones share a term.
  std::map<double, double> counts;
  for (const double value : values) ++counts[value];
  double best = low;
  double highest = 0.0;
  const auto last = static_cast<int>(std::lround(10.0 * std::ranges::max(values)));
  for (auto tenth = static_cast<int>(std::lround(10.0 * low)); tenth <= last; ++tenth) {
    double density = 0.0;
    for (const auto& [value, count] : counts) {
      const double distance = (0.1 * tenth - value) / bandwidth;
      density += count * std::exp(-0.5 * distance * distance);
    }
    if (density <= highest) continue;
    highest = density;
    best = tenth / 10.0;
  }
  return best;
}

}  // namespace silvafit::study
