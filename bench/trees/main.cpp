// SPDX-License-Identifier: MIT
// Trees and triangles a second of CPU time on one thread, from the measurements to the measured
// mesh, by preset and level of detail.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "measurement.hpp"
#include "silvafit/base/random.hpp"
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
              const tree::Preset& preset,
              const tree::GrowOptions& options) {
  Size size;
  for (const tree::Morphology& morphology : stand) {
    const tree::SceneTree grown = tree::grow_tree(morphology, preset, options);
    size.triangles += grown.measured.triangles;
    size.bytes += tree::glb_mesh_bytes(grown.mesh);
  }
  return size;
}

json time_preset(const std::vector<tree::Morphology>& stand,
                 const tree::Preset& preset,
                 int level,
                 int repeats) {
  const tree::GrowOptions options{.mesh = tree::level_of_detail(level)};
  Size size;
  const double seconds =
      bench::median_cpu_seconds(repeats, [&] { size = grow_all(stand, preset, options); });
  std::string name = "silvafit " + preset.name;
  if (level > 0) name += ", level " + std::to_string(level);
  return {{"name", name},
          {"seconds", seconds},
          {"trees", stand.size()},
          {"triangles", size.triangles},
          {"bytes", size.bytes}};
}

}  // namespace

int main(int argc, char** argv) {
  std::string out;
  int trees = 1000;
  int repeats = 5;
  CLI::App app("Trees a second of CPU time, by preset and level of detail");
  app.add_option("--out", out, "JSON file (default: standard output)");
  app.add_option("--trees", trees, "Trees of the stand")->capture_default_str();
  app.add_option("--repeats", repeats, "Runs, of which the median counts")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    const auto catalogue = tree::PresetCatalogue::load(SILVAFIT_SOURCE_DIR "/models");
    const std::vector<tree::Morphology> stand = stand_of(trees);
    json results = json::array();
    for (const tree::Preset& preset : catalogue.presets()) {
      for (int level = 0; level < tree::kLevelsOfDetail; ++level) {
        results.push_back(time_preset(stand, preset, level, repeats));
      }
    }
    bench::write_json({{"machine", bench::machine()}, {"results", std::move(results)}}, out);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
