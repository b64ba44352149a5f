// SPDX-License-Identifier: MIT
#include "view/view_match.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"

namespace silvafit::study {
namespace {

/// Files store positions to a millimeter, tables often to a centimeter; stems are farther apart.
constexpr double kSameMeters = 0.05;

struct PlanPoint {
  double x_m = 0.0;
  double y_m = 0.0;
};

/// x east, y up, z south in the scene.
PlanPoint place_of(const tree::ReadInstance& instance, const tree::Position& origin) {
  return {origin.x_m + instance.transform[12], origin.y_m - instance.transform[14]};
}

bool is_same(const PlanPoint& place, const tree::Position& position) {
  return std::hypot(place.x_m - position.x_m, place.y_m - position.y_m) <= kSameMeters;
}

bool is_drawn(const ViewStand& stand, std::size_t tree) {
  return std::ranges::any_of(stand.variants, [tree](const ViewVariant& variant) {
    return variant.trees[tree].shape.has_value();
  });
}

/// Trees of a table by position.
class Places {
 public:
  explicit Places(const ViewStand& stand) : stand_(stand) {
    for (std::size_t i = 0; i < stand.trees.size(); ++i) {
      const tree::Position& at = stand.trees[i].position;
      cells_[cell_of({at.x_m, at.y_m})].push_back(i);
    }
  }

  std::vector<std::size_t> at(const PlanPoint& place) const {
    std::vector<std::size_t> trees;
    const auto [column, row] = cell_of(place);
    for (std::int64_t i = column - 1; i <= column + 1; ++i) {
      for (std::int64_t k = row - 1; k <= row + 1; ++k) {
        const auto found = cells_.find({i, k});
        if (found == cells_.end()) continue;
        for (const std::size_t tree : found->second) {
          if (is_same(place, stand_.trees[tree].position)) trees.push_back(tree);
        }
      }
    }
    return trees;
  }

 private:
  static std::int64_t cell_at(double coordinate_m) {
    constexpr double kMost = 1e15;  // a scene of another program may have any coordinates
    return std::llround(std::clamp(coordinate_m / kSameMeters, -kMost, kMost));
  }
  static std::pair<std::int64_t, std::int64_t> cell_of(const PlanPoint& place) {
    return {cell_at(place.x_m), cell_at(place.y_m)};
  }

  const ViewStand& stand_;
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::size_t>> cells_{};
};

class Matcher {
 public:
  Matcher(ViewStand& stand, const tree::ReadScene& scene) : stand_(stand), scene_(scene) {
    for (std::size_t i = 0; i < scene.nodes.size(); ++i) nodes_.emplace(scene.nodes[i].name, i);
    for (const tree::ReadInstance& instance : scene.instances) {
      named_.emplace(instance.name, &instance);
      // A tree has at most one instance of its model per material.
      if (instance.tree >= 0.0)
        numbered_.emplace(static_cast<std::size_t>(instance.tree), &instance);
    }
  }

  void match() {
    match_nodes();
    match_instances();
    const auto found = static_cast<std::size_t>(std::ranges::count_if(
        stand_.trees, [](const ViewTree& tree) { return tree.node || tree.number; }));
    const std::size_t here = numbered_.size();
    refuse_others(found, here);
    if (found < stand_.trees.size()) {
      const std::size_t missing = stand_.trees.size() - found;
      stand_.notes.push_back(fmt::format("{} of {} of the table {} not in the scene.",
                                         missing,
                                         counted(stand_.trees.size(), "tree", "trees"),
                                         missing == 1 ? "is" : "are"));
    }
    if (placed_ < here) {
      const std::size_t missing = here - placed_;
      stand_.notes.push_back(fmt::format(
          "{} of {} of the scene {} not in the table, or not unique by {} no measurements.",
          missing,
          counted(here, "tree", "trees"),
          missing == 1 ? "is" : "are",
          missing == 1 ? "position; it has" : "position; they have"));
    }
  }

 private:
  void match_nodes() {
    for (ViewTree& tree : stand_.trees) {
      const std::string name = tree.plot + "-" + tree.tree;
      const auto node = nodes_.find(name);
      const auto instance = named_.find(name);
      if (node == nodes_.end() || instance == named_.end()) continue;
      if (instance->second->tree >= 0.0) continue;
      if (is_same(place_of(*instance->second, scene_.origin), tree.position)) {
        tree.node = node->second;
      } else {
        ++elsewhere_;
      }
    }
  }

  void match_instances() {
    const Places places(stand_);
    std::vector<std::size_t> grown;  // a tree's number counts grown trees only
    for (std::size_t i = 0; i < stand_.trees.size(); ++i) {
      if (is_drawn(stand_, i)) grown.push_back(i);
    }
    std::map<std::size_t, std::vector<std::size_t>> numbers_of_tree;
    for (const auto& [number, instance] : numbered_) {
      const std::vector<std::size_t> trees = places.at(place_of(*instance, scene_.origin));
      if (trees.size() == 1) numbers_of_tree[trees.front()].push_back(number);
      if (trees.size() > 1 && numbered_.size() == grown.size() && number < grown.size() &&
          std::ranges::find(trees, grown[number]) != trees.end()) {
        numbers_of_tree[grown[number]].push_back(number);
      }
    }
    for (const auto& [tree, numbers] : numbers_of_tree) {
      if (numbers.size() > 1) continue;
      stand_.trees[tree].number = numbers.front();
      ++placed_;
    }
  }

  void refuse_others(std::size_t found, std::size_t here) const {
    if (found == 0) {
      throw InputError(elsewhere_ + here == 0
                           ? "no tree of the table is in the scene; nodes are named plot-tree"
                           : "no tree of the table has the position of a tree of the scene; use "
                             "the table, plots and coordinates from which the scene was grown");
    }
    if (2 * placed_ < std::min(here, stand_.trees.size())) {
      throw InputError(
          fmt::format("only {} of the {} trees of the scene {} found in the table by position; use "
                      "the table, plots and coordinates from which the scene was grown",
                      placed_,
                      here,
                      placed_ == 1 ? "is" : "are"));
    }
  }

  ViewStand& stand_;
  const tree::ReadScene& scene_;
  std::unordered_map<std::string, std::size_t> nodes_{};
  std::unordered_map<std::string, const tree::ReadInstance*> named_{};
  std::map<std::size_t, const tree::ReadInstance*> numbered_{};
  std::size_t placed_ = 0;
  std::size_t elsewhere_ = 0;
};

}  // namespace

void match_trees(ViewStand& stand, const tree::ReadScene& scene) { Matcher(stand, scene).match(); }

}  // namespace silvafit::study
