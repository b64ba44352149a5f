// SPDX-License-Identifier: MIT
// The output of `silvafit grow`.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <string_view>
#include <utility>

#include "grow_command.hpp"
#include "silvafit/base/text.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

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
std::string beside_text(const study::WrittenScene& written) {
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
void print_files(const study::GrowResult& result, std::size_t trees) {
  const std::string stand = counted(trees, "tree", "trees");
  if (result.files.size() == 1) {
    const study::WrittenScene& only = result.files.front();
    print_text("{}, {} triangles, {:.2f} s: {}{}\n",
               stand,
               only.triangles,
               result.seconds,
               only.name,
               beside_text(only));
    return;
  }
  const std::string times = result.moments > 1 ? fmt::format(" at {} times", result.moments) : "";
  print_text("{}{}, {:.2f} s:\n", stand, times, result.seconds);
  constexpr std::size_t kShown = 40;
  for (std::size_t i = 0; i < std::min(kShown, result.files.size()); ++i) {
    const study::WrittenScene& one = result.files[i];
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

void report_grown(const CommonOptions& common, const study::GrowResult& result) {
  if (common.json) {
    print_json_value(study::json_of(result), -1);
    return;
  }
  const std::vector<tree::Morphology>& trees = result.morphologies;
  print_files(result, tree_count(trees));
  if (result.settings.share) {
    const tree::ShapeError worst = study::worst_of(result.shared);
    print_text("{}; largest errors: crown base {:.0f} cm, DBH {:.1f} cm, crown radius {:.0f} cm\n",
               counted(result.shared.models.size(), "model", "models"),
               worst.hcb_cm,
               worst.dbh_cm,
               worst.radius_cm);
  }
  if (result.settings.resolve_overlaps)
    print_text("{} overlapped\n",
               counted(result.pairs.size(), "pair of crowns", "pairs of crowns"));
  if (!result.crossing.empty()) {
    say(common,
        counted(tree_count(trees, result.crossing), "tree is", "trees are") +
            " too close to others to separate all branches; use --json to list them.");
  }
  if (!result.with_guesses.empty()) {
    say(common,
        counted(tree_count(trees, result.with_guesses), "tree has", "trees have") +
            " missing measurements, for which defaults are used; use --json to list them.");
  }
}

}  // namespace silvafit::cli
