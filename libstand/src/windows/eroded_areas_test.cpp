// SPDX-License-Identifier: MIT
// Areas less a margin: parabolas between margins against each margin's own area.
#include "windows/eroded_areas.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>

#include "silvafit/base/random.hpp"

using namespace silvafit::stand;

namespace {

/// The largest margin that leaves an area.
double inradius_m(const Window& window) {
  double low = 0.0;
  double high = window.high().y - window.low().y;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2.0;
    (window.eroded_area_m2(middle) > 0.0 ? low : high) = middle;
  }
  return low;
}

/// Strips between teeth of different widths, which vanish one after another.
Polygon comb() {
  Polygon polygon{.outer = {{0, 0}, {200, 0}}};
  for (int i = 9; i >= 0; --i) {
    const double right = 20.0 * i + 6.0 + i;
    polygon.outer.push_back({right, 10.0});
    polygon.outer.push_back({right, 60.0});
    polygon.outer.push_back({20.0 * i, 60.0});
    polygon.outer.push_back({20.0 * i, i == 0 ? 30.0 : 10.0});
  }
  return polygon;
}

/// A digitized outline: a corner every few meters.
Polygon drawn(std::uint64_t seed, int corners) {
  silvafit::Random random(seed);
  Polygon polygon;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * M_PI * i / corners;
    const double radius = random.uniform(40, 60);
    polygon.outer.push_back({5e5 + radius * std::cos(angle), 6e6 + radius * std::sin(angle)});
  }
  return polygon;
}

/// Two squares on a strip that is a little narrower: it vanishes just before they do.
Polygon lobes() {
  return {.outer = {{0, 0},
                    {500, 0},
                    {500, 20.4},
                    {479.6, 20.4},
                    {479.6, 20},
                    {20.8, 20},
                    {20.8, 20.8},
                    {0, 20.8}}};
}

/// Area of a square of side s less a margin of more than 10 m, open to a strip 20 m high: what lies
/// beyond the circle around the inner corner (s, 20) is lost.
double lobe_area_m2(double side_m, double margin_m) {
  const auto integral = [margin_m](double u) {
    return (u * std::sqrt(margin_m * margin_m - u * u) +
            margin_m * margin_m * std::asin(u / margin_m)) /
           2.0;
  };
  const double width = side_m - margin_m;
  const double height = side_m - 2.0 * margin_m;
  return width * height - (integral(20.0 - margin_m) - integral(20.0 - side_m + margin_m));
}

}  // namespace

TEST_CASE("areas of many margins equal those of single margins, also where they are small") {
  const std::vector<std::pair<const char*, Window>> windows{
      {"rectangle", Window::rectangle({0, 0}, {30, 20})},
      {"circle", Window::circle({0, 0}, 12.62)},
      {"lobes", Window({lobes()})},
      {"comb", Window({comb()})},
      {"with a hole",
       Window({{.outer = {{0, 0}, {60, 0}, {60, 40}, {35, 40}, {35, 22}, {0, 35}},
                .holes = {{{12, 8}, {12, 16}, {20, 16}, {20, 8}}}}})},
      {"drawn", Window({drawn(4, 30)})},
      {"drawn finely", Window({drawn(5, 120)})}};
  for (const auto& [name, window] : windows) {
    INFO(name);
    const double most = inradius_m(window);
    silvafit::Random random(6);
    std::vector<double> margins;
    margins.reserve(600);
    for (int i = 0; i < 400; ++i) margins.push_back(random.uniform(0, most));
    // Near the largest margin, where the area is small, and equal margins.
    for (int i = 0; i < 100; ++i) margins.push_back(most * (1.0 - random.uniform(0, 1e-3)));
    for (int i = 0; i < 100; ++i) margins.push_back(most / 2.0);
    const std::vector<double> areas = eroded_areas_m2(window, margins);
    double worst = 0.0;
    for (std::size_t i = 0; i < margins.size(); ++i) {
      const double own = window.eroded_area_m2(margins[i]);
      worst = std::max(worst, own > 0.0 ? std::abs(areas[i] / own - 1.0) : areas[i]);
    }
    // The accuracy that docs/structural-units.md states.
    CHECK(worst < 1e-4);
  }
}

TEST_CASE("after a strip has vanished the areas of the lobes are those of theory") {
  std::vector<double> margins{10.03, 10.1, 10.3};
  for (int i = 0; i < 2500; ++i) margins.push_back(0.5 + 2.0 * i / 2500.0);
  margins.push_back(9.99);
  const std::vector<double> areas = eroded_areas_m2(Window({lobes()}), margins);
  // Beyond 10.2 m the smaller lobe is gone. The arcs' corners are 5e-5 of an arc's area off.
  CHECK(areas[0] == Approx(lobe_area_m2(20.8, 10.03) + lobe_area_m2(20.4, 10.03)).epsilon(2e-4));
  CHECK(areas[1] == Approx(lobe_area_m2(20.8, 10.1) + lobe_area_m2(20.4, 10.1)).epsilon(2e-4));
  CHECK(areas[2] == Approx(lobe_area_m2(20.8, 10.3)).epsilon(2e-4));
}

TEST_CASE("a million margins need a few hundred areas", "[slow]") {
  // A hull as of a large stand: short edges, many of which vanish. One area takes some 0.1 ms.
  silvafit::Random random(7);
  std::vector<Point> points;
  points.reserve(100000);
  for (int i = 0; i < 100000; ++i)
    points.push_back({random.uniform(0, 500), random.uniform(0, 500)});
  const Window window = *Window::convex_hull(points);
  std::vector<double> margins;
  margins.reserve(1000000);
  for (int i = 0; i < 1000000; ++i) margins.push_back(random.uniform(0, 1) * random.uniform(0, 9));
  const auto start = std::chrono::steady_clock::now();
  const std::vector<double> areas = eroded_areas_m2(window, margins);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  CHECK(elapsed.count() < 20.0);
  for (std::size_t i = 0; i < margins.size(); i += 10007) {
    CHECK(areas[i] == Approx(window.eroded_area_m2(margins[i])).epsilon(1e-4));
  }
  CHECK(eroded_areas_m2(window, {}).empty());
}
