// SPDX-License-Identifier: MIT
#include "silvafit/tree/morphology.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "silvafit/base/error.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

template <typename Change>
Place place_of_error(Change change) {
  Morphology tree = test::paper_tree_1();
  change(tree);
  try {
    validate(tree);
  } catch (const DomainError& error) {
    return error.place();
  }
  return {};
}

}  // namespace

TEST_CASE("impossible trees are refused with plot, tree and column") {
  const Place place = place_of_error([](Morphology& t) { t.hcb_m = 21; });
  CHECK(place.plot == "1");
  CHECK(place.tree == "1");
  CHECK(place.column == "hcb");
  CHECK(place_of_error([](Morphology& t) { t.h_m = 1.3; }).column == "h");
  CHECK(place_of_error([](Morphology& t) { t.h_m = NAN; }).column == "h");
  CHECK(place_of_error([](Morphology& t) { t.h_m = 2020; }).column == "h");
  CHECK(place_of_error([](Morphology& t) { t.dbh_cm = 0; }).column == "dbh");
  CHECK(place_of_error([](Morphology& t) { t.dbh_cm = INFINITY; }).column == "dbh");
  CHECK(place_of_error([](Morphology& t) { t.hcb_m = -0.1; }).column == "hcb");
  CHECK(place_of_error([](Morphology& t) { t.hcb_m = t.h_m; }).column == "hcb");
  CHECK(place_of_error([](Morphology& t) { t.hc_m = 5.0; }).column == "hc");
  CHECK(place_of_error([](Morphology& t) { t.hc_m = 20.3; }).column == "hc");
  CHECK(place_of_error([](Morphology& t) { t.radii->south_m = -1; }).column == "cr_s");
  CHECK(place_of_error([](Morphology& t) { t.radii.reset(); }).column == "cw");
  CHECK(place_of_error([](Morphology& t) { t.age_years = 0; }).column == "age");
  CHECK(place_of_error([](Morphology& t) { t.age_years = 1e6; }).column == "age");
  CHECK(place_of_error([](Morphology& t) { t.position.x_m = NAN; }).column == "x");
  CHECK(place_of_error([](Morphology& t) { t.position.y_m = -1e308; }).column == "y");
  CHECK(place_of_error([](Morphology& t) { t.dbh_cm = 1e-308; }).column == "dbh");
  CHECK(place_of_error([](Morphology& t) { t.radii->east_m = 1e-9; }).column == "cr_e");
  CHECK(place_of_error([](Morphology&) {}).column.empty());
}

TEST_CASE("missing measurements are filled in, with notes") {
  Morphology tree = test::paper_tree_1();
  CHECK(complete(tree, 0.3, "p").notes.empty());
  tree.hc_m.reset();
  tree.radii.reset();
  tree.cw_m = 4.25;
  const TreeShape shape = complete(tree, 0.25, "p");
  CHECK(shape.hc_m == Approx(5.8 + 0.25 * 14.4).epsilon(1e-14));
  CHECK(shape.radii.east_m == 2.125);
  CHECK(shape.radii.width_m() == 4.25);
  REQUIRE(shape.notes.size() == 2);
  CHECK(shape.notes[0].about == "hc");
  CHECK(shape.notes[1].about == "radii");
}
