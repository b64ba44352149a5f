// SPDX-License-Identifier: MIT
#include "silvafit/tree/lsystem_builder.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <numbers>
#include <optional>

#include "catalogue/preset_head.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/tree/turtle.hpp"

namespace silvafit::tree {
namespace {

using Constants = std::map<std::string, double>;

/// The list `by_height` gives some constants other values for taller trees.
std::vector<LsystemPreset::Stage> stages_of(const data::JsonReader& entry,
                                            const std::filesystem::path& grammars) {
  const auto name = entry.at("grammar").text();
  const std::filesystem::path file = grammars / (name + ".lsys");
  const auto common = entry.at("constants").numbers_by_name();
  const auto grammar = [&](const data::JsonReader& own, Constants constants) {
    constants.insert(common.begin(), common.end());
    try {
      return Grammar::load(file, constants);
    } catch (const UsageError& error) {
      own.fail(error.message());
    }
  };
  if (!entry.has("by_height")) return {{0.0, grammar(entry.at("constants"), {})}};
  std::vector<LsystemPreset::Stage> stages;
  for (const data::JsonReader& stage : entry.at("by_height").items()) {
    stage.allow_only({"from_m", "constants"});
    constexpr double kTallest = 200.0;
    const double lowest = stages.empty() ? 0.0 : stages.back().from_m;
    const double from_m =
        stage.at("from_m").number_between(lowest, stages.empty() ? 0.0 : kTallest);
    stages.push_back(
        {from_m, grammar(stage.at("constants"), stage.at("constants").numbers_by_name())});
  }
  if (stages.empty()) entry.at("by_height").fail("is empty");
  return stages;
}

AerialRoots aerial_roots_of(const data::JsonReader& entry) {
  AerialRoots roots;
  read_numbers(entry,
               {{"spacing_m", &roots.spacing_m, 0.1, 100.0},
                {"props", &roots.props, 0.0, 1.0},
                {"diameter_m", &roots.diameter_m, 0.005, 1.0}});
  return roots;
}

/// The same drawing with another azimuth.
void turn_about_stem(Skeleton& skeleton, double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  const auto turn = [c, s](Point& p) { p = {c * p.x - s * p.y, s * p.x + c * p.y, p.z}; };
  for (SkeletonPoint& point : skeleton.points) turn(point.at);
  for (LeafSite& leaf : skeleton.leaves) {
    turn(leaf.at);
    turn(leaf.along);
    turn(leaf.facing);
  }
}

}  // namespace

/// The drawing of a grammar without random numbers, used for every tree.
// Not std::call_once: some implementations block the next thread after an exception.
struct LsystemBuilder::Derived {
  std::mutex deriving{};
  std::optional<Skeleton> skeleton{};
};

std::unique_ptr<LsystemBuilder> LsystemBuilder::load(const std::filesystem::path& models,
                                                     const std::filesystem::path& file) {
  const data::JsonReader entry = open_entry(file, "silvafit-lsystem/1");
  LsystemPreset preset;
  read_head(models, entry, {"grammar", "constants", "by_height", "aerial_roots", "bud"}, preset);
  preset.stages = stages_of(entry, models / "grammars");
  if (entry.has("aerial_roots")) {
    preset.style.aerial_roots = aerial_roots_of(entry.at("aerial_roots"));
  }
  for (const data::JsonReader& look : entry.at("leaves").items()) {
    preset.style.leaves.push_back(leaf_look_of(look));
  }
  if (entry.has("bud")) {
    const int last = static_cast<int>(preset.style.leaves.size()) - 1;
    preset.bud_grade = static_cast<std::uint32_t>(whole_number(entry.at("bud"), 0, last));
  }
  if (!preset.style.leaves.empty()) preset.leaf = preset.style.leaves.front().color;
  return std::make_unique<LsystemBuilder>(std::move(preset));
}

LsystemBuilder::LsystemBuilder(LsystemPreset preset)
    : FreeBuilder(BuilderKind::kLsystem), preset_(std::move(preset)) {
  for (std::size_t i = 0; i < preset_.stages.size(); ++i) {
    derived_.push_back(std::make_unique<Derived>());
  }
}

LsystemBuilder::~LsystemBuilder() = default;

std::unique_ptr<LsystemBuilder> LsystemBuilder::with_grammar(const Grammar& grammar) const {
  LsystemPreset changed = preset_;
  changed.stages = {{0.0, grammar}};
  if (changed.style.shoots) changed.style.shoots->reach = 0.0;  // along the user's branches only
  return std::make_unique<LsystemBuilder>(std::move(changed));
}

Skeleton LsystemBuilder::derive(const Grammar& grammar, Random& random) const {
  Skeleton skeleton = skeleton_of(draw(grammar.derive(random), grammar.turtle(), grammar.file()),
                                  grammar.file(),
                                  preset_.bud_grade);
  const std::size_t looks = preset_.style.leaves.size();
  if (looks == 0) {
    skeleton.leaves.clear();
    return skeleton;
  }
  // A grammar may use more grades than the preset has leaf types.
  for (LeafSite& leaf : skeleton.leaves) {
    leaf.grade = std::min(leaf.grade, static_cast<std::uint32_t>(looks - 1));
  }
  return skeleton;
}

std::size_t LsystemBuilder::stage_of(double h_m) const {
  const auto above = std::upper_bound(
      preset_.stages.begin(),
      preset_.stages.end(),
      h_m,
      [](double h, const LsystemPreset::Stage& stage) { return h < stage.from_m; });
  return static_cast<std::size_t>(std::max<std::ptrdiff_t>(above - preset_.stages.begin() - 1, 0));
}

Skeleton LsystemBuilder::grow_freely(double h_m, Random& random) const {
  const std::size_t stage = stage_of(h_m);
  const Grammar& grammar = preset_.stages[stage].grammar;
  if (grammar.is_random()) return derive(grammar, random);
  Derived& derived = *derived_[stage];
  {
    const std::lock_guard lock(derived.deriving);
    Random unused(0);
    if (!derived.skeleton) derived.skeleton = derive(grammar, unused);
  }
  return *derived.skeleton;  // does not change any more
}

Skeleton LsystemBuilder::drawn(double h_m, bool has_leaves, Random& random) const {
  Skeleton grown = grow_freely(h_m, random);
  if (!has_leaves) grown.leaves.clear();
  turn_about_stem(grown, random.uniform(0.0, 2.0 * std::numbers::pi));
  return grown;
}

std::string LsystemBuilder::file_of(double h_m) const {
  return preset_.stages[stage_of(h_m)].grammar.file();
}

}  // namespace silvafit::tree
