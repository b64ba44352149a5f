// SPDX-License-Identifier: MIT
// Trees and triangles a second of CPU time on one thread, from the measurements to the measured
// mesh: the presets of all builders with pictures, as `grow` draws them, and plain; those of
// segments also by level of detail.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "measurement.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/scene.hpp"

namespace {

using namespace silvafit;
using nlohmann::json;

/// Trees of a young stand: 8 to 20 m high, crowns half as long and a quarter as wide, each radius
/// its own.
std::vector<tree::Morphology> stand_of(int trees) {
  Random random(1);
  std::vector<tree::Morphology> stand;
  for (int i = 0; i < trees; ++i) {
    const double h = random.uniform(8.0, 20.0);
    const auto radius = [&] { return 0.125 * h * random.uniform(0.7, 1.3); };
    stand.push_back({.plot = "bench",
                     .tree = std::to_string(i),
                     .dbh_cm = h * random.uniform(1.0, 1.6),
                     .h_m = h,
                     .hcb_m = h * random.uniform(0.3, 0.6),
                     .radii = tree::CrownRadii{radius(), radius(), radius(), radius()}});
  }
  return stand;
}

struct Size {
  std::size_t triangles = 0;
  std::size_t bytes = 0;
};

Size grow_all(const std::vector<tree::Morphology>& stand,
              const tree::Builder& builder,
              const tree::GrowOptions& options) {
  Size size;
  for (const tree::Morphology& morphology : stand) {
    const tree::SceneTree grown = tree::grow_tree(morphology, builder, options);
    size.triangles += grown.measured.triangles;
    size.bytes += tree::glb_mesh_bytes(grown.mesh);
  }
  return size;
}

json time_preset(const std::vector<tree::Morphology>& stand,
                 const tree::Builder& builder,
                 const std::string& look,
                 const tree::MeshOptions& mesh,
                 int repeats) {
  Size size;
  const double seconds =
      bench::median_cpu_seconds(repeats, [&] { size = grow_all(stand, builder, {.mesh = mesh}); });
  return {{"name", "silvafit " + builder.name() + look},
          {"seconds", seconds},
          {"trees", stand.size()},
          {"triangles", size.triangles},
          {"bytes", size.bytes}};
}

}  // namespace

int main(int argc, char** argv) {
  std::string out;
  std::string only;
  int trees = 1000;
  int repeats = 5;
  CLI::App app("Trees a second of CPU time, by preset and level of detail");
  app.add_option("--out", out, "JSON file (default: standard output)");
  app.add_option("--preset", only, "Only presets of this name (default: all)");
  app.add_option("--trees", trees, "Trees of the stand")->capture_default_str();
  app.add_option("--repeats", repeats, "Runs, of which the median counts")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    const auto catalogue = tree::BuilderCatalogue::load(SILVAFIT_SOURCE_DIR "/models");
    const std::vector<tree::Morphology> stand = stand_of(trees);
    json results = json::array();
    for (const tree::BuilderKind kind : all_values<tree::BuilderKind>()) {
      for (const tree::Builder* builder : catalogue.of(kind)) {
        if (!only.empty() && builder->name() != only) continue;
        results.push_back(time_preset(stand, *builder, "", {.textured = true}, repeats));
        results.push_back(time_preset(stand, *builder, ", plain", {}, repeats));
        if (kind != tree::BuilderKind::kSegment) continue;
        for (int level = 1; level < tree::kLevelsOfDetail; ++level) {
          const std::string look = ", level " + std::to_string(level);
          const tree::MeshOptions base{.textured = true};
          results.push_back(
              time_preset(stand, *builder, look, tree::level_of_detail(level, base), repeats));
        }
      }
    }
    bench::write_json({{"machine", bench::machine()}, {"results", std::move(results)}}, out);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
