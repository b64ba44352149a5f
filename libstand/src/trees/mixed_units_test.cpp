// SPDX-License-Identifier: MIT
#include <catch2/catch.hpp>
#include <cmath>

#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/stand/size_units.hpp"

using namespace silvafit::stand;
using silvafit::Random;
using silvafit::data::TextColumn;

namespace {

/// Plots of one species with different ages and sites and with h/dbh of real stands.
struct Stands {
  TextColumn plot{};
  std::vector<double> dbh{};
  std::vector<double> h{};

  /// \param mean_dbh  of the plot [cm]
  /// \param limit     of the heights [m]
  void add(const std::string& name,
           double mean_dbh,
           double limit,
           Random& random,
           double dbh_factor = 1.0,
           double h_factor = 1.0) {
    for (int i = 0; i < 25; ++i) {
      const double d = mean_dbh * std::exp(0.25 * random.normal());
      const double height =
          1.3 + limit * (1.0 - std::exp(-0.045 * d)) * std::exp(0.06 * random.normal());
      plot.append(name);
      dbh.push_back(d * dbh_factor);
      h.push_back(height * h_factor);
    }
  }

  std::vector<MixedUnits> mixed() const {
    return find_mixed_units({.plot = plot, .dbh_cm = dbh, .h_m = h});
  }
};

/// Nine plots, some in other units.
Stands stands(Random& random, double dbh_factor, double h_factor) {
  Stands all;
  for (int i = 0; i < 9; ++i) {
    const bool is_other = i == 2 || i == 5;
    const double mean = 14.0 + 1.5 * i;
    const double limit = 27.0 + 1.5 * random.normal();
    all.add("P" + std::to_string(i),
            mean,
            limit,
            random,
            is_other ? dbh_factor : 1.0,
            is_other ? h_factor : 1.0);
  }
  return all;
}

}  // namespace

TEST_CASE("plots in millimeters, inches, feet and decimeters are found by name") {
  struct Case {
    double dbh_factor;
    double h_factor;
    std::string dbh_unit;
    std::string h_unit;
  };
  const std::vector<Case> cases{{10.0, 1.0, "mm", ""},
                                {1.0 / 2.54, 1.0, "in", ""},
                                {1.0, 1.0 / 0.3048, "", "ft"},
                                {1.0 / 2.54, 1.0 / 0.3048, "in", "ft"},
                                {1.0, 10.0, "", "dm"},
                                {1.0, 100.0, "", "cm"}};
  Random random(4);
  for (const Case& one : cases) {
    const auto mixed = stands(random, one.dbh_factor, one.h_factor).mixed();
    REQUIRE(mixed.size() == 1);
    CHECK(mixed[0].dbh_unit == one.dbh_unit);
    CHECK(mixed[0].h_unit == one.h_unit);
    CHECK(mixed[0].plots == std::vector<std::string>{"P2", "P5"});
  }
  CHECK(stands(random, 1.0, 1.0).mixed().empty());
  CHECK(describe_mixed_units({}).empty());
}

TEST_CASE("stands of any age, site and density do not seem to be a mixture of units") {
  Random random(9);
  for (int round = 0; round < 50; ++round) {
    Stands all;
    all.add("saplings", 2.0 + 2.0 * random.uniform(), 18.0 + 8.0 * random.uniform(), random);
    all.add("pole", 8.0 + 8.0 * random.uniform(), 22.0 + 10.0 * random.uniform(), random);
    all.add("mature", 25.0 + 15.0 * random.uniform(), 22.0 + 12.0 * random.uniform(), random);
    all.add("old", 60.0 + 40.0 * random.uniform(), 30.0 + 10.0 * random.uniform(), random);
    all.add("dry site", 12.0 + 10.0 * random.uniform(), 9.0 + 4.0 * random.uniform(), random);
    CHECK(all.mixed().empty());
  }
}

TEST_CASE("thickets of saplings, twice as slender as other stands, have no other unit") {
  Random random(12);
  for (int round = 0; round < 50; ++round) {
    Stands all = stands(random, 1.0, 1.0);
    for (int i = 0; i < 25; ++i) {
      // h/dbh of 150 to 195 at a dbh of 2 to 5 cm, as in dense natural regeneration.
      const double dbh = 2.0 + 3.0 * random.uniform();
      all.plot.append("thicket");
      all.dbh.push_back(dbh);
      all.h.push_back(dbh * (1.5 + 0.45 * random.uniform()));
    }
    CHECK(all.mixed().empty());
  }
}

TEST_CASE("plots whose heights differ much from each other are rarely mistaken for inches") {
  Random random(7);
  std::size_t found = 0;
  for (int round = 0; round < 20; ++round) {
    Stands all;
    for (int i = 0; i < 1000; ++i) {
      all.plot.append(std::to_string(i / 5));
      all.dbh.push_back(5.0 + 45.0 * random.uniform());
      all.h.push_back(5.0 + 25.0 * random.uniform());
    }
    for (const MixedUnits& mixed : all.mixed()) found += mixed.plots.size();
  }
  // Of 4000 plots without any relation of h and dbh.
  CHECK(found <= 2);
}

TEST_CASE("inches are found in plots of poor and good sites") {
  Random random(5);
  int found = 0;
  for (int round = 0; round < 40; ++round) {
    Stands all = stands(random, 1.0, 1.0);
    // Heights of the site differ from those of the others by up to a fifth; trees are above 10 m.
    const double limit = 27.0 * (0.8 + 0.4 * random.uniform());
    all.add("inches", 14.0 + 10.0 * random.uniform(), limit, random, 1.0 / 2.54);
    const auto mixed = all.mixed();
    if (mixed.empty()) continue;
    REQUIRE(mixed.size() == 1);
    CHECK(mixed[0].dbh_unit == "in");
    CHECK(mixed[0].h_unit.empty());
    CHECK(mixed[0].plots == std::vector<std::string>{"inches"});
    ++found;
  }
  // The others fit both units, no other plot has trees as thin, or their h/dbh is less than 2.1
  // times that of the other plots, which metric plots can have, too.
  CHECK(found >= 25);
}

TEST_CASE("other species, single trees and files of one unit are not tested") {
  Random random(2);
  Stands all;
  all.add("millimeters", 25.0, 27.0, random, 10.0);
  CHECK(all.mixed().empty());  // no plots for a comparison
  all.add("trees", 25.0, 27.0, random);
  CHECK(all.mixed().size() == 1);
  TextColumn species;
  for (std::size_t i = 0; i < all.dbh.size(); ++i) species.append(i < 25 ? "bamboo" : "fir");
  CHECK(find_mixed_units({.plot = all.plot, .species = &species, .dbh_cm = all.dbh, .h_m = all.h})
            .empty());
}

namespace {

/// Two species in one plot, of which one is measured in other units.
std::string species_in_units(double dbh_factor, double h_factor, double dbh_cm, double h_m) {
  Random random(6);
  TextColumn plot;
  TextColumn species;
  std::vector<double> dbh;
  std::vector<double> h;
  for (int i = 0; i < 40; ++i) {
    const bool is_other = i % 2 == 0;
    plot.append("1");
    species.append(is_other ? "oak" : "fir");
    dbh.push_back((is_other ? dbh_cm * dbh_factor : 30.0) * std::exp(0.1 * random.normal()));
    h.push_back((is_other ? h_m * h_factor : 24.0) * std::exp(0.05 * random.normal()));
  }
  try {
    check_units_of_trees(plot,
                         species,
                         {{.name = "dbh", .source = "dbh", .values = dbh},
                          {.name = "h", .source = "h", .values = h}},
                         "t.csv",
                         [](std::size_t /*row*/) { return silvafit::Place{}; });
  } catch (const silvafit::InputError& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("a species in other units among others is named if its trees are impossible") {
  // 95 m (dbh/m)^(2/3) is the height at which a stem buckles (McMahon 1973): 38 m for 25 cm.
  for (const auto& [dbh_factor, h_factor] : {std::pair(10.0, 1.0),
                                             std::pair(1.0, 1.0 / 0.3048),
                                             std::pair(1.0, 10.0),
                                             std::pair(1.0, 100.0)}) {
    const std::string error = species_in_units(dbh_factor, h_factor, 25.0, 21.0);
    INFO(error);
    CHECK(error.find("of species oak, unlike others, ") != std::string::npos);
    CHECK(error.find("use `columns") == std::string::npos);
  }
  CHECK(species_in_units(1.0, 1.0, 25.0, 21.0).empty());
  // Bamboo, shrubs without breast height diameters to speak of, and giants.
  CHECK(species_in_units(1.0, 1.0, 8.0, 14.0).empty());
  CHECK(species_in_units(1.0, 1.0, 0.4, 1.6).empty());
  CHECK(species_in_units(1.0, 1.0, 240.0, 70.0).empty());
}

TEST_CASE("dbh and h that are exchanged are refused, and stands of any age are not") {
  Random random(8);
  const auto error_of = [](const std::vector<double>& dbh,
                           const std::vector<double>& h) -> std::string {
    TextColumn plot;
    for (std::size_t i = 0; i < dbh.size(); ++i) plot.append("1");
    try {
      check_units_of_trees(plot,
                           {},
                           {{.name = "dbh", .source = "D", .values = dbh},
                            {.name = "h", .source = "H", .values = h}},
                           "t.csv",
                           [](std::size_t /*row*/) { return silvafit::Place{}; });
    } catch (const silvafit::InputError& error) {
      return error.what();
    }
    return {};
  };
  for (int round = 0; round < 50; ++round) {
    Stands all;
    for (int i = 0; i < 4; ++i) {
      all.add("P" + std::to_string(i),
              24.0 + 8.0 * random.uniform(),
              18.0 + 4.0 * random.uniform(),
              random);
    }
    CHECK_THAT(error_of(all.h, all.dbh), Catch::Matchers::Contains("use `columns=dbh=H,h=D`"));
    CHECK(error_of(all.dbh, all.h).empty());
    Stands ages;
    ages.add("saplings", 2.0 + 2.0 * random.uniform(), 18.0 + 8.0 * random.uniform(), random);
    ages.add("mature", 25.0 + 15.0 * random.uniform(), 22.0 + 12.0 * random.uniform(), random);
    CHECK(error_of(ages.dbh, ages.h).empty());
  }
}
