// SPDX-License-Identifier: MIT
#include "silvafit/tree/overlap.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "segments/skeleton_line.hpp"
#include "silvafit/base/error.hpp"
#include "test_support/measurement_test_support.hpp"
#include "test_support/stand_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

const Preset& fir() { return test::shipped_presets().named("cunninghamia-lanceolata"); }

/// A stand from its morphologies to its meshes.
struct GrownStand {
  std::vector<Morphology> morphologies{};
  std::vector<StandTree> trees{};
  StandOverlap overlap{};
  std::vector<Skeleton> skeletons{};
  std::vector<SceneTree> grown{};
};

GrownStand grow_stand(std::vector<Morphology> morphologies,
                      const Preset& preset = fir(),
                      unsigned threads = 1) {
  GrownStand stand{.morphologies = std::move(morphologies)};
  for (const Morphology& tree : stand.morphologies) {
    stand.trees.push_back(grow_for_stand(tree, SegmentBuilder(preset)));
  }
  stand.overlap = resolve_overlaps(stand.trees, threads);
  for (std::size_t i = 0; i < stand.trees.size(); ++i) {
    const Morphology& tree = stand.morphologies[i];
    const test::Stages stages = test::stages_of(tree, preset);
    stand.skeletons.push_back(
        prune(stages.skeleton, stages.crown, stand.overlap.trees[i]).skeleton);
    stand.grown.push_back(grow_tree(tree, preset, {}, &stand.overlap.trees[i]));
  }
  return stand;
}

/// A crown and its lanes, implemented a second time from the formulas in docs/stands-in-3d.md.
class Outline {
 public:
  Outline(const Morphology& tree, const Preset& preset)
      : h_(tree.h_m), hcb_(tree.hcb_m), a_(preset.crown_index.up), b_(preset.crown_index.down) {
    const TreeShape shape = complete(tree, preset.relative_hc, "");
    hc_ = shape.hc_m;
    radii_ = shape.radii;
  }

  /// s: distance from the axis by the crown's width at this height and azimuth.
  double s(Point p) const {
    if (p.z <= hcb_ || p.z >= h_) return 1e9;
    const double distance = std::hypot(p.x, p.y);
    if (distance == 0.0) return 0.0;
    const double cos2 = p.x * p.x / (distance * distance);
    const double radius = (p.x > 0 ? radii_.east_m : radii_.west_m) * cos2 +
                          (p.y > 0 ? radii_.north_m : radii_.south_m) * (1 - cos2);
    const double width = p.z > hc_ ? std::pow((h_ - p.z) / (h_ - hc_), 1 / a_)
                                   : std::pow((p.z - hcb_) / (hc_ - hcb_), 1 / b_);
    return distance / (radius * width);
  }

 private:
  double h_, hcb_, hc_ = 0.0, a_, b_;
  CrownRadii radii_{};
};

double distance_to(Point p, Point a, Point b) {
  const Point along = b - a;
  const double t = std::clamp(dot(p - a, along) / dot(along, along), 0.0, 1.0);
  return length(p - (a + t * along));
}

/// Whether an axis ends at a measured radius, as found by measure().
bool reaches_radius(const Skeleton& skeleton, const Axis& axis, const CrownRadii& radii) {
  const Point tip = skeleton.points_of(axis).back().at;
  const double reach = std::hypot(tip.x, tip.y);
  return (std::abs(tip.y) <= 0.00873 * std::abs(tip.x) &&
          reach >= (tip.x > 0 ? radii.east_m : radii.west_m) - 0.01) ||
         (std::abs(tip.x) <= 0.00873 * std::abs(tip.y) &&
          reach >= (tip.y > 0 ? radii.north_m : radii.south_m) - 0.01);
}

/// Whether a point lies within a centimeter of the wood of the stem, of a radius branch or of its
/// parents.
bool in_lane(const Skeleton& skeleton, const CrownRadii& radii, Point p) {
  std::vector<bool> has_lane(skeleton.axes.size(), false);
  has_lane[0] = true;
  for (std::size_t i = skeleton.axes.size(); i-- > 1;) {
    const Axis& axis = skeleton.axes[i];
    if (reaches_radius(skeleton, axis, radii)) has_lane[i] = true;
    if (has_lane[i]) has_lane[axis.parent] = true;
  }
  for (std::size_t i = 0; i < has_lane.size(); ++i) {
    if (!has_lane[i]) continue;
    const auto line = skeleton.points_of(skeleton.axes[i]);
    for (std::size_t k = 1; k < line.size(); ++k) {
      const double wood = std::max(line[k].radius_m, line[k - 1].radius_m);
      if (distance_to(p, line[k - 1].at, line[k].at) <= wood + 0.01 + 1e-6) return true;
    }
  }
  return false;
}

struct Breaches {
  std::size_t points = 0;
  std::size_t beyond = 0;
  double worst = 0.0;
};

/// Counts the points of tree i that lie in a neighbor's crown beyond the meeting surface.
class SurfaceCheck {
 public:
  SurfaceCheck(const GrownStand& stand, const Preset& preset) : stand_(stand) {
    for (const Morphology& tree : stand.morphologies) {
      outlines_.emplace_back(tree, preset);
      radii_.push_back(complete(tree, preset.relative_hc, "").radii);
    }
  }

  void look_at(std::size_t i, Point p, double slack, Breaches& found) const {
    ++found.points;
    for (const PairOverlap& pair : stand_.overlap.pairs) {
      if (pair.weaker != i && pair.stronger != i) continue;
      const std::size_t j = pair.weaker == i ? pair.stronger : pair.weaker;
      const Position& a = stand_.morphologies[i].position;
      const Position& b = stand_.morphologies[j].position;
      const Point q = {p.x - (b.x_m - a.x_m), p.y - (b.y_m - a.y_m), p.z - (b.z_m - a.z_m)};
      const double log_share = pair.weaker == i ? pair.log_share : -pair.log_share;
      const auto excess = [&](Point own, Point theirs) {
        return std::log(outlines_[i].s(own) / outlines_[j].s(theirs)) - log_share;
      };
      // Beyond the neighbor's stem, a movement towards the own stem is towards the neighbor's, too:
      // a point that is not beyond the surface could be beyond it after the movement.
      if (outlines_[j].s(q) >= 1.0 || excess(p, q) <= kRounding) continue;
      // Beyond by less than the tolerance: a point moved by it towards the own axis is not beyond.
      const double distance = std::hypot(p.x, p.y);
      const double shrink = distance > slack ? 1.0 - slack / distance : 0.0;
      const Point own = {p.x * shrink, p.y * shrink, p.z};
      const Point moved = q + (own - p);
      const double from_neighbor = std::hypot(moved.x, moved.y);
      // Points in the neighbor's crown by less than the tolerance are not counted.
      if (outlines_[j].s(moved) * (1.0 + slack / std::max(from_neighbor, slack)) >= 1.0) continue;
      const double still = excess(own, moved);
      if (still > kRounding && !in_lane(stand_.skeletons[i], radii_[i], p)) {
        ++found.beyond;
        found.worst = std::max(found.worst, still);
      }
    }
  }

 private:
  static constexpr double kRounding = 1e-6;

  const GrownStand& stand_;
  std::vector<Outline> outlines_{};
  std::vector<CrownRadii> radii_{};
};

Breaches skeleton_breaches(const GrownStand& stand, const Preset& preset) {
  const SurfaceCheck check(stand, preset);
  Breaches found;
  for (std::size_t i = 0; i < stand.skeletons.size(); ++i) {
    for (const Axis& axis : stand.skeletons[i].axes) {
      if (axis.order == 0) continue;
      const auto line = stand.skeletons[i].points_of(axis);
      for (std::size_t k = 1; k < line.size(); ++k) {
        for (double t = 0.0; t <= 1.0; t += 0.1) {
          // Lines are tested every 5 cm; a bend between two tested points may deviate by a few mm.
          check.look_at(i, line[k - 1].at + t * (line[k].at - line[k - 1].at), 0.005, found);
        }
      }
    }
  }
  return found;
}

Breaches mesh_breaches(const GrownStand& stand, const Preset& preset) {
  const SurfaceCheck check(stand, preset);
  Breaches found;
  for (std::size_t i = 0; i < stand.grown.size(); ++i) {
    for (const MeshPart& part : stand.grown[i].mesh.parts) {
      if (part.kind == PartKind::kStem) continue;
      const auto vertex = [&part](std::uint32_t v) {
        const float* at = part.positions.data() + 3 * std::size_t{v};
        return Point{at[0], -at[2], at[1]};
      };
      for (std::size_t t = 0; t < part.indices.size(); t += 3) {
        const Point a = vertex(part.indices[t]);
        const Point b = vertex(part.indices[t + 1]);
        const Point c = vertex(part.indices[t + 2]);
        for (const Point p : {a, b, c, 0.5 * (a + b), 0.5 * (b + c), (1.0 / 3) * (a + b + c)}) {
          // The thickness of wood is tested only sideways; upwards it may reach out by 2 cm.
          check.look_at(i, p, part.kind == PartKind::kBranches ? 0.02 : 0.01, found);
        }
      }
    }
  }
  return found;
}

void check_all_meshes(const GrownStand& stand) {
  for (std::size_t i = 0; i < stand.grown.size(); ++i) {
    test::check_mesh_measurements(stand.morphologies[i], stand.grown[i]);
  }
}

void check_resolved(const GrownStand& stand, const Preset& preset) {
  const Breaches lines = skeleton_breaches(stand, preset);
  CHECK(lines.points > 0);
  CHECK(lines.beyond == 0);
  const Breaches triangles = mesh_breaches(stand, preset);
  CHECK(triangles.points > 0);
  INFO("worst " << triangles.worst << " of " << triangles.points);
  CHECK(triangles.beyond == 0);
  check_all_meshes(stand);
}

/// A dense stand with so small minimum distances that stems are inside other crowns.
std::vector<Morphology> dense_stand(int trees, double side, std::uint64_t seed) {
  Random random(seed);
  std::vector<Morphology> stand;
  for (int i = 0; i < trees; ++i) {
    Morphology tree{.plot = "s", .tree = std::to_string(i)};
    tree.position = {random.uniform(0, side), random.uniform(0, side), random.uniform(-1, 1)};
    tree.h_m = random.uniform(6, 22);
    tree.hcb_m = tree.h_m * random.uniform(0.15, 0.55);
    tree.dbh_cm = tree.h_m * random.uniform(0.8, 1.5);
    const auto radius = [&] { return random.uniform(0.7, 2.6); };
    tree.radii = CrownRadii{radius(), radius(), radius(), radius()};
    stand.push_back(tree);
  }
  return stand;
}

}  // namespace

TEST_CASE("trees 10 and 13 lose branches in the paper's proportion and keep their measurements") {
  const GrownStand stand = grow_stand({test::paper_tree_10(), test::paper_tree_13()});
  REQUIRE(stand.overlap.pairs.size() == 1);
  const PairOverlap& pair = stand.overlap.pairs.front();
  CHECK(pair.weaker == 0);
  CHECK(pair.distance_m == Approx(2.69).margin(0.005));
  // The paper uses the southern and northern radius, 1.7 each; the line between the stems deviates
  // by 6 degrees, where the crowns are 1 mm narrower and 2 mm wider.
  CHECK(pair.facing_radii_m == Approx(3.4).margin(0.005));
  CHECK(pair.competition.total == Approx(0.940).margin(0.002));
  REQUIRE(pair.meeting);
  CHECK(pair.removed_weaker > 0);
  const double wanted = pair.competition.total * static_cast<double>(pair.removed_weaker);
  CHECK(static_cast<double>(pair.removed_stronger) == Approx(wanted).margin(1.0));
  check_resolved(stand, fir());
  for (const SceneTree& tree : stand.grown) {
    CHECK(*tree.removed_share > 0.0);
    CHECK(*tree.removed_share < 0.5);
  }
}

TEST_CASE("a tree without neighbors stays as it is") {
  Morphology far = test::paper_tree_13();
  far.position.x_m += 20;
  const GrownStand stand = grow_stand({test::paper_tree_10(), far});
  CHECK(stand.overlap.pairs.empty());
  for (std::size_t i = 0; i < 2; ++i) {
    const SceneTree alone = grow_tree(stand.morphologies[i], fir());
    CHECK(*stand.grown[i].removed_share == 0.0);
    REQUIRE(alone.mesh.parts.size() == stand.grown[i].mesh.parts.size());
    for (std::size_t p = 0; p < alone.mesh.parts.size(); ++p) {
      CHECK(alone.mesh.parts[p].positions == stand.grown[i].mesh.parts[p].positions);
    }
  }
}

TEST_CASE("dense stands of every preset are resolved") {
  std::uint64_t seed = 40;
  for (const Preset& preset : test::shipped_presets().presets()) {
    INFO(preset.name);
    const GrownStand stand = grow_stand(dense_stand(9, 6.5, seed++), preset);
    CHECK(stand.overlap.pairs.size() >= 12);
    check_resolved(stand, preset);
  }
}

TEST_CASE("a twig beyond a neighbor's stem is kept in its own tree's space") {
  // Stems 0.6 m apart, and a twig that ends beyond the neighbor's stem in its own tree's space.
  Preset preset = test::shipped_presets().named("generic-broadleaf");
  preset.branching.tip_density = 1.0;
  check_resolved(grow_stand(dense_stand(9, 6.5, 41), preset), preset);
}

TEST_CASE("opposite radius branches on one line avoid each other") {
  // A plantation row: equal trees east and west of each other, tips at one height in one line.
  std::vector<Morphology> row;
  row.reserve(4);
  for (int i = 0; i < 4; ++i) {
    row.push_back({.plot = "row",
                   .tree = std::to_string(i),
                   .position = {2.5 * i, 0, 0},
                   .dbh_cm = 16,
                   .h_m = 14,
                   .hcb_m = 5,
                   .cw_m = 3.6});
  }
  const GrownStand stand = grow_stand(row);
  check_resolved(stand, fir());
  std::size_t turned = 0;
  for (const TreeOverlap& tree : stand.overlap.trees) {
    CHECK(tree.crossing == 0);
    turned += tree.turned.size();
  }
  CHECK(turned >= 1);
  // The wood of radius branches does not touch: distance of the lines, tested every cm.
  for (std::size_t i = 0; i < row.size(); ++i) {
    for (const std::size_t j : {i + 1}) {
      if (j >= row.size()) continue;
      for (const Axis& a : stand.skeletons[i].axes) {
        for (const Axis& b : stand.skeletons[j].axes) {
          const auto first = stand.skeletons[i].points_of(a);
          const auto second = stand.skeletons[j].points_of(b);
          if (a.order != 1 || b.order != 1) continue;
          if (std::hypot(first.back().at.x, first.back().at.y) < 1.79) continue;
          if (std::hypot(second.back().at.x, second.back().at.y) < 1.79) continue;
          double nearest = 1e9;
          for (double t = 0.0; t <= 1.0; t += 0.005) {
            const SkeletonPoint p = point_at(first, t);
            for (std::size_t k = 1; k < second.size(); ++k) {
              const Point shift{2.5, 0, 0};
              nearest =
                  std::min(nearest,
                           distance_to(p.at, second[k - 1].at + shift, second[k].at + shift) -
                               p.radius_m - std::max(second[k - 1].radius_m, second[k].radius_m));
            }
          }
          CHECK(nearest > -0.01);
        }
      }
    }
  }
}

TEST_CASE("neither order nor threads change a resolved stand") {
  std::vector<Morphology> stand = dense_stand(12, 7.0, 50);
  const GrownStand forwards = grow_stand(stand);
  std::reverse(stand.begin(), stand.end());
  const GrownStand backwards = grow_stand(stand, fir(), 4);
  REQUIRE(forwards.overlap.pairs.size() == backwards.overlap.pairs.size());
  for (std::size_t i = 0; i < stand.size(); ++i) {
    const SceneTree& a = forwards.grown[i];
    const SceneTree& b = backwards.grown[stand.size() - 1 - i];
    REQUIRE(a.tree == b.tree);
    CHECK(*a.removed_share == *b.removed_share);
    REQUIRE(a.mesh.parts.size() == b.mesh.parts.size());
    for (std::size_t p = 0; p < a.mesh.parts.size(); ++p) {
      CHECK(a.mesh.parts[p].positions == b.mesh.parts[p].positions);
      CHECK(a.mesh.parts[p].indices == b.mesh.parts[p].indices);
    }
  }
}

TEST_CASE("stems at one position keep their measurements, with a note on remaining crossings") {
  Morphology twin = test::paper_tree_10();
  twin.tree = "10b";
  const GrownStand same = grow_stand({test::paper_tree_10(), twin});
  check_all_meshes(same);
  CHECK(same.overlap.trees[0].crossing > 0);
  const auto& notes = same.grown[0].notes;
  CHECK(std::any_of(
      notes.begin(), notes.end(), [](const Note& note) { return note.about == "overlap"; }));

  Morphology small = test::paper_tree_10();
  small.tree = "small";
  small.h_m = 9;
  small.hcb_m = 2;
  small.hc_m = 4;
  small.dbh_cm = 8;
  small.position.x_m += 0.6;
  check_resolved(grow_stand({test::paper_tree_13(), small}), fir());

  CHECK_THROWS_AS(resolve_overlaps(std::vector<StandTree>{same.trees[0], same.trees[0]}),
                  UsageError);
}

TEST_CASE("a stand with too many crowns in one place is refused, naming a tree") {
  const GrownStand one = grow_stand({test::paper_tree_10()});
  std::vector<StandTree> stand(700, one.trees[0]);
  for (std::size_t i = 0; i < stand.size(); ++i) {
    stand[i].tree = std::to_string(i);
    // The first hundred are accepted.
    stand[i].position.x_m += i < 100 ? 10.0 * static_cast<double>(i + 1) : 0.0;
  }
  for (const unsigned threads : {1U, 4U}) {
    CHECK_THROWS_WITH(
        resolve_overlaps(stand, threads),
        Catch::Matchers::Contains("tree 100)") && Catch::Matchers::Contains("599 other trees"));
  }
}

TEST_CASE("a stand with too many crowns in one place is refused before its trees are grown") {
  std::vector<Morphology> stand(700, test::paper_tree_10());
  for (std::size_t i = 0; i < stand.size(); ++i) {
    stand[i].tree = std::to_string(i);
    stand[i].position.x_m = i < 100 ? 10.0 * static_cast<double>(i + 1) : 0.0;
    // Half of the trees have a crown width instead of four radii.
    if (i % 2 == 0) stand[i].radii.reset();
    if (i % 2 == 0) stand[i].cw_m = 2.0;
  }
  for (const unsigned threads : {1U, 4U}) {
    CHECK_THROWS_WITH(
        check_crown_density(stand, threads),
        Catch::Matchers::Contains("tree 100)") && Catch::Matchers::Contains("599 other trees"));
  }
  stand.resize(290);
  CHECK_NOTHROW(check_crown_density(stand));
}
