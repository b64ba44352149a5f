// SPDX-License-Identifier: MIT
// A program outside of silvafit that uses each of its libraries once, and checks what it gets.
#include <cmath>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/least_squares.hpp"
#include "silvafit/stand/window.hpp"
#include "silvafit/study/catalogue.hpp"
#include "silvafit/tree/taper.hpp"

namespace {

/// Prints each value and counts the wrong ones.
class Checks {
 public:
  void near(const std::string& what, double value, double expected, double relative_tolerance) {
    const bool right = std::abs(value - expected) <= relative_tolerance * std::abs(expected);
    std::printf("%-28s %.12g", what.c_str(), value);
    if (!right) std::printf("  WRONG, expected %.12g", expected);
    std::printf("\n");
    failures_ += right ? 0 : 1;
  }
  int failures() const { return failures_; }

 private:
  int failures_ = 0;
};

/// NIST's Misra1a (Statistical Reference Datasets), certified to 11 digits; the fit is asked for 8.
void fit_misra1a(Checks& checks) {
  // clang-format off
  const std::vector<double> x = {77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8,
                                 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0};
  const std::vector<double> y = {10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02,
                                 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78};
  // clang-format on
  silvafit::data::Table table;
  table.set("y", y);
  table.set("x", x);
  const silvafit::fit::NonlinearModel model(
      silvafit::fit::specify_model("y ~ b1*(1 - exp(-b2*x))", {}, table), table);
  const silvafit::fit::LeastSquaresFit fit = silvafit::fit::fit_least_squares(model);
  checks.near("Misra1a b1", fit.estimate[0], 2.3894212918E+02, 1e-8);
  checks.near("Misra1a b2", fit.estimate[1], 5.5015643181E-04, 1e-8);
  checks.near("Misra1a sum of squares", fit.sum_of_squares, 1.2455138894E-01, 1e-8);
}

/// The center of a rectangle is half of its shorter side from the boundary.
void measure_window(Checks& checks) {
  const auto window = silvafit::stand::Window::rectangle({10.0, 20.0}, {40.0, 32.0});
  checks.near("window area [m2]", window.area_m2(), 30.0 * 12.0, 1e-14);
  checks.near("distance to its edge [m]", window.distance_to_boundary_m({25.0, 26.0}), 6.0, 1e-14);
}

/// A stem has its DBH at breast height, by definition.
void measure_stem(Checks& checks, const std::string& models) {
  const auto taper = silvafit::tree::Taper::load(models + "/taper/zeng.json");
  const double breast = 1.3;
  const auto diameters = taper.diameters_cm(std::span(&breast, 1), 20.0, 25.0);
  checks.near("stem at 1.3 m [cm]", diameters.front(), 25.0, 1e-14);
}

/// Each entry of the catalogue carries values known from outside the program.
void evaluate_catalogue(Checks& checks, const std::string& models) {
  const auto catalogue = silvafit::study::Catalogue::load(models);
  for (const char* response : {"h", "hcb", "cw"}) {
    const silvafit::study::BaseModel& model = *catalogue.candidates(response).at(0);
    const silvafit::study::ReferencePoint& point = model.reference_points.at(0);
    checks.near(model.id + " " + model.name,
                model.value(point.arguments, point.parameters),
                point.value,
                1e-9);
  }
}

}  // namespace

int main() {
  const std::string models = SILVAFIT_DATA_DIR "/models";
  Checks checks;
  fit_misra1a(checks);
  measure_window(checks);
  measure_stem(checks, models);
  evaluate_catalogue(checks, models);
  return checks.failures() == 0 ? 0 : 1;
}
