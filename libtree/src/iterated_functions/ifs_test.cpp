// SPDX-License-Identifier: MIT
#include "iterated_functions/ifs.hpp"

#include <catch2/catch.hpp>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "test_support/fitted_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;
namespace fs = std::filesystem;

namespace {

/// Any matrix with a spectral norm of 0.2 to 0.8.
AffineMap random_map(Random& random) {
  AffineMap map;
  for (auto& row : map.a) {
    for (double& value : row) value = random.uniform(-1.0, 1.0);
  }
  map = scaled(map, random.uniform(0.2, 0.8) / map.spectral_norm());
  map.b = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
  return map;
}

/// Two equal side branches, and optionally an equal continuation.
IfsPreset forked(int depth, bool continues) {
  std::vector<IfsCopy> copies;
  const auto add = [&copies](AffineMap map, double scale, double probability, bool goes_on) {
    map = scaled(map, scale);
    map.b = {0, 0, goes_on ? 1.0 : 0.6};
    copies.push_back({.map = map,
                      .scale = scale,
                      .probability = probability,
                      .thickness = scale,
                      .continues = goes_on});
  };
  if (continues) add(turn_about({1, 0, 0}, 0.05), 0.8, 0.2, true);
  add(turn_about({1, 0, 0}, 0.8), 0.5, continues ? 0.5 : 0.7, false);
  add(turn_about({1, 0, 0}, -0.7), 0.4, 0.3, false);
  IfsPreset preset;
  preset.copies = std::move(copies);
  preset.trunk.segments = 1;
  preset.limits.depth = depth;
  preset.leaves.count = 0;
  return preset;
}

std::size_t power_sum(std::size_t base, int depth) {
  std::size_t sum = 0;
  std::size_t power = 1;
  for (int i = 0; i <= depth; ++i) {
    sum += power;
    power *= base;
  }
  return sum;
}

const IfsBuilder& ifs_preset(const char* name) {
  return dynamic_cast<const IfsBuilder&>(test::shipped_builders().named(BuilderKind::kIfs, name));
}

}  // namespace

TEST_CASE("maps are composed as functions are") {
  Random random(64);
  for (int i = 0; i < 20; ++i) {
    const AffineMap f = random_map(random);
    const AffineMap g = random_map(random);
    const Point x{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    // A few roundings of numbers near 1.
    CHECK(length(f.after(g)(x) - f(g(x))) < 1e-14);
    CHECK(f.after(g).determinant() == Approx(f.determinant() * g.determinant()).margin(1e-14));
    CHECK(length(f.turn(x)) <= f.spectral_norm() * length(x) * (1 + 1e-14));
  }
  const Point east = turn_about({0, 0, 1}, std::numbers::pi / 2).turn({0, -1, 0});
  CHECK(length(east - Point{1, 0, 0}) < 1e-15);
}

TEST_CASE("k maps give the sum of k^d copies, with the lengths of their maps") {
  Random random(65);
  for (int depth = 1; depth <= 7; ++depth) {
    const Skeleton lateral = grow_ifs(forked(depth, false), random);
    CHECK(lateral.axes.size() == power_sum(2, depth));
    std::vector<double> scale(lateral.axes.size(), 1.0);
    for (std::size_t i = 1; i < lateral.axes.size(); ++i) {
      const Axis& axis = lateral.axes[i];
      const auto line = lateral.points_of(axis);
      const double size = length(line.back().at - line.front().at);
      const auto parent = lateral.points_of(lateral.axes[axis.parent]);
      const double of_parent = length(parent.back().at - parent.front().at);
      CHECK((size / of_parent == Approx(0.5).epsilon(1e-12) ||
             size / of_parent == Approx(0.4).epsilon(1e-12)));
      // Both start at 0.6 of their parent.
      const Point base = parent.front().at + 0.6 * (parent.back().at - parent.front().at);
      CHECK(length(line.front().at - base) < 1e-12);
    }
    // A copy that continues its axis adds a point to it; every other one starts an axis of two.
    const Skeleton continued = grow_ifs(forked(depth, true), random);
    CHECK(continued.points.size() - continued.axes.size() == power_sum(3, depth));
  }
}

TEST_CASE("limits prevent that a system of many copies exhausts memory") {
  Random random(66);
  IfsPreset preset = forked(40, true);
  CHECK_THROWS_AS(grow_ifs(preset, random), GeometryError);
  preset.limits.least_scale = 0.1;
  const Skeleton skeleton = grow_ifs(preset, random);
  CHECK(skeleton.axes.size() > 10);
  for (const Axis& axis : skeleton.axes) {
    const auto line = skeleton.points_of(axis);
    CHECK(length(line.back().at - line[line.size() - 2].at) >= 0.1 - 1e-12);
  }
}

TEST_CASE("leaves are distributed by the probabilities") {
  Random random(67);
  IfsPreset preset = forked(6, false);
  preset.leaves.count = 20000;
  const Skeleton skeleton = grow_ifs(preset, random);
  REQUIRE(skeleton.leaves.size() == preset.leaves.count);
  std::array<double, 2> of_first{};
  for (const LeafSite& leaf : skeleton.leaves) {
    std::uint32_t axis = leaf.axis;
    // All are on copies of the last depth.
    CHECK(skeleton.axes[axis].order == 6);
    while (skeleton.axes[axis].order > 1) axis = skeleton.axes[axis].parent;
    of_first[axis - 1] += 1.0;
    const auto line = skeleton.points_of(skeleton.axes[leaf.axis]);
    const Point along = direction(line.back().at - line.front().at);
    CHECK(dot(along, leaf.along) ==
          Approx(std::cos(preset.leaves.angle_deg * std::numbers::pi / 180)).margin(1e-12));
    CHECK(std::abs(dot(leaf.along, leaf.facing)) < 1e-12);
  }
  // Five standard deviations of a binomial proportion.
  CHECK(of_first[0] / 20000 == Approx(0.7).margin(5 * std::sqrt(0.7 * 0.3 / 20000)));
}

TEST_CASE("trees of every system have any valid measurements") {
  Random random(68);
  for (const Builder* builder : test::shipped_builders().of(BuilderKind::kIfs)) {
    for (int i = 0; i < 60; ++i) {
      const Morphology tree = test::random_morphology(random, i);
      const TreeShape shape = builder->shape_of(tree);
      const Crown crown(shape, builder->preset().crown_index);
      Random own = random_of_tree(1, tree.plot, tree.tree);
      const Skeleton skeleton = builder->grow_skeleton(shape, crown, own);
      INFO(builder->name());
      test::check_fitted({&builder->preset().taper, shape, crown, skeleton});
    }
  }
}

TEST_CASE("the same random numbers give the same copies, others different ones") {
  const IfsBuilder& builder = ifs_preset("broadleaf");
  const auto points = [&](std::uint64_t seed) {
    Random random(seed);
    std::vector<double> all;
    const Skeleton skeleton = grow_ifs(builder.preset(), random);
    for (const SkeletonPoint& p : skeleton.points) all.push_back(p.at.x);
    for (const LeafSite& leaf : skeleton.leaves) all.push_back(leaf.at.z);
    return all;
  };
  CHECK(points(1) == points(1));
  CHECK(points(1) != points(2));
}

TEST_CASE("a listed species gets its system, and others get the fallback") {
  const BuilderCatalogue& catalogue = test::shipped_builders();
  CHECK(catalogue.fallback(BuilderKind::kIfs).name() == "broadleaf");
  CHECK(catalogue.choose(BuilderKind::kIfs, "SM").builder->name() == "conifer");
  CHECK(catalogue.choose(BuilderKind::kIfs, "Abies alba").builder->name() == "conifer");
  CHECK_FALSE(catalogue.choose(BuilderKind::kIfs, "Quercus").is_listed);
}

TEST_CASE("a system with an invalid field is refused with file and field") {
  const fs::path models = fs::temp_directory_path() / "silvafit-ifs-test";
  fs::remove_all(models);
  fs::create_directories(models);
  for (const char* folder : {"taper", "shoots", "bark"}) {
    fs::copy(test::source_file("models") / folder, models / folder);
  }
  const auto column_of_error = [&](const char* name,
                                   const std::string& find,
                                   const std::string& replacement) {
    std::string text = read_file(test::source_file("models/ifs/" + std::string(name) + ".json"));
    REQUIRE(text.find(find) != std::string::npos);
    text.replace(text.find(find), find.size(), replacement);
    write_file(models / "one.json", text);
    try {
      IfsBuilder::load(models, models / "one.json");
    } catch (const InputError& error) {
      CHECK(error.place().file.find(".json") != std::string::npos);
      return test::path_of(error);
    }
    return std::string("accepted");
  };
  const auto with_value = [&](const char* name, const std::string& field, const char* value) {
    const std::string text =
        read_file(test::source_file("models/ifs/" + std::string(name) + ".json"));
    const std::size_t at = text.find("\"" + field + "\": ");
    REQUIRE(at != std::string::npos);
    const std::size_t begin = at + field.size() + 4;
    std::size_t end = begin;
    for (int depth = 0; end < text.size(); ++end) {
      if (text[end] == '[' || text[end] == '{') ++depth;
      if (depth == 0 && (text[end] == ',' || text[end] == ' ' || text[end] == '\n')) break;
      if (text[end] == ']' || text[end] == '}') --depth;
    }
    return column_of_error(name, text.substr(at, end - at), "\"" + field + "\": " + value);
  };
  CHECK(with_value("broadleaf", "scale", "1.5") == "maps[0].scale");
  CHECK(with_value("broadleaf", "at", "0.9") == "maps[0].at");
  CHECK(with_value("broadleaf", "angle_deg", "-1") == "maps[0].angle_deg");
  CHECK(with_value("broadleaf", "probability", "0.5") == "maps");
  CHECK(with_value("broadleaf", "depth", "65") == "recursion.depth");
  CHECK(with_value("broadleaf", "depth", "2.5") == "recursion.depth");
  CHECK(with_value("broadleaf", "segments", "0") == "trunk.segments");
  CHECK(with_value("broadleaf", "form", "\"round\"") == "leaves.look.form");
  CHECK(with_value("broadleaf", "count", "-1") == "leaves.count");
  CHECK(with_value("broadleaf", "taper", "\"none\"").empty());
  CHECK(with_value("conifer", "orders", "[2, 1]") == "maps[0].orders");
  CHECK(with_value("conifer", "orders", "[0, 1]") == "maps");
  CHECK(with_value("fern", "matrix", "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 1]]") ==
        "maps[4].matrix");
  CHECK(with_value("fern", "matrix", "[[0.5, 0, 0, 0], [0, 0.5, 0, 0]]") == "maps[4].matrix");
  CHECK(column_of_error("broadleaf", "\"trunk\"", "\"trunks\"") == "trunks");
  CHECK(column_of_error("broadleaf", "\"turn_deg\"", "\"twist_deg\"") == "maps[0].twist_deg");
  CHECK(column_of_error("broadleaf",
                        "\"depth\": 14, \"least_scale\": 0.19",
                        "\"depth\": 20, \"least_scale\": 0") == "recursion");
  CHECK(column_of_error("broadleaf", "silvafit-ifs/1", "silvafit-ifs/2") == "schema");
  CHECK(with_value("broadleaf", "depth", "4") == "accepted");
  fs::remove_all(models);
}

TEST_CASE(
    "the fronds of a tree fern start at the top of the stem, and one hangs to the crown base") {
  const Builder& fern = test::shipped_builders().named(BuilderKind::kIfs, "fern");
  const double head = dynamic_cast<const IfsBuilder&>(fern).preset().head;
  REQUIRE(head == 0.85);
  for (int i = 0; i < 5; ++i) {
    const Morphology tree{.plot = "1",
                          .tree = std::to_string(i),
                          .dbh_cm = 22,
                          .h_m = 6,
                          .hcb_m = 3.6 - 0.5 * i,
                          .cw_m = 5.0 - 0.4 * i};
    const TreeShape shape = fern.shape_of(tree);
    const Crown crown(shape, fern.preset().crown_index);
    Random random(static_cast<std::uint64_t>(i) + 1);
    const Skeleton skeleton = fern.grow_skeleton(shape, crown, random);
    const double crown_m = tree.h_m - tree.hcb_m;
    int fronds = 0;
    int hanging = 0;
    double lowest_m = tree.h_m;
    for (const Axis& axis : skeleton.axes) {
      if (axis.order != 1) continue;
      const auto points = skeleton.points_of(axis);
      ++fronds;
      CHECK(points.front().at.z >= tree.hcb_m + head * crown_m - 1e-9);
      // Old ones end lower than they start.
      hanging += points.back().at.z < points.front().at.z ? 1 : 0;
      for (const SkeletonPoint& point : points) lowest_m = std::min(lowest_m, point.at.z);
    }
    CHECK(fronds > 20);
    CHECK(hanging > fronds / 2);
    CHECK(lowest_m == Approx(tree.hcb_m).margin(1e-9));
  }
}
