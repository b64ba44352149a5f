// SPDX-License-Identifier: MIT
#include "silvafit/tree/lsystem_builder.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <set>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "test_support/measurement_test_support.hpp"
#include "test_support/mesh_test_support.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;
namespace fs = std::filesystem;

namespace {

std::vector<const LsystemBuilder*> shipped() {
  std::vector<const LsystemBuilder*> builders;
  for (const Builder* builder : test::shipped_builders().of(BuilderKind::kLsystem)) {
    builders.push_back(&dynamic_cast<const LsystemBuilder&>(*builder));
  }
  return builders;
}

const LsystemBuilder& shipped(const std::string& name) {
  return dynamic_cast<const LsystemBuilder&>(
      test::shipped_builders().named(BuilderKind::kLsystem, name));
}

Morphology sized(double dbh_cm, double h_m, double hcb_m, double cw_m) {
  return {.plot = "1", .tree = "1", .dbh_cm = dbh_cm, .h_m = h_m, .hcb_m = hcb_m, .cw_m = cw_m};
}

/// A folder of models with one preset of a grammar.
class Models {
 public:
  Models() : path_(fs::temp_directory_path() / "silvafit-lsystem-test") {
    fs::remove_all(path_);
    fs::create_directories(path_ / "lsystems");
    fs::create_directories(path_ / "grammars");
    for (const char* folder : {"taper", "shoots", "bark"}) {
      fs::copy(test::source_file("models") / folder, path_ / folder);
    }
    fs::copy_file(test::source_file("models/grammars/maple.lsys"), path_ / "grammars/maple.lsys");
  }
  Models(const Models&) = delete;
  Models& operator=(const Models&) = delete;
  ~Models() { fs::remove_all(path_); }

  /// The column that the error names, or "accepted".
  std::string refused(const std::string& text) const {
    const fs::path file = path_ / "lsystems" / "maple.json";
    write_file(file, text);
    try {
      LsystemBuilder::load(path_, file);
    } catch (const InputError& error) {
      const std::string path = test::path_of(error);
      return path.empty() ? error.what() : path;
    }
    return "accepted";
  }

 private:
  fs::path path_;
};

}  // namespace

TEST_CASE("the trees of the paper's figure 7 have its table's parameters") {
  // Shi, Cheng and Zhang, table 1: r1, r2, a0, a2, d, wr, n.
  const std::map<std::string, std::array<double, 7>> table{
      {"honda-7a", {0.80, 0.67, 45, 54, 62, 0.45, 7}},
      {"honda-7b", {0.45, 0.38, 90, 45, 95, 0.35, 5}},
      {"honda-7c", {0.90, 0.40, 57, 50, 75, 0.65, 6}},
      {"honda-7d", {0.55, 0.60, 80, 65, 87, 0.45, 9}}};
  for (const auto& [name, row] : table) {
    INFO(name);
    const LsystemBuilder& builder = shipped(name);
    REQUIRE(builder.preset().stages.size() == 1);
    const Grammar& grammar = builder.preset().stages.front().grammar;
    const std::array<const char*, 7> names{"r1", "r2", "a0", "a2", "d", "wr", "n"};
    for (std::size_t i = 0; i < names.size(); ++i) {
      CHECK(grammar.constants().at(names[i]) == row[i]);
    }
    const int n = grammar.iterations();
    CHECK(n == row[6]);
    // 2^n - 1 segments in 2^(n-1) axes, whose heights sum up the geometric series.
    Random random(1);
    const Skeleton tree = builder.grow_freely(10.0, random);
    const std::size_t axes = 1U << static_cast<unsigned>(n - 1);
    CHECK(tree.axes.size() == axes);
    CHECK(tree.points.size() == 2 * axes - 1 + axes);
    const double r1 = row[0];
    CHECK(tree.points_of(tree.axes[0]).back().at.z ==
          Approx((1 - std::pow(r1, n)) / (1 - r1)).epsilon(1e-12));
    // The first branch's first segment.
    const auto branch = tree.points_of(tree.axes[1]);
    CHECK(length(branch[1].at - branch[0].at) == Approx(row[1]).epsilon(1e-12));
    CHECK(branch[1].at.z - branch[0].at.z ==
          Approx(row[1] * std::cos(row[2] * std::numbers::pi / 180.0)).margin(1e-12));
  }
}

TEST_CASE("a listed species gets its grammar") {
  const BuilderCatalogue& catalogue = test::shipped_builders();
  const auto name_for = [&](const char* species) {
    return catalogue.choose(BuilderKind::kLsystem, species).builder->name();
  };
  CHECK(name_for("Acer platanoides") == "maple");
  CHECK(name_for("Ficus microcarpa") == "banyan");
  CHECK(name_for("Corylus avellana") == "shrub");
  CHECK(name_for("Abies alba") == "fir");
  CHECK(name_for("Cunninghamia lanceolata") == "fir");
  CHECK(name_for("anything else") == "maple");
  std::set<std::string> all;
  for (const LsystemBuilder* builder : shipped()) {
    for (const std::string& name : builder->preset().species) CHECK(all.insert(name).second);
  }
}

TEST_CASE("freely grown trees have a stem to the top and a plausible number of leaves") {
  for (const LsystemBuilder* builder : shipped()) {
    for (const double h : {2.0, 8.0, 25.0}) {
      for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        INFO(builder->name() << " h " << h << " seed " << seed);
        Random random(seed);
        const Skeleton tree = builder->grow_freely(h, random);
        double top = 0.0;
        for (const SkeletonPoint& point : tree.points) top = std::max(top, point.at.z);
        const auto stem = tree.points_of(tree.axes.front());
        CHECK(tree.axes.front().order == 0);
        CHECK(stem.front().at.z == 0.0);
        CHECK(stem.back().at.z > 0.7 * top);
        CHECK(tree.axes.size() > 10);
        if (builder->name().starts_with("honda")) {
          CHECK(tree.leaves.empty());
        } else {
          CHECK(tree.leaves.size() >= 200);
          CHECK(tree.leaves.size() <= 5000);
        }
        for (std::size_t i = 1; i < tree.axes.size(); ++i) {
          REQUIRE(tree.axes[i].parent < i);
          REQUIRE(tree.axes[i].order == tree.axes[tree.axes[i].parent].order + 1);
        }
        for (const LeafSite& leaf : tree.leaves) {
          REQUIRE(leaf.axis < tree.axes.size());
          REQUIRE(length(leaf.along) == Approx(1).margin(1e-12));
          REQUIRE(length(leaf.facing) == Approx(1).margin(1e-12));
          REQUIRE(std::abs(dot(leaf.along, leaf.facing)) < 1e-12);
        }
      }
    }
  }
}

TEST_CASE("a shrub has several stems from the ground") {
  Random random(3);
  const Skeleton shrub = shipped("shrub").grow_freely(3.0, random);
  const auto from_ground = std::count_if(shrub.axes.begin(), shrub.axes.end(), [&](const Axis& a) {
    return shrub.points_of(a).front().at.z == 0.0;
  });
  CHECK(from_ground == 6);
}

TEST_CASE("a banyan's aerial roots hang below its limbs, and some stand on the ground") {
  const Morphology tree = sized(60, 14, 4, 16);
  const LsystemBuilder& banyan = shipped("banyan");
  const Crown crown(banyan.shape_of(tree), banyan.preset().crown_index);
  for (int level = 0; level < kLevelsOfDetail; ++level) {
    INFO("level " << level);
    const SceneTree grown =
        grow_tree(tree, banyan, {.mesh = level_of_detail(level, {.textured = true})});
    // The props are lower than the crown base, and as thick as they like at 1.3 m.
    test::check_mesh_measurements(tree, grown);
    const MeshPart& roots = grown.mesh.parts.back();
    REQUIRE(roots.kind == PartKind::kAerialRoots);
    CHECK(test::open_edges(roots) == 0);
    CHECK(test::volume_m3(roots) > 0.0);
    std::set<std::pair<int, int>> feet;
    for (std::size_t v = 0; v < roots.vertex_count(); ++v) {
      const Point at = test::vertex_of(roots, v);
      REQUIRE(at.z >= 0.0);
      REQUIRE(at.z < tree.h_m);
      // Half a meter beside the limb at most: the bow of a prop, and its foot.
      REQUIRE(std::hypot(at.x, at.y) < 8.5);
      if (at.z == 0.0) feet.insert({static_cast<int>(at.x), static_cast<int>(at.y)});
    }
    CHECK(feet.size() >= 5);
  }
}

TEST_CASE("the mesh of any valid tree of any grammar has its measurements") {
  constexpr int kTrees = 40;
  Random random(31);
  for (const LsystemBuilder* builder : shipped()) {
    for (int i = 0; i < kTrees; ++i) {
      const Morphology tree = test::random_morphology(random, i);
      const int level = i % kLevelsOfDetail;
      const SceneTree grown = grow_tree(tree, *builder, {.mesh = level_of_detail(level)});
      test::check_mesh_measurements(tree, grown);
      for (const MeshPart& part : grown.mesh.parts) {
        REQUIRE(test::least_doubled_area(part) > 0.0);
        if (part.kind != PartKind::kFoliage) REQUIRE(test::open_edges(part) == 0);
      }
    }
  }
}

TEST_CASE("meshes of extreme but valid trees of grammars have their measurements") {
  for (const LsystemBuilder* builder : shipped()) {
    for (const Morphology& extreme : {sized(0.1, 1.3 + 1e-9, 0, 0.1),
                                      sized(50, 1.31, 1.305, 3),
                                      sized(1, 1.5, 1.499, 12),
                                      sized(1900, 140, 0, 100),
                                      sized(80, 10, 9.99, 0.02),
                                      sized(10, 4, 0, 20)}) {
      test::check_mesh_measurements(extreme, grow_tree(extreme, *builder));
    }
  }
}

TEST_CASE("a tree of a grammar depends on the seed, not on order and threads") {
  Random random(32);
  std::vector<Morphology> trees;
  trees.reserve(12);
  for (int i = 0; i < 12; ++i) trees.push_back(test::random_morphology(random, i));
  // A new catalogue: deterministic grammars are derived by the first thread that needs them.
  const BuilderCatalogue catalogue = BuilderCatalogue::load(test::source_file("models"));
  for (const char* name : {"honda-7d", "shrub"}) {
    const Builder& builder = catalogue.named(BuilderKind::kLsystem, name);
    std::vector<SceneTree> parallel(trees.size());
    parallel_for(
        trees.size(), 4, [&](std::size_t i) { parallel[i] = grow_tree(trees[i], builder); });
    for (std::size_t i = trees.size(); i-- > 0;) {
      const SceneTree alone = grow_tree(trees[i], builder);
      REQUIRE(alone.mesh.parts.size() == parallel[i].mesh.parts.size());
      for (std::size_t p = 0; p < alone.mesh.parts.size(); ++p) {
        CHECK(alone.mesh.parts[p].positions == parallel[i].mesh.parts[p].positions);
        CHECK(alone.mesh.parts[p].indices == parallel[i].mesh.parts[p].indices);
      }
    }
    const SceneTree other = grow_tree(trees[0], builder, {.seed = 2});
    CHECK(other.mesh.parts[1].positions != parallel[0].mesh.parts[1].positions);
  }
}

TEST_CASE("a user's grammar grows with the appearance of a preset") {
  const Grammar own = Grammar::parse(
      "iterations: 5\naxiom: A(1)\nA(l) -> F(l)[&(60)F(l)~L(0.3, 9)]/(137.5)A(l*0.8)", "own.lsys");
  const auto builder = shipped("maple").with_grammar(own);
  CHECK(builder->name() == "maple");
  const Morphology tree = sized(20, 12, 3, 5);
  const SceneTree grown = grow_tree(tree, *builder);
  test::check_mesh_measurements(tree, grown);
  Random random(1);
  const Skeleton free = builder->grow_freely(12.0, random);
  CHECK(free.axes.size() == 6);
  CHECK(free.leaves.size() == 5);
  // The preset has one kind of leaves; grades beyond it are drawn as the last one.
  CHECK(free.leaves.front().grade == 0);
  const auto empty = shipped("maple").with_grammar(Grammar::parse("axiom: A", "own.lsys"));
  CHECK_THROWS_AS(grow_tree(tree, *empty), InputError);
  const auto stem = shipped("maple").with_grammar(Grammar::parse("axiom: F", "own.lsys"));
  CHECK_THROWS_AS(grow_tree(tree, *stem), GeometryError);
}

TEST_CASE("errors of a grammar's drawing name its file, not the measurements") {
  const auto builder = shipped("maple").with_grammar(Grammar::parse("axiom: F(10)\n", "pole.lsys"));
  try {
    grow_tree(sized(20, 15, 5, 4), *builder);
    FAIL("a pole has no branch");
  } catch (const GeometryError& error) {
    CHECK(error.place().file == "pole.lsys");
    CHECK(error.place().tree == "1");
  }
}

TEST_CASE("a preset of a grammar with an invalid field is refused with file and field") {
  const Models models;
  const std::string good = read_file(test::source_file("models/lsystems/maple.json"));
  const auto with = [&](const std::string& find, const std::string& replacement) {
    std::string text = good;
    REQUIRE(text.find(find) != std::string::npos);
    return models.refused(text.replace(text.find(find), find.size(), replacement));
  };
  CHECK(models.refused(good) == "accepted");
  CHECK(with("\"grammar\"", "\"gramar\"") == "gramar");
  CHECK(with("\"constants\": {}", "\"constants\": { \"unknown\": 1 }") == "by_height[0].constants");
  CHECK(with("\"constants\": {}", "\"constants\": 1") == "constants");
  CHECK(with("\"from_m\": 4", "\"from_m\": -1") == "by_height[1].from_m");
  CHECK(with("\"from_m\": 0", "\"from_m\": 1") == "by_height[0].from_m");
  CHECK(with("\"from_m\": 4", "\"above\": 6") == "by_height[1].above");
  CHECK(with("five-polygons", "six-polygons") == "leaves[0].form");
  CHECK(with("[0.3, -0.05]", "[0, -0.05]") == "leaves[0].outline");
  CHECK(with("\"aspect\": 1.1", "\"aspect\": 0") == "leaves[0].aspect");
  CHECK(with("\"leaves\": [", "\"bud\": 1, \"leaves\": [") == "bud");
  CHECK(with("\"leaves\": [", "\"bud\": 0, \"leaves\": [") == "accepted");
  CHECK(with("silvafit-lsystem/1", "silvafit-lsystem/2") == "schema");
  CHECK(with("\"basis\"", "\"basics\"") == "basics");
  CHECK(with("\"grammar\": \"maple\"", "\"grammar\": \"oak\"").find("oak.lsys") !=
        std::string::npos);
}
