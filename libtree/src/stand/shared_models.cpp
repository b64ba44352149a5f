// SPDX-License-Identifier: MIT
#include "silvafit/tree/shared_models.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <queue>
#include <utility>

#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

/// Measures of a shape; sizes as logarithms, so that the middle of a class is the geometric
/// middle.
enum Measure : std::size_t {
  kHeight,    ///< ln h
  kEastWest,  ///< ln of the crown's diameter
  kSouthNorth,
  kBase,    ///< hcb / h
  kWidest,  ///< (hc - hcb) / (h - hcb)
  kEast,    ///< relative diameter on the eastern side
  kSouth,
  kStem,  ///< ln of dbh by the mean crown diameter
  kMeasures,
};
using Shape = std::array<double, kMeasures>;

Shape shape_of(const TreeShape& tree) {
  const double east_west = tree.radii.east_m + tree.radii.west_m;
  const double south_north = tree.radii.south_m + tree.radii.north_m;
  Shape shape{};
  shape[kHeight] = std::log(tree.h_m);
  shape[kEastWest] = std::log(east_west);
  shape[kSouthNorth] = std::log(south_north);
  shape[kBase] = tree.hcb_m / tree.h_m;
  shape[kWidest] = (tree.hc_m - tree.hcb_m) / (tree.h_m - tree.hcb_m);
  shape[kEast] = tree.radii.east_m / east_west;
  shape[kSouth] = tree.radii.south_m / south_north;
  shape[kStem] = std::log(tree.dbh_cm / std::sqrt(east_west * south_north));
  return shape;
}

/// Error in centimeters of a tree of this size per unit of a measure; a stem has tenfold weight,
/// because it is measured to the millimeter, and scaling a tree by a tenth counts as 5 cm.
Shape weights_of(const TreeShape& tree) {
  constexpr double kPerMeter = 100.0;
  constexpr double kStretch = 50.0;
  Shape weights{};
  weights[kHeight] = weights[kEastWest] = weights[kSouthNorth] = kStretch;
  weights[kBase] = kPerMeter * tree.h_m;
  weights[kWidest] = kPerMeter * (tree.h_m - tree.hcb_m);
  weights[kEast] = kPerMeter * (tree.radii.east_m + tree.radii.west_m);
  weights[kSouth] = kPerMeter * (tree.radii.south_m + tree.radii.north_m);
  weights[kStem] = 10.0 * tree.dbh_cm;
  return weights;
}

struct ShapeClass {
  std::vector<std::size_t> trees{};
  std::size_t measure = 0;  ///< with the largest range
  double spread_cm = 0.0;
  Shape middle{};
};

class Divider {
 public:
  explicit Divider(const std::vector<TreeShape>& shapes) {
    for (const TreeShape& tree : shapes) {
      shapes_.push_back(shape_of(tree));
      weights_.push_back(weights_of(tree));
    }
  }

  std::vector<ShapeClass> divide(std::vector<std::size_t> trees, std::size_t wanted) const {
    const auto narrower = [](const ShapeClass& a, const ShapeClass& b) {
      return a.spread_cm < b.spread_cm;
    };
    std::vector<ShapeClass> classes{class_of(std::move(trees))};
    while (classes.size() < wanted) {
      std::pop_heap(classes.begin(), classes.end(), narrower);
      if (classes.back().spread_cm <= 0.0) break;
      auto [low, high] = halved(classes.back());
      classes.back() = std::move(low);
      std::push_heap(classes.begin(), classes.end(), narrower);
      classes.push_back(std::move(high));
      std::push_heap(classes.begin(), classes.end(), narrower);
    }
    return classes;
  }

 private:
  ShapeClass class_of(std::vector<std::size_t> trees) const {
    ShapeClass result{.trees = std::move(trees)};
    for (std::size_t m = 0; m < kMeasures; ++m) {
      double low = shapes_[result.trees.front()][m];
      double high = low;
      double weight = 0.0;
      for (const std::size_t i : result.trees) {
        low = std::min(low, shapes_[i][m]);
        high = std::max(high, shapes_[i][m]);
        weight = std::max(weight, weights_[i][m]);
      }
      result.middle[m] = 0.5 * (low + high);
      if ((high - low) * weight > result.spread_cm) {
        result.spread_cm = (high - low) * weight;
        result.measure = m;
      }
    }
    return result;
  }

  std::pair<ShapeClass, ShapeClass> halved(const ShapeClass& whole) const {
    std::vector<std::size_t> low;
    std::vector<std::size_t> high;
    const std::size_t m = whole.measure;
    for (const std::size_t i : whole.trees) {
      (shapes_[i][m] <= whole.middle[m] ? low : high).push_back(i);
    }
    return {class_of(std::move(low)), class_of(std::move(high))};
  }

  std::vector<Shape> shapes_{};
  std::vector<Shape> weights_{};
};

Morphology model_of(const Shape& middle, const std::string& name) {
  const double h = std::exp(middle[kHeight]);
  const double east_west = std::exp(middle[kEastWest]);
  const double south_north = std::exp(middle[kSouthNorth]);
  const double hcb = middle[kBase] * h;
  Morphology model{.plot = "model", .tree = name};
  model.h_m = h;
  model.hcb_m = hcb;
  model.hc_m = hcb + middle[kWidest] * (h - hcb);
  model.radii = CrownRadii{middle[kEast] * east_west,
                           (1.0 - middle[kEast]) * east_west,
                           middle[kSouth] * south_north,
                           (1.0 - middle[kSouth]) * south_north};
  model.dbh_cm = std::exp(middle[kStem]) * std::sqrt(east_west * south_north);
  return model;
}

SharedTree shared_tree(const TreeShape& tree, const SharedModel& model, std::size_t index) {
  const Morphology& like = model.morphology;
  const CrownRadii& own = tree.radii;
  const CrownRadii& theirs = *like.radii;
  SharedTree result{.model = index};
  result.stretch_up = tree.h_m / like.h_m;
  result.stretch_east = (own.east_m + own.west_m) / (theirs.east_m + theirs.west_m);
  result.stretch_north = (own.south_m + own.north_m) / (theirs.south_m + theirs.north_m);
  constexpr double kPerMeter = 100.0;
  ShapeError& error = result.error;
  error.hcb_cm = kPerMeter * std::abs(result.stretch_up * like.hcb_m - tree.hcb_m);
  error.hc_cm = kPerMeter * std::abs(result.stretch_up * *like.hc_m - tree.hc_m);
  error.radius_cm =
      kPerMeter * std::max(std::abs(result.stretch_east * theirs.east_m - own.east_m),
                           std::abs(result.stretch_north * theirs.south_m - own.south_m));
  return result;
}

}  // namespace

SharedModels share_models(std::span<const Morphology> trees,
                          std::span<const Builder* const> builders,
                          std::size_t per_preset) {
  if (trees.size() != builders.size()) throw UsageError("each tree needs a preset");
  if (per_preset == 0) throw UsageError("each preset needs at least one model");
  std::vector<TreeShape> shapes;
  shapes.reserve(trees.size());
  std::map<std::string, std::vector<std::size_t>> by_preset;
  for (std::size_t i = 0; i < trees.size(); ++i) {
    shapes.push_back(builders[i]->shape_of(trees[i]));
    shapes.back().notes = {};  // the notes of a million trees need much memory
    by_preset[builders[i]->name()].push_back(i);
  }
  const Divider divider(shapes);
  SharedModels result;
  result.trees.resize(trees.size());
  for (const auto& [name, members] : by_preset) {
    std::size_t number = 0;
    for (ShapeClass& one : divider.divide(members, per_preset)) {
      SharedModel model{.morphology = model_of(one.middle, fmt::format("{}-{}", name, ++number)),
                        .builder = builders[one.trees.front()],
                        .trees = std::move(one.trees)};
      for (const std::size_t i : model.trees) {
        result.trees[i] = shared_tree(shapes[i], model, result.models.size());
      }
      result.models.push_back(std::move(model));
    }
  }
  return result;
}

void measure_stems(std::size_t model,
                   const Mesh& mesh,
                   std::span<const Morphology> trees,
                   SharedModels& shared) {
  const std::vector<std::size_t>& members = shared.models[model].trees;
  std::vector<double> heights;
  heights.reserve(members.size());
  for (const std::size_t i : members) {
    heights.push_back(kBreastHeight / shared.trees[i].stretch_up);
  }
  const std::vector<double> diameters = stem_diameters_cm(mesh, heights);
  for (std::size_t k = 0; k < members.size(); ++k) {
    SharedTree& tree = shared.trees[members[k]];
    // Scaling multiplies the section's area by both factors.
    const double diameter = diameters[k] * std::sqrt(tree.stretch_east * tree.stretch_north);
    tree.error.dbh_cm = std::max(tree.error.dbh_cm, std::abs(diameter - trees[members[k]].dbh_cm));
  }
}

Mesh with_joined_wood(Mesh mesh) {
  const auto part_of = [&mesh](PartKind kind) {
    return std::ranges::find(mesh.parts, kind, &MeshPart::kind);
  };
  for (const PartKind kind : {PartKind::kBranches, PartKind::kAerialRoots}) {
    const auto stem = part_of(PartKind::kStem);
    const auto other = part_of(kind);
    if (stem == mesh.parts.end() || other == mesh.parts.end()) continue;
    const auto before = static_cast<std::uint32_t>(stem->vertex_count());
    const auto append = [&](auto values) {
      auto& whole = *stem.*values;
      const auto& added = *other.*values;
      whole.insert(whole.end(), added.begin(), added.end());
    };
    append(&MeshPart::positions);
    append(&MeshPart::normals);
    append(&MeshPart::colors);
    append(&MeshPart::uvs);
    append(&MeshPart::tangents);
    stem->indices.reserve(stem->indices.size() + other->indices.size());
    for (const std::uint32_t index : other->indices) stem->indices.push_back(before + index);
    mesh.parts.erase(other);
  }
  return mesh;
}

}  // namespace silvafit::tree
