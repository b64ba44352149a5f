// SPDX-License-Identifier: MIT
#include "silvafit/tree/bamboo.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <set>

#include "bamboo_leaves.hpp"
#include "mesh_test_support.hpp"
#include "scratch_file.hpp"
#include "silvafit/base/error.hpp"
#include "tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

const BambooBuilder& moso() {
  return dynamic_cast<const BambooBuilder&>(
      test::shipped_builders().named(BuilderKind::kBamboo, "moso"));
}

/// A grown culm: 10 cm, 14 m, its crown from 8 m up, 2.6 m wide.
Morphology usual_culm(const std::string& name = "1") {
  return {.plot = "1",
          .tree = name,
          .species = "Phyllostachys edulis",
          .dbh_cm = 10.0,
          .h_m = 14.0,
          .hcb_m = 8.0,
          .cw_m = 2.6};
}

struct Bamboo {
  TreeShape shape;
  Crown crown;
  Skeleton skeleton;
};

Bamboo grown(const Morphology& morphology, std::uint64_t seed = 1) {
  TreeShape shape = moso().shape_of(morphology);
  Crown crown(shape, moso().preset().crown_index);
  Random random = random_of_tree(seed, morphology.plot, morphology.tree);
  Skeleton skeleton = moso().grow_skeleton(shape, crown, random);
  return {std::move(shape), std::move(crown), std::move(skeleton)};
}

std::span<const SkeletonPoint> culm_of(const Bamboo& bamboo) {
  return bamboo.skeleton.points_of(bamboo.skeleton.axes.front());
}

/// Heights of ridges: points thicker than the ones below and above.
std::vector<double> ridges_of(const Bamboo& bamboo) {
  const auto culm = culm_of(bamboo);
  std::vector<double> heights;
  for (std::size_t i = 1; i + 1 < culm.size(); ++i) {
    if (culm[i].radius_m > culm[i - 1].radius_m && culm[i].radius_m > culm[i + 1].radius_m) {
      heights.push_back(culm[i].at.z);
    }
  }
  return heights;
}

double tip_reach_m(const Bamboo& bamboo, Point direction) {
  double reach = 0.0;
  for (const Axis& axis : bamboo.skeleton.axes) {
    if (axis.order != 1) continue;
    const Point tip = bamboo.skeleton.points_of(axis).back().at;
    const double along = dot(tip, direction);
    const Point aside = Point{tip.x, tip.y, 0.0} - along * direction;
    if (length(aside) < 1e-9) reach = std::max(reach, along);
  }
  return reach;
}

}  // namespace

TEST_CASE("a section at breast height stands in its place in the mesh") {
  // Where a piece of the curve ends at 1.3 m but for rounding, the section belongs to that end.
  const Morphology tree{
      .plot = "b", .tree = "1069", .dbh_cm = 23.8, .h_m = 2.3, .hcb_m = 0.8, .cw_m = 0.7};
  for (int level = 0; level < kLevelsOfDetail; ++level) {
    const SceneTree grown = grow_tree(tree, moso(), {.mesh = level_of_detail(level)});
    CHECK(grown.measured.dbh_cm == Approx(23.8).epsilon(1e-5));
  }
}

TEST_CASE("any legal bamboo has its measurements on the skeleton and stays inside the crown") {
  Random random(40);
  for (int i = 0; i < 400; ++i) {
    const Morphology morphology = test::random_morphology(random, i);
    INFO("tree " << i << " dbh " << morphology.dbh_cm << " h " << morphology.h_m << " hcb "
                 << morphology.hcb_m);
    const Bamboo bamboo = grown(morphology);
    const auto culm = culm_of(bamboo);
    CHECK(culm.front().at.z == 0.0);
    CHECK(culm.back().at.z == bamboo.shape.h_m);
    CHECK(culm.back().radius_m == 0.0);
    bool rises = true;
    for (std::size_t k = 1; k < culm.size(); ++k) rises = rises && culm[k].at.z > culm[k - 1].at.z;
    CHECK(rises);
    const auto breast = std::find_if(
        culm.begin(), culm.end(), [](const SkeletonPoint& point) { return point.at.z == 1.3; });
    REQUIRE(breast != culm.end());
    CHECK(200.0 * breast->radius_m == Approx(morphology.dbh_cm).epsilon(1e-12));
    CHECK(std::hypot(breast->at.x, breast->at.y) == 0.0);

    double lowest = 1e9;
    double outside = 0.0;
    bool sound = true;
    for (const Axis& axis : bamboo.skeleton.axes) {
      if (axis.order == 0) continue;
      sound = sound && axis.count >= 2;
      for (const SkeletonPoint& point : bamboo.skeleton.points_of(axis)) {
        lowest = std::min(lowest, point.at.z);
        outside = std::max(outside, bamboo.crown.excess_m(point.at));
      }
    }
    for (const LeafSite& leaf : bamboo.skeleton.leaves) {
      lowest = std::min(lowest, leaf.at.z);
      const Point end = leaf.at + leaf.length_m * leaf.along;
      outside = std::max({outside, bamboo.crown.excess_m(leaf.at), bamboo.crown.excess_m(end)});
      sound = sound && std::abs(length(leaf.along) - 1.0) < 1e-12 &&
              std::abs(length(leaf.facing) - 1.0) < 1e-12 &&
              std::abs(dot(leaf.along, leaf.facing)) < 1e-12 &&
              leaf.grade < moso().style().leaves.pictures.size() &&
              leaf.axis < bamboo.skeleton.axes.size();
    }
    CHECK(sound);
    // Crown curves round where they are steep; a hundredth of a millimeter is no branch.
    CHECK(outside < 1e-5);
    CHECK(lowest == Approx(bamboo.shape.hcb_m).margin(1e-9));
    const CrownRadii& radii = bamboo.shape.radii;
    CHECK(tip_reach_m(bamboo, {1, 0, 0}) == Approx(radii.east_m).epsilon(1e-9));
    CHECK(tip_reach_m(bamboo, {-1, 0, 0}) == Approx(radii.west_m).epsilon(1e-9));
    CHECK(tip_reach_m(bamboo, {0, -1, 0}) == Approx(radii.south_m).epsilon(1e-9));
    CHECK(tip_reach_m(bamboo, {0, 1, 0}) == Approx(radii.north_m).epsilon(1e-9));
  }
}

TEST_CASE("internodes are short at the base, longest in the middle and short at the top") {
  const CulmStyle style{.internode_length_sd = 0.0};
  Random random(1);
  const std::vector<double> nodes = node_heights_m(style, 14.0, 54, random);
  REQUIRE(nodes.size() == 53);
  std::vector<double> lengths{nodes.front()};
  for (std::size_t i = 1; i < nodes.size(); ++i) lengths.push_back(nodes[i] - nodes[i - 1]);
  lengths.push_back(14.0 - nodes.back());
  const auto longest = std::max_element(lengths.begin(), lengths.end());
  CHECK(static_cast<double>(longest - lengths.begin()) / 54.0 ==
        Approx(style.longest_at).margin(0.02));
  CHECK(std::is_sorted(lengths.begin(), longest));
  CHECK(std::is_sorted(longest, lengths.end(), std::greater<>()));
  // Half an internode from the ends the shares are a little above those at the ends.
  CHECK(lengths.front() / *longest == Approx(style.internode_base).margin(0.03));
  CHECK(lengths.back() / *longest == Approx(style.internode_top).margin(0.03));
  CHECK(*longest < 0.4);
  CHECK(node_heights_m(style, 2.0, 1, random).empty());
}

TEST_CASE("a culm has the internodes that were measured, with a ridge at each node") {
  Morphology culm = usual_culm();
  culm.culm.internodes = 41;
  const Bamboo bamboo = grown(culm);
  const std::vector<double> ridges = ridges_of(bamboo);
  // All 40 nodes but any so near to breast height that its ridge would be measured, and the last
  // few, where the culm tapers so fast that it is thicker below the ridge.
  CHECK(ridges.size() >= 37);
  CHECK(ridges.size() <= 40);
  for (const double z : ridges) CHECK(std::abs(z - 1.3) > 0.001);
  // The lowest branches stand at a node, which is the crown base.
  CHECK(std::any_of(
      ridges.begin(), ridges.end(), [](double z) { return std::abs(z - 8.0) < 1e-12; }));
  const auto points = culm_of(bamboo);
  const auto at_base = std::find_if(
      points.begin(), points.end(), [](const SkeletonPoint& point) { return point.at.z == 8.0; });
  REQUIRE(at_base != points.end());
  const double even = 0.005 * moso().preset().taper.diameter_cm(8.0, 14.0, 10.0);
  CHECK(at_base->radius_m == Approx(1.05 * even).epsilon(1e-12));
}

TEST_CASE("a culm bends as it was measured, as far as its crown lets it") {
  Morphology culm = usual_culm();
  culm.culm.bend_deg = 1.2;
  culm.culm.bend_azimuth_deg = 90.0;
  const Bamboo bamboo = grown(culm);
  const auto points = culm_of(bamboo);
  const Point tip = points.back().at;
  // An arch that turns by T leans by T / 2: 6 m tan(0.6 degrees) = 0.0628 m.
  CHECK(tip.x == Approx(6.0 * std::tan(0.6 * std::numbers::pi / 180.0)).epsilon(1e-6));
  CHECK(std::abs(tip.y) < 1e-12);
  for (const SkeletonPoint& point : points) {
    if (point.at.z <= 8.0) CHECK(std::hypot(point.at.x, point.at.y) == 0.0);
  }
  CHECK(bamboo.skeleton.notes.empty());
  culm.culm.bend_deg = 50.0;
  const Bamboo bent = grown(culm);
  REQUIRE(bent.skeleton.notes.size() == 1);
  CHECK(bent.skeleton.notes.front().about == "bend_deg");
  CHECK(culm_of(bent).back().at.x > tip.x);
}

TEST_CASE("two unequal branches stand at each node, nodes on the two sides in turn") {
  const Bamboo bamboo = grown(usual_culm());
  // Bases by height: each height twice.
  std::vector<double> bases;
  for (const Axis& axis : bamboo.skeleton.axes) {
    if (axis.order == 1) bases.push_back(bamboo.skeleton.points_of(axis).front().at.z);
  }
  std::sort(bases.begin(), bases.end());
  const std::set<double> heights(bases.begin(), bases.end());
  CHECK(bases.size() == 2 * heights.size());
  CHECK(heights.size() > 12);
  CHECK(*heights.begin() == 8.0);
  const auto orders = [&](std::uint32_t order) {
    return std::count_if(bamboo.skeleton.axes.begin(),
                         bamboo.skeleton.axes.end(),
                         [order](const Axis& axis) { return axis.order == order; });
  };
  CHECK(orders(2) > 3 * orders(1));
  CHECK(orders(3) == 0);
  CHECK(bamboo.skeleton.leaves.size() > static_cast<std::size_t>(2 * orders(2)));
}

TEST_CASE("the same seed gives the same culm, another seed or name another") {
  const Bamboo one = grown(usual_culm());
  const Bamboo same = grown(usual_culm());
  REQUIRE(one.skeleton.points.size() == same.skeleton.points.size());
  bool equal = true;
  for (std::size_t i = 0; i < one.skeleton.points.size(); ++i) {
    const Point off = one.skeleton.points[i].at - same.skeleton.points[i].at;
    equal = equal && length(off) == 0.0;
  }
  CHECK(equal);
  const Bamboo other_seed = grown(usual_culm(), 2);
  const Bamboo other_name = grown(usual_culm("2"));
  CHECK(ridges_of(one) != ridges_of(other_seed));
  CHECK(ridges_of(one) != ridges_of(other_name));
}

TEST_CASE("a culm keeps its nodes when its crown is measured again") {
  const Bamboo before = grown(usual_culm());
  Morphology later = usual_culm();
  later.cw_m = 2.9;
  const Bamboo after = grown(later);
  CHECK(ridges_of(before) == ridges_of(after));
  // And most of its branches their azimuth: all but those led to a measured radius.
  std::size_t kept = 0;
  std::size_t all = 0;
  for (std::size_t i = 0; i < before.skeleton.axes.size(); ++i) {
    if (before.skeleton.axes[i].order != 1) continue;
    ++all;
    const auto a = before.skeleton.points_of(before.skeleton.axes[i]);
    for (const Axis& axis : after.skeleton.axes) {
      if (axis.order != 1) continue;
      const auto b = after.skeleton.points_of(axis);
      if (b.front().at.z != a.front().at.z) continue;
      const Point from = direction({a.back().at.x, a.back().at.y, 0.0});
      const Point to = direction({b.back().at.x, b.back().at.y, 0.0});
      if (dot(from, to) > 0.999) {
        ++kept;
        break;
      }
    }
  }
  CHECK(kept >= all - 8);
}

TEST_CASE("leaves are brighter on the sunny side, outside and on outer branches") {
  const Bamboo bamboo = grown(usual_culm());
  const auto& light = moso().style().leaves.light;
  const double sun = moso().style().culm.sun_azimuth_deg;
  REQUIRE(sun == 180.0);
  const auto at = [&](Point place, std::uint32_t order) {
    return leaf_light(light, bamboo.crown, sun, place, order);
  };
  CHECK(at({0, -1, 11}, 2) > at({0, 1, 11}, 2));
  CHECK(at({0, -1, 11}, 2) > at({0, -0.3, 11}, 2));
  CHECK(at({0, -1, 11}, 2) > at({0, -1, 11}, 1));
  CHECK(at({0, -0.3, 13}, 2) > at({0, -0.3, 9}, 2));
  // Grades of all leaves to the south and to the north; most branches of one culm may be on one
  // side.
  double south = 0.0;
  double north = 0.0;
  int souths = 0;
  int norths = 0;
  std::set<std::uint32_t> grades;
  for (int i = 0; i < 30; ++i) {
    for (const LeafSite& leaf : grown(usual_culm(std::to_string(i))).skeleton.leaves) {
      grades.insert(leaf.grade);
      (leaf.at.y < 0.0 ? south : north) += leaf.grade;
      ++(leaf.at.y < 0.0 ? souths : norths);
    }
  }
  CHECK(grades.size() == moso().style().leaves.pictures.size());
  CHECK(south / souths > north / norths + 0.2);
}

TEST_CASE("pictures are ranked by the color weight of what is drawn") {
  // Half the pixels drawn: (3, 4, 12) has the weight 13, (0, 0, 0) none; the rest is transparent.
  const Texture picture{.name = "a",
                        .width = 2,
                        .height = 2,
                        .rgba = {3, 4, 12, 255, 0, 0, 0, 255, 250, 250, 250, 0, 9, 9, 9, 100}};
  CHECK(color_weight(picture) == Approx(6.5).epsilon(1e-15));
  CHECK(color_weight({.width = 1, .height = 1, .rgba = {9, 9, 9, 0}}) == 0.0);
  const auto& pictures = moso().style().leaves.pictures;
  REQUIRE(pictures.size() >= 3);
  for (std::size_t i = 1; i < pictures.size(); ++i) {
    CHECK(color_weight(*pictures[i]) > color_weight(*pictures[i - 1]));
  }
  for (const auto& leaf : pictures) {
    REQUIRE(leaf->rgba.size() == 4 * leaf->width * leaf->height);
    std::size_t drawn = 0;
    for (std::size_t i = 3; i < leaf->rgba.size(); i += 4) drawn += leaf->rgba[i] > 127 ? 1 : 0;
    const double cover =
        static_cast<double>(drawn) / static_cast<double>(leaf->width * leaf->height);
    CHECK(cover > 0.1);
    CHECK(cover < 0.6);
  }
  const std::vector<std::shared_ptr<const Texture>> turned(pictures.rbegin(), pictures.rend());
  CHECK(ranked_by_color(turned) == pictures);
}

TEST_CASE("a wrong bamboo preset is refused with its file and field") {
  const std::filesystem::path models = test::source_file("models");
  std::ifstream file(models / "bamboo" / "moso.json");
  const std::string good((std::istreambuf_iterator<char>(file)), {});
  const auto refused = [&](const std::string& from, const std::string& to) {
    std::string bad = good;
    const std::size_t at = bad.find(from);
    REQUIRE(at != std::string::npos);
    bad.replace(at, from.size(), to);
    const test::ScratchFile scratch(bad, ".json");
    try {
      BambooPreset::load(models, scratch.path());
    } catch (const InputError& error) {
      return error.place().column;
    }
    return std::string("accepted");
  };
  CHECK(refused("\"mu\": 4", "\"mu\": 3.5") == "branches.mu");
  CHECK(refused("\"expectation_deg\": 50", "\"expectation_deg\": 80") ==
        "branches.angle.expectation_deg");
  CHECK(refused("\"internode_m\"", "\"internode\"") == "culm.internode");
  CHECK(refused("\"form\": \"crossed cards\"", "\"form\": \"ball\"") == "leaves.form");
  CHECK(refused("\"outer\": 0.4", "\"outer\": 0.5") == "leaves.light.outer");
  CHECK(refused("\"grades\": 4", "\"grades\": 2.5") == "leaves.grades");
  CHECK(refused("\"picture_size\": 64", "\"picture_size\": 65") == "leaves.picture_size");
  CHECK(refused("\"culm_color\": [0.19", "\"culm_color\": [1.9") == "culm_color");
}

namespace {

void check_measured(const Morphology& tree, const SceneTree& bamboo) {
  const Measurements& measured = bamboo.measured;
  const double radius = 0.5 * tree.cw_m.value_or(0.0);
  const CrownRadii radii = tree.radii.value_or(CrownRadii{radius, radius, radius, radius});
  // As for the other builders: a centimeter, and a millimeter of DBH.
  CHECK(measured.h_m == Approx(tree.h_m).margin(0.01));
  CHECK(measured.hcb_m == Approx(tree.hcb_m).margin(0.01));
  CHECK(measured.dbh_cm == Approx(tree.dbh_cm).margin(0.1));
  CHECK(measured.radii.east_m == Approx(radii.east_m).margin(0.01));
  CHECK(measured.radii.west_m == Approx(radii.west_m).margin(0.01));
  CHECK(measured.radii.south_m == Approx(radii.south_m).margin(0.01));
  CHECK(measured.radii.north_m == Approx(radii.north_m).margin(0.01));
}

}  // namespace

TEST_CASE("any legal bamboo has its measurements on the mesh, closed and inside the crown") {
  Random random(41);
  for (int i = 0; i < 120; ++i) {
    const Morphology tree = test::random_morphology(random, i);
    INFO("tree " << i << " dbh " << tree.dbh_cm << " h " << tree.h_m << " hcb " << tree.hcb_m
                 << " cw " << tree.cw_m.value_or(-1.0) << " hc " << tree.hc_m.value_or(-1.0));
    const Crown crown(moso().shape_of(tree), moso().preset().crown_index);
    const MeshOptions base{.closed_branches = true, .textured = i % 2 == 0};
    const MeshOptions options = level_of_detail(i % kLevelsOfDetail, base);
    const SceneTree bamboo = grow_tree(tree, moso(), {.mesh = options});
    check_measured(tree, bamboo);
    for (const MeshPart& part : bamboo.mesh.parts) {
      INFO(part_name(part.kind));
      if (part.kind != PartKind::kFoliage) CHECK(test::open_edges(part) == 0);
      if (part.kind == PartKind::kStem) {
        CHECK(test::volume_m3(part) > 0.0);
        continue;
      }
      double outside = 0.0;
      for (std::size_t v = 0; v < part.vertex_count(); ++v) {
        outside = std::max(outside, crown.excess_m(test::vertex_of(part, v)));
      }
      CHECK(outside < 0.001);
    }
  }
}

TEST_CASE("ridges stand out on the culm's mesh, and breast height is as measured") {
  const SceneTree bamboo = grow_tree(usual_culm(), moso(), {.mesh = level_of_detail(0)});
  CHECK(bamboo.measured.dbh_cm == Approx(10.0).epsilon(1e-5));
  const MeshPart& stem = bamboo.mesh.parts.front();
  // Highest vertices of the tube by height, in the straight part below the crown.
  std::map<float, double> radius_at;
  for (std::size_t v = 0; v < stem.vertex_count(); ++v) {
    const Point at = test::vertex_of(stem, v);
    if (at.z > 0.5 && at.z < 7.5) {
      double& radius = radius_at[static_cast<float>(at.z)];
      radius = std::max(radius, std::hypot(at.x, at.y));
    }
  }
  std::size_t ridges = 0;
  double before = 1e9;
  bool rising = false;
  for (const auto& [z, radius] : radius_at) {
    if (radius > 1.03 * before) rising = true;
    if (rising && radius < 0.98 * before) {
      ++ridges;
      rising = false;
    }
    before = radius;
  }
  // 14 m in 54 internodes or so, the longest below the middle: 7 m of it have 20 to 30 nodes.
  CHECK(ridges >= 18);
  CHECK(ridges <= 32);
}

TEST_CASE("cards carry the pictures of their grades") {
  const SceneTree bamboo = grow_tree(usual_culm(), moso(), {.mesh = {.textured = true}});
  const MeshPart& foliage = bamboo.mesh.parts.back();
  REQUIRE(foliage.kind == PartKind::kFoliage);
  REQUIRE(foliage.texture);
  const auto grades = moso().style().leaves.pictures.size();
  CHECK(foliage.texture->width == grades * foliage.texture->height);
  CHECK(foliage.double_sided);
  // Two cards of two triangles a site.
  const Bamboo skeleton = grown(usual_culm());
  CHECK(foliage.triangle_count() <= 4 * skeleton.skeleton.leaves.size());
  CHECK(foliage.triangle_count() > 3 * skeleton.skeleton.leaves.size());
  // Each card lies in one picture.
  bool in_one = true;
  for (std::size_t i = 0; i < foliage.triangle_count(); ++i) {
    double least = 1.0;
    double most = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double u = foliage.uvs[2 * foliage.indices[3 * i + k]];
      least = std::min(least, u);
      most = std::max(most, u);
    }
    const double share = 1.0 / static_cast<double>(grades);
    in_one = in_one && std::abs(most - least - share) < 1e-6;
  }
  CHECK(in_one);
}

TEST_CASE("pictures lie side by side as they are") {
  const auto one = std::make_shared<const Texture>(
      Texture{.name = "one", .width = 1, .height = 1, .rgba = {1, 2, 3, 255}});
  const auto two = std::make_shared<const Texture>(
      Texture{.name = "two", .width = 2, .height = 1, .rgba = {4, 5, 6, 255, 7, 8, 9, 0}});
  const PictureRow row = side_by_side({one, two, one}, 2, "row");
  // Three squares of two pixels and an empty one.
  CHECK(row.whole->width == 8);
  CHECK(row.whole->height == 2);
  CHECK(row.share == 0.25);
  const std::vector<std::uint8_t> line{1, 2, 3, 255, 1, 2, 3, 255, 4, 5, 6, 255, 7, 8, 9, 0,
                                       1, 2, 3, 255, 1, 2, 3, 255, 0, 0, 0, 0,   0, 0, 0, 0};
  const auto& rgba = row.whole->rgba;
  REQUIRE(rgba.size() == 2 * line.size());
  CHECK(std::equal(line.begin(), line.end(), rgba.begin()));
  CHECK(std::equal(line.begin(), line.end(), rgba.begin() + 32));
  // 188 is the sRGB of 0.5029 (IEC 61966-2-1).
  const Color mean = mean_color({.width = 2, .height = 1, .rgba = {188, 0, 255, 255, 9, 9, 9, 0}});
  CHECK(mean[0] == Approx(0.5029).margin(0.0001));
  CHECK(mean[1] == 0.0);
  CHECK(mean[2] == 1.0);
}

TEST_CASE("a preset's own pictures are ranked, whatever their order and size") {
  // Opaque, packed with Python's zlib: 2 x 1 pixels (200, 220, 90) (180, 210, 80), and 1 x 1
  // of (20, 60, 15).
  const std::string bright = std::string(
      "\211\120\116\107\015\012\032\012\000\000\000\015\111\110\104\122\000\000"
      "\000\002\000\000\000\001\010\002\000\000\000\173\100\350\335\000\000\000"
      "\017\111\104\101\124\170\332\143\070\161\047\152\313\245\000\000\016\173"
      "\003\325\054\270\227\037\000\000\000\000\111\105\116\104\256\102\140\202",
      72);
  const std::string dark = std::string(
      "\211\120\116\107\015\012\032\012\000\000\000\015\111\110\104\122\000\000"
      "\000\001\000\000\000\001\010\002\000\000\000\220\167\123\336\000\000\000"
      "\014\111\104\101\124\170\332\143\020\261\341\007\000\000\307\000\140\150"
      "\306\366\207\000\000\000\000\111\105\116\104\256\102\140\202",
      69);
  const test::ScratchFile first(bright, ".png");
  const test::ScratchFile second(dark, ".png");
  std::ifstream file(test::source_file("models/bamboo/moso.json"));
  std::string text((std::istreambuf_iterator<char>(file)), {});
  const std::string field = "\"pictures\": [\"" + first.path().filename().string() + "\", \"" +
                            second.path().filename().string() + "\"], \"per_twig\"";
  text.replace(text.find("\"per_twig\""), 10, field);
  const test::ScratchFile preset(text, ".json");
  const BambooPreset loaded = BambooPreset::load(test::source_file("models"), preset.path());
  REQUIRE(loaded.leaves.pictures.size() == 2);
  CHECK(loaded.leaves.pictures[0]->rgba == std::vector<std::uint8_t>{20, 60, 15, 255});
  CHECK(loaded.leaves.pictures[1]->rgba ==
        std::vector<std::uint8_t>{200, 220, 90, 255, 180, 210, 80, 255});
  const BambooBuilder builder(loaded);
  const SceneTree bamboo = grow_tree(usual_culm(), builder, {.mesh = {.textured = true}});
  REQUIRE(bamboo.mesh.parts.back().texture);
  CHECK(bamboo.mesh.parts.back().texture->width == 128);

  const test::ScratchFile broken(bright.substr(0, 40), ".png");
  text.replace(text.find(first.path().filename().string()),
               first.path().filename().string().size(),
               broken.path().filename().string());
  const test::ScratchFile bad(text, ".json");
  CHECK_THROWS_AS(BambooPreset::load(test::source_file("models"), bad.path()), InputError);
}
