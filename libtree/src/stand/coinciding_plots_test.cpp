// SPDX-License-Identifier: MIT
#include "silvafit/tree/coinciding_plots.hpp"

#include <catch2/catch.hpp>
#include <vector>

using namespace silvafit::tree;

namespace {

/// Four trees in the corners of a rectangle.
void add_plot(const std::string& plot,
              double west,
              double south,
              double width,
              double length,
              std::vector<Morphology>& trees) {
  for (const double x : {west, west + width}) {
    for (const double y : {south, south + length}) {
      trees.push_back({.plot = plot, .position = {x, y, 0.0}});
    }
  }
}

}  // namespace

TEST_CASE("plots with their own coordinates coincide") {
  std::vector<Morphology> trees;
  add_plot("a", 0, 0, 30, 30, trees);
  add_plot("c", 100, 0, 30, 30, trees);
  CHECK_FALSE(coinciding_plots(trees));
  add_plot("b", 1, 2, 28, 27, trees);
  const auto found = coinciding_plots(trees);
  REQUIRE(found);
  CHECK(found->first == "a");
  CHECK(found->second == "b");
}

TEST_CASE("adjacent plots do not coincide if their rectangles overlap by up to a half") {
  std::vector<Morphology> trees;
  add_plot("a", 0, 0, 30, 30, trees);
  add_plot("b", 15, 0, 30, 30, trees);
  CHECK_FALSE(coinciding_plots(trees));
  // A small plot counts by its own area: 5.1 of its 10 m are in the large one.
  add_plot("small", 39.9, 40.0, 10, 10, trees);
  add_plot("other", 45.0 - 0.2, 40.0, 30, 30, trees);
  CHECK(coinciding_plots(trees));
}

TEST_CASE("plots without an area are ignored") {
  std::vector<Morphology> trees{{.plot = "a", .position = {0, 0, 0}},
                                {.plot = "a", .position = {5, 5, 0}},
                                {.plot = "b", .position = {0, 0, 0}},
                                {.plot = "b", .position = {5, 5, 0}}};
  CHECK_FALSE(coinciding_plots(trees));
  CHECK_FALSE(coinciding_plots({}));
  trees.clear();
  for (const char* plot : {"a", "b"}) {
    for (const double y : {0.0, 1.0, 2.0}) trees.push_back({.plot = plot, .position = {3, y, 0}});
  }
  CHECK_FALSE(coinciding_plots(trees));
}
