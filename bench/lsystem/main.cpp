// SPDX-License-Identifier: MIT
// The comparison of Shi, Cheng and Zhang's table 2: trees of grammars as smooth meshes beside
// finely subdivided meshes of the same skeletons. Bytes are those of a plain GLB, seconds CPU time
// on one thread, distances those between the surfaces of stem and branches in both directions.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "measurement.hpp"
#include "mesh/smooth_mesh_limbs.hpp"
#include "mesh/smooth_mesh_rings.hpp"
#include "mesh/tube.hpp"
#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/lsystem_builder.hpp"
#include "silvafit/tree/scene.hpp"
#include "silvafit/tree/smooth_mesh.hpp"
#include "surface_distance.hpp"

namespace {

using namespace silvafit;
using nlohmann::json;

using tree::kAllOrders;
constexpr double kSpacing = 0.02;  // of places where distances are taken [m]

struct Subject {
  std::string preset{};
  tree::Morphology morphology{};
};

std::vector<Subject> subjects() {
  const auto tree = [](const char* preset, double h, double dbh, double hcb, double cw) {
    return Subject{
        preset,
        {.plot = "bench", .tree = preset, .dbh_cm = dbh, .h_m = h, .hcb_m = hcb, .cw_m = cw}};
  };
  return {tree("maple", 12, 26, 3, 8),
          tree("banyan", 15, 90, 3, 18),
          tree("shrub", 3, 4, 0.3, 3),
          tree("fir", 18, 28, 3, 6),
          tree("honda-7a", 10, 18, 3, 6),
          tree("honda-7b", 10, 18, 3, 6),
          tree("honda-7c", 10, 18, 3, 6),
          tree("honda-7d", 10, 18, 3, 6)};
}

/// How the finely subdivided mesh is made.
struct Fine {
  int sides = 32;
  double step_m = 0.01;
  int outline_points = 24;  ///< of each side of a leaf
  int needles = 24;         ///< of each spray, every one a leaf of its own
};

/// A curve through a leaf's outline (Catmull and Rom's) in many points.
std::vector<std::array<double, 2>> fine_outline(std::vector<std::array<double, 2>> outline,
                                                int points) {
  if (outline.empty()) outline = {{0.72, 0.14}, {1.0, 0.42}, {0.62, 0.76}};
  outline.insert(outline.begin(), {0.0, 0.0});
  outline.push_back({0.0, 1.0});
  const auto last = static_cast<int>(outline.size()) - 1;
  std::vector<std::array<double, 2>> fine;
  for (int i = 1; i <= points; ++i) {
    const double at = static_cast<double>(i) / (points + 1) * last;
    const int k = std::min(static_cast<int>(at), last - 1);
    const double t = at - k;
    const auto p = [&](int j) { return outline[static_cast<std::size_t>(std::clamp(j, 0, last))]; };
    std::array<double, 2> place{};
    for (std::size_t d = 0; d < 2; ++d) {
      const double a = p(k - 1)[d];
      const double b = p(k)[d];
      const double c = p(k + 1)[d];
      const double e = p(k + 2)[d];
      place[d] =
          b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - e + t * (3 * (b - c) + e - a)));
    }
    fine.push_back(place);
  }
  return fine;
}

/// The same tree with finely drawn leaves: more points of an outline, and needles one by one.
struct FineLeaves {
  tree::Skeleton skeleton{};
  tree::SmoothStyle style{};
};

FineLeaves fine_leaves(const tree::Skeleton& skeleton,
                       const tree::SmoothStyle& style,
                       const Fine& fine) {
  FineLeaves result{skeleton, style};
  for (tree::LeafLook& look : result.style.leaves) {
    if (look.form == tree::LeafForm::kNeedleFan) {
      look.form = tree::LeafForm::kFivePolygons;
      look.aspect = 0.08;
      look.outline.clear();
    } else {
      look.outline = fine_outline(look.outline, fine.outline_points);
    }
  }
  std::vector<tree::LeafSite> leaves;
  for (const tree::LeafSite& site : skeleton.leaves) {
    const tree::LeafLook& look = style.leaves[site.grade];
    if (look.form != tree::LeafForm::kNeedleFan) {
      leaves.push_back(site);
      continue;
    }
    const tree::Point across = cross(site.along, site.facing);
    for (int i = 0; i < fine.needles; ++i) {
      const double side = i % 2 == 0 ? 1.0 : -1.0;
      tree::LeafSite needle = site;
      needle.at = site.at + (0.8 * i / fine.needles * site.length_m) * site.along;
      needle.along = direction(0.5 * site.along + side * across);
      needle.length_m = 0.5 * look.aspect * site.length_m;
      leaves.push_back(needle);
    }
  }
  result.skeleton.leaves = std::move(leaves);
  return result;
}

/// Tubes of many sides around all steps of the curves.
tree::Mesh fine_mesh(const FineLeaves& subject, const tree::Crown& crown, const Fine& fine) {
  const tree::MeshOptions options{.stem_sides = fine.sides,
                                  .branch_sides = fine.sides,
                                  .twig_sides = fine.sides,
                                  .wood_order = kAllOrders};
  Random random(1);
  // The usual leaves with a minimum of wood, which is replaced below.
  constexpr double kCoarse = 10.0;
  tree::Mesh mesh = tree::build_smooth_mesh(subject.skeleton,
                                            crown,
                                            subject.style,
                                            random,
                                            {.stem_sides = 3,
                                             .branch_sides = 3,
                                             .stem_tolerance_m = kCoarse,
                                             .branch_tolerance_m = kCoarse,
                                             .wood_order = 1});
  const tree::Limbs limbs(subject.skeleton);
  const tree::WoodRings rings(limbs, crown, options, fine.step_m);
  const std::vector<tree::Point> corners = tree::equal_area_corners(fine.sides);
  for (tree::MeshPart& part : mesh.parts) {
    if (part.kind == tree::PartKind::kFoliage) continue;
    tree::MeshPart wood{.kind = part.kind, .color = part.color};
    tree::PartBuilder build(wood);
    for (std::size_t i = 0; i < limbs.all().size(); ++i) {
      const bool is_stem = limbs.all()[i].axis == 0;
      if (rings.of(i).size() < 2 || is_stem != (part.kind == tree::PartKind::kStem)) continue;
      tree::add_tube(rings.of(i), corners, {.has_foot = is_stem}, build);
    }
    build.finish();
    part = std::move(wood);
  }
  return mesh;
}

struct Way {
  std::string name{};
  tree::MeshOptions options{};
};

/// From many sides to few; "hexagons" are the sections of the paper, and the finest level of
/// detail.
std::vector<Way> ways() {
  const auto sides = [](int stem, int branch, int twig) {
    return tree::MeshOptions{
        .stem_sides = stem, .branch_sides = branch, .twig_sides = twig, .wood_order = kAllOrders};
  };
  std::vector<Way> result{{"24 sides", sides(24, 24, 24)},
                          {"16 sides", sides(16, 16, 16)},
                          {"12 sides", sides(12, 12, 12)},
                          {"12, 8, 6 sides", sides(12, 8, 6)},
                          {"hexagons and triangles", sides(12, 6, 3)}};
  for (int level = 1; level < tree::kLevelsOfDetail; ++level) {
    tree::MeshOptions options = tree::level_of_detail(level);
    // Leaves and twigs are not compared here.
    options.foliage_per = 1;
    options.wood_order = kAllOrders;
    result.push_back({"level " + std::to_string(level), options});
  }
  return result;
}

json described(const tree::Mesh& mesh, double seconds) {
  std::size_t wood = 0;
  std::size_t wood_bytes = 0;
  for (const tree::MeshPart& part : mesh.parts) {
    if (part.kind == tree::PartKind::kFoliage) continue;
    wood += part.triangle_count();
    wood_bytes += tree::glb_mesh_bytes({.parts = {part}});
  }
  return {{"triangles", mesh.triangle_count()},
          {"wood_triangles", wood},
          {"bytes", tree::glb_mesh_bytes(mesh)},
          {"wood_bytes", wood_bytes},
          {"seconds", seconds}};
}

json compare(const tree::LsystemBuilder& builder,
             const Subject& subject,
             const Fine& fine,
             int repeats) {
  const tree::TreeShape shape = builder.shape_of(subject.morphology);
  const tree::Crown crown(shape, builder.preset().crown_index);
  tree::Skeleton skeleton;
  const double growing = bench::median_cpu_seconds(repeats, [&] {
    Random random(1);
    skeleton = builder.grow_skeleton(shape, crown, random);
  });
  const tree::SmoothStyle& style = builder.preset().style;
  const FineLeaves leaves = fine_leaves(skeleton, style, fine);
  tree::Mesh rough;
  tree::Mesh whole;
  const double fine_seconds =
      bench::median_cpu_seconds(repeats, [&] { whole = fine_mesh(leaves, crown, fine); });
  const std::vector<bench::Triangle> fine_wood = bench::wood_of(whole);
  const bench::NearestSurface fine_surface(fine_wood);
  json result{{"name", subject.preset},
              {"axes", skeleton.axes.size()},
              {"leaves", skeleton.leaves.size()},
              {"skeleton_seconds", growing},
              {"fine", described(whole, fine_seconds)},
              {"smooth", json::array()}};
  for (const Way& way : ways()) {
    const double seconds = bench::median_cpu_seconds(repeats, [&] {
      Random random(1);
      rough = tree::build_smooth_mesh(skeleton, crown, style, random, way.options);
    });
    json row = described(rough, seconds);
    const std::vector<bench::Triangle> wood = bench::wood_of(rough);
    const double there = bench::farthest_m(wood, fine_surface, kSpacing);
    const double back = bench::farthest_m(fine_wood, bench::NearestSurface(wood), kSpacing);
    row["name"] = way.name;
    row["distance_mm"] = 1000.0 * std::max(there, back);
    result["smooth"].push_back(std::move(row));
  }
  return result;
}

void print(const json& result) {
  const json& fine = result["fine"];
  std::printf("\n%s: %d axes, %d leaves; skeleton %.4f s\n",
              result["name"].get<std::string>().c_str(),
              result["axes"].get<int>(),
              result["leaves"].get<int>(),
              result["skeleton_seconds"].get<double>());
  std::printf("%-24s %10s %10s %9s %9s %9s %8s %8s %9s\n",
              "mesh",
              "triangles",
              "of wood",
              "MB",
              "wood MB",
              "seconds",
              "saving",
              "of wood",
              "max. mm");
  const auto line = [&](const std::string& name, const json& row) {
    const auto number = [](const json& of, const char* what) { return of[what].get<double>(); };
    std::printf("%-24s %10.0f %10.0f %9.3f %9.3f %9.4f %8.1f %8.1f %9.2f\n",
                name.c_str(),
                number(row, "triangles"),
                number(row, "wood_triangles"),
                1e-6 * number(row, "bytes"),
                1e-6 * number(row, "wood_bytes"),
                number(row, "seconds"),
                number(fine, "bytes") / number(row, "bytes"),
                number(fine, "wood_bytes") / number(row, "wood_bytes"),
                row.value("distance_mm", 0.0));
  };
  line("finely subdivided", fine);
  for (const json& row : result["smooth"]) line(row["name"], row);
}

}  // namespace

int main(int argc, char** argv) {
  std::string out;
  std::vector<std::string> names;
  int repeats = 3;
  Fine fine;
  CLI::App app("Trees of grammars as smooth meshes beside finely subdivided ones");
  app.add_option("--out", out, "JSON file with all figures");
  app.add_option("--preset", names, "Only these (default: all)");
  app.add_option("--repeats", repeats, "Runs, of which the median counts")->capture_default_str();
  app.add_option("--sides", fine.sides, "Sides of the finely subdivided tubes")
      ->capture_default_str();
  app.add_option("--step", fine.step_m, "Their steps [m]")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  return bench::exit_status([&] {
    const auto catalogue = tree::BuilderCatalogue::load(SILVAFIT_SOURCE_DIR "/models");
    json results = json::array();
    for (const Subject& subject : subjects()) {
      if (!names.empty() && std::find(names.begin(), names.end(), subject.preset) == names.end()) {
        continue;
      }
      const auto& builder = dynamic_cast<const tree::LsystemBuilder&>(
          catalogue.named(tree::BuilderKind::kLsystem, subject.preset));
      results.push_back(compare(builder, subject, fine, repeats));
      print(results.back());
    }
    if (!out.empty()) {
      bench::write_json({{"machine", bench::machine()}, {"results", std::move(results)}}, out);
    }
  });
}
