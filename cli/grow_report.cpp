// SPDX-License-Identifier: MIT
// The output of `silvafit grow`.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <string_view>
#include <utility>

#include "grow_command.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/tree/coinciding_plots.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
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

ordered_json shared_trees(const GrowCommand& command,
                          const GrowResult& result,
                          const std::vector<tree::Morphology>& morphologies) {
  ordered_json trees = ordered_json::array();
  for (std::size_t i = 0; i < result.shared.trees.size(); ++i) {
    const tree::SharedTree& tree = result.shared.trees[i];
    trees.push_back({{"plot", morphologies[i].plot},
                     {"tree", morphologies[i].tree},
                     {"species", morphologies[i].species},
                     {"preset", result.builders[i]->name()},
                     {"file", scene_path(command, command.levels.front()).string()},
                     {"model", result.shared.models[tree.model].morphology.tree},
                     {"error_cm", json_of(tree.error)}});
  }
  return trees;
}

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

void print_json(const GrowCommand& command,
                const GrowResult& result,
                const std::vector<tree::Morphology>& morphologies,
                const std::vector<tree::LeftOut>& left_out,
                double seconds) {
  ordered_json json{{"schema", "silvafit-grow/1"},
                    {"silvafit", version()},
                    {"builder", tree::builder_name(command.builder)},
                    {"use", command.use},
                    {"seed", command.common.seed}};
  if (!command.by.empty()) json["by"] = command.by;
  ordered_json trees = ordered_json::array();
  if (command.share) {
    trees = shared_trees(command, result, morphologies);
    json["shared"] = {{"models", result.shared.models.size()},
                      {"worst_error_cm", json_of(worst_of(result.shared))}};
  } else {
    for (const GrownTree& tree : result.trees) trees.push_back(json_of(tree));
  }
  json["trees"] = std::move(trees);
  if (command.resolve_overlaps) {
    ordered_json pairs = ordered_json::array();
    for (const tree::PairOverlap& pair : result.pairs) pairs.push_back(json_of(pair, morphologies));
    json["overlaps"] = std::move(pairs);
  }
  ordered_json files = ordered_json::array();
  std::size_t triangles = 0;
  for (const Written& one : result.files) {
    files.push_back({{"file", one.name}, {"bytes", one.bytes}, {"triangles", one.triangles}});
    if (!one.beside.empty()) files.back()["beside"] = one.beside;
    triangles += one.triangles;
  }
  if (!command.scene.empty()) json["scenes"] = std::move(files);
  ordered_json rows = ordered_json::array();
  for (const tree::LeftOut& row : left_out) rows.push_back(json_of(row));
  json["left_out"] = std::move(rows);
  json["triangles"] = triangles;
  json["seconds"] = seconds;
  print_text("{}\n", json_text(json));
}

/// The number of trees, each counted once for all its measurements.
std::size_t tree_count(const std::vector<tree::Morphology>& morphologies,
                       const std::vector<std::size_t>& numbers) {
  std::set<std::pair<std::string_view, std::string_view>> names;
  for (const std::size_t i : numbers) names.emplace(morphologies[i].plot, morphologies[i].tree);
  return names.size();
}

std::size_t tree_count(const std::vector<tree::Morphology>& morphologies) {
  std::vector<std::size_t> all(morphologies.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return tree_count(morphologies, all);
}

/// Such as ", with trees.mtl, bark.png, leaf.png and 2 more in the same folder"; empty for a single
/// file.
std::string beside_text(const Written& written) {
  if (written.beside.empty()) return {};
  constexpr std::size_t kNamed = 3;
  const std::size_t named = std::min(kNamed, written.beside.size());
  std::vector<std::string> names;
  for (std::size_t i = 0; i < named; ++i) {
    names.push_back(std::filesystem::path(written.beside[i]).filename().string());
  }
  const std::size_t more = written.beside.size() - named;
  return fmt::format(", with {}{} in the same folder",
                     fmt::join(names, ", "),
                     more > 0 ? fmt::format(" and {} more", more) : "");
}

/// The written files: one file in one line, several files each in its own line.
void print_files(const GrowResult& result, std::size_t trees, std::size_t moments, double seconds) {
  const std::string stand = counted(trees, "tree", "trees");
  if (result.files.size() == 1) {
    const Written& only = result.files.front();
    print_text("{}, {} triangles, {:.2f} s: {}{}\n",
               stand,
               only.triangles,
               seconds,
               only.name,
               beside_text(only));
    return;
  }
  const std::string times = moments > 1 ? fmt::format(" at {} times", moments) : "";
  print_text("{}{}, {:.2f} s:\n", stand, times, seconds);
  constexpr std::size_t kShown = 40;
  for (std::size_t i = 0; i < std::min(kShown, result.files.size()); ++i) {
    const Written& one = result.files[i];
    print_text("  {}: {}, {} triangles{}\n",
               one.name,
               counted(one.trees, "tree", "trees"),
               one.triangles,
               beside_text(one));
  }
  if (result.files.size() > kShown) {
    print_text("  ... and {} more; use --json to list all\n", result.files.size() - kShown);
  }
}

}  // namespace

void report_grown(const GrowCommand& command,
                  const GrowResult& result,
                  const std::vector<tree::Morphology>& morphologies,
                  std::size_t moments,
                  const std::vector<tree::LeftOut>& left_out,
                  double seconds) {
  if (command.common.json) {
    print_json(command, result, morphologies, left_out, seconds);
    return;
  }
  print_files(result, tree_count(morphologies), moments, seconds);
  if (command.share) {
    const tree::ShapeError worst = worst_of(result.shared);
    print_text("{}; largest errors: crown base {:.0f} cm, DBH {:.1f} cm, crown radius {:.0f} cm\n",
               counted(result.shared.models.size(), "model", "models"),
               worst.hcb_cm,
               worst.dbh_cm,
               worst.radius_cm);
  }
  if (command.resolve_overlaps)
    print_text("{} overlapped\n",
               counted(result.pairs.size(), "pair of crowns", "pairs of crowns"));
  if (!result.crossing.empty()) {
    say(command.common,
        counted(tree_count(morphologies, result.crossing), "tree is", "trees are") +
            " too close to others to separate all branches; use --json to list them.");
  }
  if (!result.with_guesses.empty()) {
    say(command.common,
        counted(tree_count(morphologies, result.with_guesses), "tree has", "trees have") +
            " missing measurements, for which defaults are used; use --json to list them.");
  }
}

void report_left_out(const GrowCommand& command, const std::vector<tree::LeftOut>& left_out) {
  constexpr std::size_t kShown = 20;
  for (std::size_t i = 0; i < left_out.size() && i < kShown; ++i) {
    say(command.common, describe(left_out[i].place, left_out[i].reason + "; the row is skipped"));
  }
  if (left_out.size() > kShown) {
    say(command.common,
        fmt::format("... and {} skipped in {}",
                    counted(left_out.size() - kShown, "more row is", "more rows are"),
                    command.file));
  }
}

void report_coinciding_plots(const GrowCommand& command, const std::vector<tree::Moment>& moments) {
  if (command.scene.empty() && !command.resolve_overlaps) return;
  for (const tree::Moment& moment : moments) {
    const auto plots = tree::coinciding_plots(moment.trees);
    if (!plots) continue;
    say(command.common,
        fmt::format("note: plots {0} and {1} cover each other, probably because each has its own "
                    "coordinate system; grow one plot at a time (--plot {0}), or give x and y of "
                    "all plots in one system",
                    plots->first,
                    plots->second));
    return;
  }
}

}  // namespace silvafit::cli
