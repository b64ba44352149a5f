// SPDX-License-Identifier: MIT
#include "silvafit/study/view_data.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/tree/mesh.hpp"
#include "silvafit/tree/packed_glb.hpp"
#include "view/view_models.hpp"
#include "view/view_stand.hpp"

namespace silvafit::study {
namespace {

View summary_of(ViewStand stand) {
  View view{.trees = stand.trees.size()};
  for (const ViewVariant& variant : stand.variants) view.variants.push_back(variant.name);
  view.left_out = std::move(stand.left_out);
  view.notes = std::move(stand.notes);
  return view;
}

/// A model is grown for the sizes of every variant, at the origin.
struct Versions {
  std::vector<tree::Morphology> trees{};
  std::vector<const tree::Builder*> presets{};
};

Versions versions_of(const ViewStand& stand) {
  Versions versions;
  for (const ViewVariant& variant : stand.variants) {
    for (std::size_t i = 0; i < variant.trees.size(); ++i) {
      const auto& shape = variant.trees[i].shape;
      if (!shape) continue;
      const ViewTree& tree = stand.trees[i];
      versions.trees.push_back({.plot = tree.plot,
                                .tree = tree.tree,
                                .species = tree.species,
                                .dbh_cm = shape->dbh_cm,
                                .h_m = shape->h_m,
                                .hcb_m = shape->hcb_m,
                                .hc_m = shape->hc_m,
                                .radii = shape->radii,
                                .age_years = shape->age_years});
      versions.presets.push_back(tree.preset);
    }
  }
  return versions;
}

tree::Position origin_of(const std::vector<tree::Position>& stems) {
  // A rounded origin keeps the positions readable; floats need an origin near the trees.
  constexpr double kRound = 10.0;
  tree::Position low = stems.front();
  tree::Position high = stems.front();
  for (const tree::Position& stem : stems) {
    low = {std::min(low.x_m, stem.x_m), std::min(low.y_m, stem.y_m), std::min(low.z_m, stem.z_m)};
    high = {std::max(high.x_m, stem.x_m), std::max(high.y_m, stem.y_m), high.z_m};
  }
  const auto rounded = [](double value) { return kRound * std::round(value / kRound); };
  return {rounded(0.5 * (low.x_m + high.x_m)),
          rounded(0.5 * (low.y_m + high.y_m)),
          kRound * std::floor(low.z_m / kRound)};
}

void check(const ViewOptions& options) {
  if (options.levels.empty()) throw UsageError("a view needs at least one level of detail");
  if (options.models_per_preset == 0) throw UsageError("each preset needs at least one model");
  for (const int level : options.levels) static_cast<void>(tree::level_of_detail(level));
}

}  // namespace

View view_of_trees(const data::Table& table,
                   const tree::BuilderCatalogue& catalogue,
                   const ViewOptions& options) {
  check(options);
  ViewStand stand = read_view_stand(table, catalogue, options);
  std::vector<tree::Position> stems;
  for (const ViewTree& tree : stand.trees) stems.push_back(tree.position);
  const tree::Position origin = origin_of(stems);
  const Versions versions = versions_of(stand);
  const ViewModels models =
      grow_view_models(versions.trees, versions.presets, stems, origin, options);
  std::string data = view_json(stand, {.origin = origin, .models = &models}, options);
  View view = summary_of(std::move(stand));
  view.data = std::move(data);
  view.models = models.shared.models.size();
  return view;
}

View view_of_scene(std::string_view glb,
                   const data::Table* table,
                   const tree::BuilderCatalogue& catalogue,
                   const ViewOptions& options) {
  if (!options.mark.empty()) {
    throw UsageError("a thinning is shown of a table of trees, not of a GLB scene",
                     {.column = "`mark`"});
  }
  SceneTrees scene = trees_of_scene(glb, table, catalogue, options);
  std::string data =
      view_json(scene.stand, {.origin = scene.origin, .scene = tree::packed_glb(glb)}, options);
  View view = summary_of(std::move(scene.stand));
  view.data = std::move(data);
  view.unmeasured = scene.unmeasured;
  return view;
}

}  // namespace silvafit::study
