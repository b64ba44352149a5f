// SPDX-License-Identifier: MIT
#include "silvafit/tree/taper.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

Taper zeng() { return Taper::load(test::source_file("models/taper/zeng.json")); }

/// The published equation, implemented a second time.
double by_hand(double at, double h, double dbh) {
  const double z = at / h;
  const double power =
      3.99786 - 8.63324 * std::sqrt(std::sqrt(z)) + 5.11564 * std::sqrt(z) + 0.19384 * (dbh / h);
  return dbh * std::exp(power * std::log((h - at) / (h - 1.3)));
}

}  // namespace

TEST_CASE("Zeng's stem has DBH at breast height and ends at the tip, exactly") {
  const Taper taper = zeng();
  for (const double h : {1.31, 2.0, 7.7, 20.2, 45.0}) {
    for (const double dbh : {0.3, 12.7, 95.0}) {
      CHECK(taper.diameters_cm(std::array<double, 1>{1.3}, h, dbh).front() == dbh);
      CHECK(taper.diameters_cm(std::array<double, 1>{h}, h, dbh).front() == 0.0);
    }
  }
}

TEST_CASE("Zeng's stem follows the printed equation") {
  const Taper taper = zeng();
  for (const double at : {0.4, 1.0, 2.0, 6.0, 13.5, 20.0}) {
    // pow against exp and log: a few units in the last place
    CHECK(taper.diameters_cm(std::array<double, 1>{at}, 20.2, 24.0).front() ==
          Approx(by_hand(at, 20.2, 24.0)).epsilon(1e-13));
  }
}

TEST_CASE("diameters never increase upwards and are bounded at the ground") {
  const Taper taper = zeng();
  for (const double h : {1.32, 1.6, 3.0, 11.0, 30.0}) {
    for (const double dbh : {0.5, 10.0, 100.0}) {
      const std::vector<double> heights = section_heights_m(h);
      const std::vector<double> diameters = taper.diameters_cm(heights, h, dbh);
      CHECK(diameters.front() <= taper.butt_limit() * dbh);
      for (std::size_t i = 1; i < diameters.size(); ++i) {
        CHECK(diameters[i] <= diameters[i - 1] * (1 + 1e-12));
      }
    }
  }
}

TEST_CASE("a stem has a section every 0.2 m, at 1.3 m and at the tip") {
  CHECK(section_heights_m(1.9) ==
        std::vector<double>{0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.3, 1.4, 1.6, 1.8, 1.9});
  CHECK(section_heights_m(1.35).back() == 1.35);
  CHECK(*(section_heights_m(1.35).end() - 2) == 1.3);
  CHECK(section_heights_m(2.0) ==
        std::vector<double>{0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.3, 1.4, 1.6, 1.8, 2.0});
}

TEST_CASE("an invalid taper entry (DBH, tip or field) is refused with its place") {
  const auto file = std::filesystem::temp_directory_path() / "silvafit-taper-test.json";
  const auto entry = [](const std::string& formula) {
    return R"({"schema": "silvafit-taper/1", "name": "t", "source": "s", "butt_limit": 2,
              "coefficients": {}, "relative_diameter": ")" +
           formula + "\"}";
  };
  const auto load = [&](const std::string& text) {
    write_file(file, text);
    return Taper::load(file);
  };
  CHECK(
      load(entry("(h - x)/(h - 1.3)")).diameters_cm(std::array<double, 1>{10.65}, 20, 30).front() ==
      Approx(15.0).epsilon(1e-14));
  CHECK_THROWS_AS(load(entry("1 - x/h")), InputError);
  CHECK_THROWS_AS(load(entry("(h - x)/(h - 1.3)*q")), InputError);
  CHECK_THROWS_AS(load("[]"), InputError);
  try {
    load(R"({"schema": "silvafit-taper/1", "name": "t"})");
    FAIL("a missing field was accepted");
  } catch (const InputError& error) {
    CHECK(error.place().file == file.string());
    CHECK(error.message() == "the key \"source\" is missing");
  }
  std::filesystem::remove(file);
}
