// SPDX-License-Identifier: MIT
// The results of growing as JSON.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "workflow/grow_job.hpp"

namespace silvafit::study {
namespace {

using nlohmann::ordered_json;

ordered_json json_of(const tree::CrownRadii& radii) {
  return {{"e", radii.east_m}, {"w", radii.west_m}, {"s", radii.south_m}, {"n", radii.north_m}};
}

ordered_json json_of(const GrownTree& grown) {
  const tree::SceneTree& tree = grown.tree;
  const tree::Measurements& measured = tree.measured;
  ordered_json notes = ordered_json::array();
  for (const tree::Note& note : tree.notes) {
    notes.push_back({{"about", note.about}, {"text", note.text}});
  }
  ordered_json json{{"plot", tree.plot},
                    {"tree", tree.tree},
                    {"species", tree.species},
                    {"preset", tree.preset},
                    {"file", grown.file},
                    {"level", grown.level},
                    {"surface_error_cm", grown.surface_error_cm},
                    {"vertices", measured.vertices},
                    {"triangles", measured.triangles},
                    {"bytes", grown.bytes},
                    {"h", measured.h_m},
                    {"hcb", measured.hcb_m},
                    {"dbh", measured.dbh_cm},
                    {"cw", measured.radii.width_m()},
                    {"radii", json_of(measured.radii)}};
  if (!grown.moment.empty()) json["moment"] = grown.moment;
  if (tree.removed_share) json["removed_share"] = *tree.removed_share;
  json["notes"] = std::move(notes);
  return json;
}

ordered_json json_of(const tree::PairOverlap& pair,
                     const std::vector<tree::Morphology>& morphologies) {
  const auto name = [&](std::size_t i) {
    return ordered_json{{"plot", morphologies[i].plot}, {"tree", morphologies[i].tree}};
  };
  ordered_json meeting = nullptr;
  if (pair.meeting) {
    const bool is_low = pair.meeting->kind == tree::CrownMeeting::Kind::kUpUpAndDownDown;
    meeting = {{"h_up", pair.meeting->up_m},
               {"h_down", pair.meeting->down_m},
               {"kind", is_low ? "up/up and down/down" : "up/up and up/down"}};
  }
  return {{"weaker", name(pair.weaker)},
          {"stronger", name(pair.stronger)},
          {"distance", pair.distance_m},
          {"facing_radii", pair.facing_radii_m},
          {"ch", pair.competition.horizontal},
          {"cv", pair.competition.vertical},
          {"ct", pair.competition.total},
          {"meeting", std::move(meeting)},
          {"removed", {{"weaker", pair.removed_weaker}, {"stronger", pair.removed_stronger}}},
          {"surface", pair.log_share}};
}

ordered_json json_of(const tree::ShapeError& error) {
  return {{"hcb", error.hcb_cm},
          {"hc", error.hc_cm},
          {"dbh", error.dbh_cm},
          {"radius", error.radius_cm}};
}

ordered_json json_of(const tree::LeftOut& left_out) {
  const ordered_json line = left_out.place.line ? ordered_json(*left_out.place.line) : nullptr;
  return {{"plot", left_out.place.plot},
          {"tree", left_out.place.tree},
          {"line", line},
          {"column", left_out.place.column},
          {"reason", left_out.reason}};
}

ordered_json shared_trees(const GrowResult& result) {
  ordered_json trees = ordered_json::array();
  for (std::size_t i = 0; i < result.shared.trees.size(); ++i) {
    const tree::SharedTree& tree = result.shared.trees[i];
    trees.push_back({{"plot", result.morphologies[i].plot},
                     {"tree", result.morphologies[i].tree},
                     {"species", result.morphologies[i].species},
                     {"preset", result.presets[i]},
                     {"file", scene_path(result.settings, result.settings.levels.front()).string()},
                     {"model", result.shared.models[tree.model].morphology.tree},
                     {"error_cm", json_of(tree.error)}});
  }
  return trees;
}

}  // namespace

tree::ShapeError worst_of(const tree::SharedModels& shared) {
  tree::ShapeError worst;
  for (const tree::SharedTree& tree : shared.trees) {
    worst.hcb_cm = std::max(worst.hcb_cm, tree.error.hcb_cm);
    worst.hc_cm = std::max(worst.hc_cm, tree.error.hc_cm);
    worst.dbh_cm = std::max(worst.dbh_cm, tree.error.dbh_cm);
    worst.radius_cm = std::max(worst.radius_cm, tree.error.radius_cm);
  }
  return worst;
}

ordered_json json_of(const GrowResult& result) {
  const GrowSettings& settings = result.settings;
  ordered_json json{{"schema", "silvafit-grow/1"},
                    {"silvafit", SILVAFIT_VERSION},
                    {"builder", word_of(settings.builder)},
                    {"use", settings.use},
                    {"seed", settings.seed}};
  if (settings.is_unfitted) json["unfitted"] = true;
  if (!settings.by.empty()) json["by"] = settings.by;
  ordered_json trees = ordered_json::array();
  if (settings.share) {
    trees = shared_trees(result);
    json["shared"] = {{"models", result.shared.models.size()},
                      {"worst_error_cm", json_of(worst_of(result.shared))}};
  } else {
    for (const GrownTree& tree : result.trees) trees.push_back(json_of(tree));
  }
  json["trees"] = std::move(trees);
  if (settings.resolve_overlaps) {
    ordered_json pairs = ordered_json::array();
    for (const tree::PairOverlap& pair : result.pairs)
      pairs.push_back(json_of(pair, result.morphologies));
    json["overlaps"] = std::move(pairs);
  }
  ordered_json files = ordered_json::array();
  std::size_t triangles = 0;
  for (const WrittenScene& one : result.files) {
    files.push_back({{"file", one.name}, {"bytes", one.bytes}, {"triangles", one.triangles}});
    if (!one.beside.empty()) files.back()["beside"] = one.beside;
    triangles += one.triangles;
  }
  if (!settings.scene.empty() || settings.is_by_plot) json["scenes"] = std::move(files);
  ordered_json rows = ordered_json::array();
  for (const tree::LeftOut& row : result.left_out) rows.push_back(json_of(row));
  json["left_out"] = std::move(rows);
  json["triangles"] = triangles;
  json["seconds"] = result.seconds;
  return json;
}

}  // namespace silvafit::study
