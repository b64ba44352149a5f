// SPDX-License-Identifier: MIT
#include "silvafit/stand/window.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "scratch_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"

using namespace silvafit::stand;
using Catch::Matchers::Contains;
using silvafit::test::ScratchFile;

namespace {

/// The window of the paper: a rectangle of 300 x 200 m without two corners.
Polygon paper_window() {
  return {.outer = {
              {100, 0}, {200, 0}, {200, 50}, {300, 50}, {300, 200}, {0, 200}, {0, 50}, {100, 50}}};
}

std::vector<NamedWindow> read_text(const std::string& text) {
  return read_windows(ScratchFile(text, ".geojson").path());
}

std::string polygon(const std::string& rings) {
  return R"({"type": "Polygon", "coordinates": )" + rings + "}";
}

std::string feature(const std::string& geometry, const std::string& plot) {
  return R"({"type": "Feature", "properties": {"plot": )" + plot + R"(}, "geometry": )" + geometry +
         "}";
}

}  // namespace

TEST_CASE("a concave window knows inside, boundary and distance") {
  const Window window({paper_window()});
  CHECK(window.area_m2() == 50000.0);
  CHECK(window.contains({150, 10}));
  CHECK_FALSE(window.contains({50, 25}));
  CHECK_FALSE(window.contains({250, 49.9}));
  CHECK_FALSE(window.contains({-1, 100}));
  CHECK(window.contains({100, 50}));
  CHECK(window.contains({300, 125}));
  CHECK(window.distance_to_boundary_m({150, 10}) == 10.0);
  CHECK(window.distance_to_boundary_m({250, 195}) == 5.0);
  // Beside an inner corner the boundary is a circle around it.
  CHECK(window.distance_to_boundary_m({103, 54}) == 5.0);
  CHECK(window.distance_to_boundary_m({97, 54}) == 4.0);
  CHECK(window.distance_to_boundary_m({50, 20}) == 30.0);
  CHECK(window.low().x == 0.0);
  CHECK(window.high().y == 200.0);
}

TEST_CASE("holes have a boundary too, and rings may run either way") {
  const Window window({{.outer = {{0, 0}, {0, 20}, {20, 20}, {20, 0}},
                        .holes = {{{5, 5}, {15, 5}, {15, 15}, {5, 15}}}}});
  CHECK(window.area_m2() == 300.0);
  CHECK_FALSE(window.contains({10, 10}));
  CHECK(window.contains({3, 10}));
  CHECK(window.distance_to_boundary_m({3, 10}) == 2.0);
  CHECK(window.distance_to_boundary_m({10, 11}) == 4.0);
}

TEST_CASE("polygons side by side are one window without a boundary between them") {
  const Window window({{.outer = {{0, 0}, {10, 0}, {10, 10}, {0, 10}}},
                       {.outer = {{10, 0}, {20, 0}, {20, 10}, {10, 10}}}});
  CHECK(window.area_m2() == 200.0);
  CHECK(window.distance_to_boundary_m({10, 4}) == 4.0);
}

TEST_CASE("a polygon of many corners agrees with the circle that it stands for") {
  Polygon circle;
  constexpr int kCorners = 5000;
  constexpr double kRadius = 50.0;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2.0 * M_PI * i / kCorners;
    circle.outer.push_back({kRadius * std::cos(angle), kRadius * std::sin(angle)});
  }
  const Window window({circle});
  silvafit::Random random(3);
  // The sagitta of an edge is the most that the polygon lies inside the circle.
  const double sagitta = kRadius * (1.0 - std::cos(M_PI / kCorners));
  for (int i = 0; i < 2000; ++i) {
    const Point point{random.uniform(-60, 60), random.uniform(-60, 60)};
    const double from_center = std::hypot(point.x, point.y);
    if (std::abs(from_center - kRadius) < 2.0 * sagitta) continue;
    CHECK(window.contains(point) == (from_center < kRadius));
    CHECK(window.distance_to_boundary_m(point) ==
          Approx(std::abs(kRadius - from_center)).margin(2.0 * sagitta));
  }
}

TEST_CASE("polygons that are none are refused with what is wrong") {
  using Ring = std::vector<Point>;
  const auto refuse =
      [](const Ring& outer, const std::vector<Ring>& holes, const std::string& why) {
        CHECK_THROWS_AS(Window({{.outer = outer, .holes = holes}}), silvafit::GeometryError);
        CHECK_THROWS_WITH(Window({{.outer = outer, .holes = holes}}), Contains(why));
      };
  const Ring square{{0, 0}, {10, 0}, {10, 10}, {0, 10}};
  refuse({{0, 0}, {10, 10}, {10, 0}, {0, 10}}, {}, "crosses or touches itself");
  refuse({{0, 0}, {10, 0}}, {}, "fewer than three different corners");
  refuse({{0, 0}, {5, 0}, {10, 0}}, {}, "polygon");
  refuse(square, {{{20, 20}, {25, 20}, {25, 25}}}, "a hole lies outside");
  refuse({{0, 0}, {NAN, 0}, {10, 10}}, {}, "not finite");
  CHECK_THROWS_AS(Window(std::vector<Polygon>{}), silvafit::GeometryError);
}

TEST_CASE("GeoJSON windows are read as feature, collection or bare geometry") {
  const std::string square = polygon("[[[0,0],[10,0],[10,10],[0,10],[0,0]]]");
  const auto bare = read_text(square);
  REQUIRE(bare.size() == 1);
  CHECK_FALSE(bare[0].plot.has_value());
  CHECK(bare[0].window.area_m2() == 100.0);

  const std::string two = R"({"type": "MultiPolygon", "coordinates":
    [[[[20,0],[30,0],[30,10],[20,10],[20,0]], [[24,4],[26,4],[26,6],[24,6],[24,4]]],
     [[[40,0],[50,0],[50,10,7],[40,0]]]]})";
  const auto several =
      read_text(R"({"type": "FeatureCollection", "features": [)" + feature(square, "\"07\"") + "," +
                feature(two, "8") + "," +
                feature(polygon("[[[10,0],[20,0],[20,10],[10,10]]]"), "\"07\"") + "]}");
  REQUIRE(several.size() == 2);
  CHECK(several[0].plot == "07");
  CHECK(several[0].window.area_m2() == 200.0);
  CHECK(several[1].plot == "8");
  CHECK(several[1].window.area_m2() == 146.0);
}

TEST_CASE("what is no window is refused with the feature that is wrong") {
  CHECK_THROWS_WITH(read_text("{\n\"type\": \n"), Contains("is no JSON from here on"));
  CHECK_THROWS_WITH(read_text("[]"), Contains("a Polygon or MultiPolygon is needed"));
  CHECK_THROWS_WITH(read_text(R"({"type": "Point", "coordinates": [1, 2]})"),
                    Contains("not a Point"));
  CHECK_THROWS_WITH(read_text(R"({"type": "FeatureCollection", "features": []})"),
                    Contains("no window in this file"));
  CHECK_THROWS_WITH(read_text(R"({"type": "Feature", "geometry": null})"), Contains("feature 1"));
  CHECK_THROWS_WITH(read_text(polygon("[[[0,0],[\"a\",0],[1,1]]]")), Contains("[x, y] in metres"));
  const std::string bow = polygon("[[[0,0],[10,10],[10,0],[0,10],[0,0]]]");
  CHECK_THROWS_AS(read_text(bow), silvafit::InputError);
  CHECK_THROWS_WITH(
      read_text(R"({"type": "FeatureCollection", "features": [)" +
                feature(polygon("[[[0,0],[1,0],[1,1]]]"), "1") + "," + feature(bow, "2") + "]}"),
      Contains("feature 2: not a valid polygon: the boundary crosses"));
  CHECK_THROWS_WITH(read_windows("/no/such/window.geojson"), Contains("/no/such/window.geojson"));
}
