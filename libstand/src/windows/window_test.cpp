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

std::vector<NamedWindow> read_windows_text(const std::string& text) {
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

TEST_CASE("a concave window has correct inside, boundary and distance") {
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

TEST_CASE("invalid polygons are refused with the reason") {
  using Ring = std::vector<Point>;
  const auto refuse =
      [](const Ring& outer, const std::vector<Ring>& holes, const std::string& why) {
        CHECK_THROWS_AS(Window({{.outer = outer, .holes = holes}}), silvafit::GeometryError);
        CHECK_THROWS_WITH(Window({{.outer = outer, .holes = holes}}), Contains(why));
      };
  const Ring square{{0, 0}, {10, 0}, {10, 10}, {0, 10}};
  refuse({{0, 0}, {10, 10}, {10, 0}, {0, 10}}, {}, "crosses or touches itself");
  refuse({{0, 0}, {10, 0}}, {}, "fewer than three different vertices");
  refuse({{0, 0}, {5, 0}, {10, 0}}, {}, "polygon");
  refuse(square, {{{20, 20}, {25, 20}, {25, 25}}}, "a hole is outside");
  refuse({{0, 0}, {NAN, 0}, {10, 10}}, {}, "not finite");
  CHECK_THROWS_AS(Window(std::vector<Polygon>{}), silvafit::GeometryError);
}

TEST_CASE("a circular plot is a circle") {
  const Window window = Window::circle({100, 50}, 12.5);
  CHECK(window.area_m2() == Approx(M_PI * 156.25).epsilon(1e-15));
  CHECK(window.perimeter_m() == Approx(25.0 * M_PI).epsilon(1e-15));
  CHECK(window.contains({112.5, 50}));
  CHECK_FALSE(window.contains({112.6, 50}));
  CHECK(window.distance_to_boundary_m({100, 50}) == 12.5);
  CHECK(window.distance_to_boundary_m({103, 54}) == 7.5);
  CHECK(window.distance_to_boundary_m({100, 70}) == 7.5);
  CHECK(window.eroded_area_m2(2.5) == Approx(M_PI * 100.0).epsilon(1e-15));
  CHECK(window.eroded_area_m2(13.0) == 0.0);
  CHECK_FALSE(window.is_rectangle());
  CHECK(window.outline().at(0).outer.size() == 120);
  CHECK_THROWS_AS(Window::circle({0, 0}, 0.0), silvafit::GeometryError);
  CHECK_THROWS_AS(Window::circle({0, NAN}, 1.0), silvafit::GeometryError);
}

TEST_CASE("a convex hull contains all its points, and a line has none") {
  silvafit::Random random(5);
  std::vector<Point> points;
  points.reserve(550);
  for (int i = 0; i < 500; ++i) {
    points.push_back({5e5 + random.uniform(0, 30), 6e6 + random.uniform(0, 30)});
  }
  // Points along one side, on which rounding must not decide.
  for (int i = 0; i < 50; ++i) points.push_back({5e5 - 1.0 + 0.3 * i, 6e6 - 1.0 + 0.1 * i});
  const std::optional<Window> hull = Window::convex_hull(points);
  REQUIRE(hull);
  for (const Point& point : points) CHECK(hull->contains(point));
  const std::vector<Point> square{{0, 0}, {2, 0}, {2, 2}, {0, 2}, {1, 1}, {0.5, 1.9}};
  CHECK(Window::convex_hull(square)->area_m2() == 4.0);
  CHECK(Window::convex_hull(square)->is_rectangle());
  CHECK_FALSE(Window::convex_hull(std::vector<Point>{{0, 0}, {1, 1}, {2, 2}, {3, 3}}));
  CHECK_FALSE(Window::convex_hull(std::vector<Point>{{1, 1}, {1, 1}}));
  CHECK_FALSE(Window::convex_hull({}));
}

TEST_CASE("the area less a margin is that of Steiner's formula") {
  const Window rectangle = Window::rectangle({0, 0}, {30, 20});
  CHECK(rectangle.eroded_area_m2(0.0) == 600.0);
  CHECK(rectangle.eroded_area_m2(5.0) == 200.0);
  CHECK(rectangle.eroded_area_m2(10.0) == 0.0);
  // Less a margin r, small enough that no edge vanishes: A - P r + c r^2. A right angle adds 1 to
  // c, an inner corner where the boundary turns by phi takes phi / 2, cot(angle / 2) for others.
  const Window paper({paper_window()});
  const double corners = 6.0 - 2.0 * M_PI / 4.0;
  for (const double r : {0.1, 1.0, 5.0, 12.0}) {
    const double expected = 50000.0 - paper.perimeter_m() * r + corners * r * r;
    // An arc's polygon of 360 corners lacks 5e-5 of pi/2 r^2.
    CHECK(paper.eroded_area_m2(r) == Approx(expected).margin(1e-4 * r * r));
  }
  const Window with_hole({{.outer = {{0, 0}, {60, 0}, {60, 40}, {35, 40}, {35, 22}, {0, 35}},
                           .holes = {{{12, 8}, {12, 16}, {20, 16}, {20, 8}}}}});
  const double sharp = std::acos(13.0 / std::hypot(35.0, 13.0));
  const double c = 4.0 + 1.0 / std::tan(sharp / 2.0) - (M_PI - sharp) / 2.0 - M_PI;
  for (const double r : {0.5, 1.0, 2.0, 3.0}) {
    const double expected = with_hole.area_m2() - with_hole.perimeter_m() * r + c * r * r;
    CHECK(with_hole.eroded_area_m2(r) == Approx(expected).margin(4e-4 * r * r));
  }
}

TEST_CASE("rectangles are recognized at any position, other polygons are not") {
  silvafit::Random random(17);
  for (int i = 0; i < 500; ++i) {
    // Coordinates of a national grid in millimeters, and sides of plots.
    const auto millimeters = [](double meters) { return std::round(meters * 1e3) / 1e3; };
    const Point low{millimeters(random.uniform(2e5, 8e5)), millimeters(random.uniform(1e6, 9e6))};
    const double width = millimeters(random.uniform(5, 100));
    const double height = millimeters(random.uniform(5, 100));
    const Point high{low.x + width, low.y + height};
    const Window window = Window::rectangle(low, high);
    CHECK(window.is_rectangle());
    // Corners are rounded to 2e-9 m, sides of 100 m and less to 4e-9 m.
    CHECK(window.area_m2() == Approx(width * height).margin(100.0 * 4e-9 * 2.0));
    // With a deviation of a tenth of a millimeter it is not a rectangle.
    CHECK_FALSE(
        Window({{.outer = {low, {high.x, low.y + 1e-4}, high, {low.x, high.y}}}}).is_rectangle());
  }
  // Joined plots, with corners along the sides.
  CHECK(Window({{.outer = {{0, 0}, {10, 0}, {10, 10}, {0, 10}}},
                {.outer = {{10, 0}, {20, 0}, {20, 10}, {10, 10}}}})
            .is_rectangle());
  // All corners on the sides of the bounding rectangle, but a corner cut off.
  CHECK_FALSE(Window({{.outer = {{0, 0}, {9, 0}, {10, 1}, {10, 10}, {0, 10}}}}).is_rectangle());
  CHECK_FALSE(Window({{.outer = {{0, 0}, {10, 0}, {0, 10}}}}).is_rectangle());
  CHECK_FALSE(Window({{.outer = {{0, 0}, {10, 0}, {10, 10}, {0, 10}},
                       .holes = {{{4, 4}, {6, 4}, {6, 6}, {4, 6}}}}})
                  .is_rectangle());
  CHECK_FALSE(Window({paper_window()}).is_rectangle());
}

TEST_CASE("a window far from the origin is the window near it") {
  const Polygon near = paper_window();
  // Whole meters, so that the corners are the same to the last digit.
  const Point far{512345.0, 8765432.0};
  Polygon moved = near;
  for (Point& corner : moved.outer) corner = {corner.x + far.x, corner.y + far.y};
  const Window here({near});
  const Window there({moved});
  CHECK(there.area_m2() == 50000.0);
  CHECK(there.perimeter_m() == here.perimeter_m());
  CHECK(there.low().x == far.x);
  CHECK(there.high().y == far.y + 200.0);
  CHECK(there.outline().at(0).outer.at(0).y == here.outline().at(0).outer.at(0).y + far.y);
  for (const double margin : {1.0, 40.0, 49.0, 60.0, 74.9}) {
    CHECK(there.eroded_area_m2(margin) ==
          Approx(here.eroded_area_m2(margin)).epsilon(1e-12).margin(1e-9));
  }
  silvafit::Random random(18);
  for (int i = 0; i < 500; ++i) {
    const Point point{std::round(random.uniform(-10, 310)), std::round(random.uniform(-10, 210))};
    const Point same{point.x + far.x, point.y + far.y};
    CHECK(there.contains(same) == here.contains(point));
    CHECK(there.distance_to_boundary_m(same) == here.distance_to_boundary_m(point));
  }
  // A line, whose points are rounded to 1e-9 m, has no hull there either.
  std::vector<Point> line;
  line.reserve(50);
  for (int i = 0; i < 50; ++i) line.push_back({far.x + 0.1 * i, far.y + 0.3 * i});
  CHECK_FALSE(Window::convex_hull(line));
}

TEST_CASE("a point on the boundary is inside in spite of rounding, at the bounding box too") {
  // Sides at tenths of meters, which have no exact binary value, and points counted in tenths.
  Polygon many{.outer = {{0, 0}, {20.2, 0}, {20.2, 20.2}}};
  for (int i = 99; i > 0; --i) many.outer.push_back({0.202 * i, 20.2});
  many.outer.push_back({0, 20.2});
  for (const Window& window : {Window::rectangle({0, 0}, {20.2, 20.2}), Window({many})}) {
    for (int i = 0; i <= 202; ++i) {
      CHECK(window.contains({202 * 0.1, i * 0.1}));
      CHECK(window.contains({i * 0.1, 202 * 0.1}));
    }
    CHECK_FALSE(window.contains({20.2 + 1e-8, 10.0}));
    CHECK_FALSE(window.contains({10.0, -1e-8}));
  }
  // As doubles, 202 tenths are larger than 20.2, so that the tolerance is tested.
  CHECK(202 * 0.1 > 20.2);
  // The same in a national grid, where rounding errors are larger.
  const Window far = Window::rectangle({512300.1, 8765400.3}, {512320.3, 8765420.7});
  for (int i = 0; i <= 202; ++i) {
    CHECK(far.contains({(5123001 + i) * 0.1, 87654207 * 0.1}));
    CHECK(far.contains({(5123001 + i) / 10.0, 87654003 * 0.1}));
  }
  CHECK(far.rounding_m() < 1e-8);
}

TEST_CASE("the area that two windows share is that of their intersection") {
  const Window square = Window::rectangle({0, 0}, {20, 20});
  CHECK(square.shared_area_m2(Window::rectangle({15, 10}, {40, 40})) ==
        Approx(50.0).epsilon(1e-14));
  CHECK(square.shared_area_m2(Window::rectangle({20, 0}, {40, 20})) == 0.0);
  CHECK(square.shared_area_m2(Window::rectangle({30, 0}, {40, 20})) == 0.0);
  CHECK(square.shared_area_m2(square) == Approx(400.0).epsilon(1e-14));
  const Window ring({{.outer = {{-10, -10}, {30, -10}, {30, 30}, {-10, 30}},
                      .holes = {{{0, 0}, {20, 0}, {20, 20}, {0, 20}}}}});
  CHECK(square.shared_area_m2(ring) == Approx(0.0).margin(1e-9));
  // The outline of 120 corners lacks (2 pi / 120)^2 / 6 of the circle.
  CHECK(Window::rectangle({0, 0}, {9, 9}).shared_area_m2(Window::circle({0, 0}, 8)) ==
        Approx(16.0 * M_PI).epsilon(5e-4));
}

TEST_CASE("windows are read from well-known text") {
  const auto read_wkt = [](const std::string& text) {
    return read_windows(ScratchFile(text, ".wkt").path());
  };
  const auto one = read_wkt("POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0), (2 2, 4 2, 4 4, 2 4, 2 2))\n");
  REQUIRE(one.size() == 1);
  CHECK_FALSE(one[0].plot);
  CHECK(one[0].window.area_m2() == 96.0);
  const auto joined = read_wkt(
      "SRID=32633;polygon((0 0,10 0,10 10,0 10,0 0))\r\n"
      "MULTIPOLYGON(((10 0,20 0,20 10,10 10,10 0)),\n  ((30 0,31 0,31 1,30 1,30 0)))\n");
  REQUIRE(joined.size() == 1);
  CHECK(joined[0].window.area_m2() == 201.0);
  // Without a known file ending the first character determines the format.
  CHECK(
      read_windows(ScratchFile("Polygon((0 0,1 0,1 1,0 0))", ".txt").path())[0].window.area_m2() ==
      0.5);
  CHECK_THROWS_WITH(read_wkt("POLYGON((0 0,1 0,1 1,0 0))\nPOINT(1 2)\n"),
                    Contains(":2: ") && Contains("not a POINT"));
  CHECK_THROWS_WITH(read_wkt("POLYGON((0 0, 1 x))"), Contains("not a POLYGON"));
  CHECK_THROWS_WITH(read_wkt("POLYGON((0 0,10 10,10 0,0 10,0 0))"), Contains("crosses"));
  CHECK_THROWS_WITH(read_wkt("\n"), Contains("contains no window"));
}

TEST_CASE("windows are read from CSV, polygons and circles") {
  const auto read_csv = [](const std::string& text) {
    return read_windows(ScratchFile(text, ".csv").path());
  };
  const auto polygons = read_csv(
      "WKT,plot\n\"POLYGON((0 0,10 0,10 10,0 0))\",07\n\"POLYGON((20 0,30 0,30 10,20 0))\",7\n");
  REQUIRE(polygons.size() == 2);
  CHECK(polygons[0].plot == "07");
  CHECK(polygons[1].window.low().x == 20.0);
  const auto circles = read_csv("plot,x,y,radius\n1,10,20,5\n*,0,0,12.62\n");
  REQUIRE(circles.size() == 2);
  CHECK(circles[0].window.distance_to_boundary_m({13, 24}) == Approx(0.0).margin(1e-12));
  CHECK(circles[1].plot == kEveryPlot);
  CHECK_THROWS_WITH(read_csv("plot,x,r\n1,0,5\n"), Contains("wkt, or x, y and radius"));
  CHECK_THROWS_WITH(read_csv("plot,x,y,radius\n1,0,0,-5\n"), Contains(":2: the circle around"));
  CHECK_THROWS_WITH(read_csv("plot,x,y,radius\n1,0,zero,5\n"), Contains("'zero' is not a number"));
  CHECK_THROWS_WITH(read_csv("plot,x,y,radius\n1,0,0,5\n1,9,9,5\n"),
                    Contains("already has a window"));
}

TEST_CASE("corners in a CSV file make a polygon of each plot") {
  const auto read_csv = [](const std::string& text) {
    return read_windows(ScratchFile(text, ".csv").path());
  };
  // A right triangle and an L of three squares, whose rows need not follow each other.
  const auto windows = read_csv(
      "Plot ID,x,y\nB,0,0\nB,20,0\nA,100,0\nA,130,0\nA,100,40\nB,20,10\nB,10,10\nB,10,20\n"
      "B,0,20\n");
  REQUIRE(windows.size() == 2);
  CHECK(windows[0].plot == "B");
  CHECK(windows[0].window.area_m2() == 300.0);
  CHECK_FALSE(windows[0].window.contains({15, 15}));
  CHECK(windows[1].window.area_m2() == 600.0);
  CHECK(windows[1].window.perimeter_m() == 120.0);
  CHECK_THROWS_WITH(read_csv("plot,x,y\n7,0,0\n7,10,10\n7,10,0\n7,0,10\n"),
                    Contains(":2") && Contains("plot 7") && Contains("in the order"));
  CHECK_THROWS_WITH(read_csv("plot,x,y,r\n7,0,0,5\n"), Contains("three or more"));
}

TEST_CASE("a GeoJSON point with a radius is a circular plot") {
  const auto windows = read_windows_text(
      R"({"type": "Feature", "properties": {"plot": 3, "radius": 12.5},
          "geometry": {"type": "Point", "coordinates": [100, 50]}})");
  REQUIRE(windows.size() == 1);
  CHECK(windows[0].plot == "3");
  CHECK(windows[0].window.area_m2() == Approx(M_PI * 156.25).epsilon(1e-15));
  CHECK_THROWS_WITH(read_windows_text(R"({"type": "Feature", "properties": {},
                                  "geometry": {"type": "Point", "coordinates": [1, 2]}})"),
                    Contains("needs the property 'radius'"));
}

TEST_CASE("GeoJSON windows in degrees are refused") {
  const std::string text =
      R"({"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": "NAME"}},
          "features": [{"type": "Feature", "properties": {}, "geometry": {"type": "Polygon",
          "coordinates": [[[9.0, 48.0], [9.1, 48.0], [9.1, 48.1], [9.0, 48.0]]]}}]})";
  const auto with = [&text](const std::string& name) {
    return read_windows_text(std::string(text).replace(text.find("NAME"), 4, name));
  };
  for (const char* const name : {"urn:ogc:def:crs:OGC:1.3:CRS84", "urn:ogc:def:crs:EPSG::4326"}) {
    CHECK_THROWS_WITH(with(name), Contains("the coordinates are degrees"));
  }
  CHECK(with("urn:ogc:def:crs:EPSG::25832").size() == 1);
}

TEST_CASE("GeoJSON windows are read as feature, collection or bare geometry") {
  const std::string square = polygon("[[[0,0],[10,0],[10,10],[0,10],[0,0]]]");
  const auto bare = read_windows_text(square);
  REQUIRE(bare.size() == 1);
  CHECK_FALSE(bare[0].plot.has_value());
  CHECK(bare[0].window.area_m2() == 100.0);

  const std::string two = R"({"type": "MultiPolygon", "coordinates":
    [[[[20,0],[30,0],[30,10],[20,10],[20,0]], [[24,4],[26,4],[26,6],[24,6],[24,4]]],
     [[[40,0],[50,0],[50,10,7],[40,0]]]]})";
  const auto several =
      read_windows_text(R"({"type": "FeatureCollection", "features": [)" +
                        feature(square, "\"07\"") + "," + feature(two, "8") + "," +
                        feature(polygon("[[[10,0],[20,0],[20,10],[10,10]]]"), "\"07\"") + "]}");
  REQUIRE(several.size() == 2);
  CHECK(several[0].plot == "07");
  CHECK(several[0].window.area_m2() == 200.0);
  CHECK(several[1].plot == "8");
  CHECK(several[1].window.area_m2() == 146.0);
}

TEST_CASE("an invalid window is refused with the place of its feature") {
  CHECK_THROWS_WITH(read_windows_text("{\n\"type\": \n"), Contains(":3: not valid JSON"));
  CHECK_THROWS_WITH(read_windows_text("[]"), Contains("expected a Polygon or MultiPolygon"));
  CHECK_THROWS_WITH(read_windows_text(R"({"type": "Point", "coordinates": [1, 2]})"),
                    Contains("not a Point"));
  CHECK_THROWS_WITH(read_windows_text(R"({"type": "FeatureCollection", "features": []})"),
                    Contains("contains no window"));
  CHECK_THROWS_WITH(read_windows_text(R"({"type": "Feature", "geometry": null})"),
                    Contains("geometry: expected a Polygon"));
  CHECK_THROWS_WITH(read_windows_text(polygon("[[[0,0],[\"a\",0],[1,1]]]")),
                    Contains("coordinates[0][1][0]") && Contains("must be a number"));
  CHECK_THROWS_WITH(read_windows_text(polygon("[[[0,0],[5],[1,1]]]")),
                    Contains("coordinates[0][1]") && Contains("[x, y] in meters"));
  const std::string bow = polygon("[[[0,0],[10,10],[10,0],[0,10],[0,0]]]");
  CHECK_THROWS_AS(read_windows_text(bow), silvafit::InputError);
  CHECK_THROWS_WITH(read_windows_text(R"({"type": "FeatureCollection", "features": [)" +
                                      feature(polygon("[[[0,0],[1,0],[1,1]]]"), "1") + "," +
                                      feature(bow, "2") + "]}"),
                    Contains("features[1]: not a valid polygon: the boundary crosses"));
  CHECK_THROWS_WITH(read_windows("/no/such/window.geojson"), Contains("/no/such/window.geojson"));
}

TEST_CASE("a byte order mark before a window is ignored") {
  for (const char* text :
       {"POLYGON((0 0, 2 0, 2 3, 0 3, 0 0))",
        R"({"type": "Polygon", "coordinates": [[[0, 0], [2, 0], [2, 3], [0, 3], [0, 0]]]})"}) {
    for (const char* ending : {".wkt", ".json", ".txt"}) {
      const bool fits = (text[0] == 'P') == (std::string_view(ending) == ".wkt");
      if (!fits && std::string_view(ending) != ".txt") continue;
      const silvafit::test::ScratchFile file(std::string("\xEF\xBB\xBF") + text, ending);
      CHECK(read_windows(file.path()).at(0).window.area_m2() == 6.0);
    }
  }
}
