// SPDX-License-Identifier: MIT
#include "silvafit/tree/morphology.hpp"

#include <fmt/format.h>

#include <cmath>

#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

// No measured tree exceeds these; a larger number has a wrong unit.
constexpr double kTallest = 150.0;
constexpr double kThickest = 2000.0;
constexpr double kWidest = 60.0;
constexpr double kOldest = 5000.0;
constexpr double kThinnest = 0.01;  // cm
constexpr double kNarrowest = 0.001;
/// Farther than any projection's coordinates; beyond, a double cannot represent millimeters.
constexpr double kFarthest = 1e9;
/// If they differ more, the crown width and that of the radii are not of one crown, rounded to
/// decimeters.
constexpr double kLikeWidths = 0.1;
constexpr double kMostBent = 60.0;
constexpr double kSteepestBranch = 70.0;
constexpr double kMostInternodes = 200.0;

class Checker {
 public:
  explicit Checker(const Morphology& morphology) : morphology_(morphology) {}

  void require(bool holds, const char* column, const std::string& message) const {
    if (holds) return;
    throw DomainError(message,
                      {.column = column, .plot = morphology_.plot, .tree = morphology_.tree});
  }

  void known(double value, const char* column) const {
    require(std::isfinite(value), column, "is missing or not a finite number");
  }

  void within(
      double value, double least, double largest, const char* column, const char* unit) const {
    known(value, column);
    require(value > 0.0, column, fmt::format("{} {} must be above 0", value, unit));
    require(value >= least,
            column,
            fmt::format("{} {} is below the smallest possible value ({} {}); check the unit",
                        value,
                        unit,
                        least,
                        unit));
    require(value <= largest,
            column,
            fmt::format("{} {} is above the largest possible value ({} {}); check the unit",
                        value,
                        unit,
                        largest,
                        unit));
  }

  void place(double value, const char* column) const {
    known(value, column);
    require(std::abs(value) <= kFarthest,
            column,
            fmt::format("{} m is not a possible coordinate; check the unit", value));
  }

 private:
  const Morphology& morphology_;
};

void validate_crown(const Morphology& m, const Checker& check) {
  check.known(m.hcb_m, "hcb");
  check.require(m.hcb_m >= 0.0, "hcb", fmt::format("{} m is below the ground", m.hcb_m));
  check.require(m.hcb_m < m.h_m, "hcb", fmt::format("{} m is not below h {} m", m.hcb_m, m.h_m));
  if (m.hc_m) {
    check.known(*m.hc_m, "hc");
    check.require(*m.hc_m >= m.hcb_m && *m.hc_m <= m.h_m,
                  "hc",
                  fmt::format("{} m is outside the crown, {} to {} m", *m.hc_m, m.hcb_m, m.h_m));
  }
  if (m.radii) {
    check.within(m.radii->east_m, kNarrowest, kWidest, "cr_e", "m");
    check.within(m.radii->west_m, kNarrowest, kWidest, "cr_w", "m");
    check.within(m.radii->south_m, kNarrowest, kWidest, "cr_s", "m");
    check.within(m.radii->north_m, kNarrowest, kWidest, "cr_n", "m");
  } else {
    check.require(m.cw_m.has_value(),
                  "cw",
                  "is missing, and at least one of the four crown radii is missing");
    check.within(*m.cw_m, 2.0 * kNarrowest, 2.0 * kWidest, "cw", "m");
  }
}

void validate_culm(const CulmForm& culm, const Checker& check) {
  const auto between =
      [&check](const std::optional<double>& value, double low, double high, const char* column) {
        check.require(!value || (*value >= low && *value <= high),
                      column,
                      fmt::format("{} is outside [{}, {}]", value.value_or(0.0), low, high));
      };
  between(culm.bend_deg, 0.0, kMostBent, "bend_deg");
  between(culm.bend_azimuth_deg, 0.0, 360.0, "bend_azimuth_deg");
  between(culm.branch_angle_deg, 0.0, kSteepestBranch, "branch_angle_deg");
  between(culm.internodes, 2.0, kMostInternodes, "internodes");
}

}  // namespace

void validate_height(const Morphology& morphology) {
  const Checker check(morphology);
  check.within(morphology.h_m, 0.0, kTallest, "h", "m");
  check.require(morphology.h_m > kBreastHeight,
                "h",
                fmt::format("{} m is not above 1.3 m, where DBH is measured", morphology.h_m));
  check.place(morphology.position.x_m, "x");
  check.place(morphology.position.y_m, "y");
  check.place(morphology.position.z_m, "z");
}

void validate(const Morphology& morphology) {
  validate_height(morphology);
  const Checker check(morphology);
  check.within(morphology.dbh_cm, kThinnest, kThickest, "dbh", "cm");
  validate_crown(morphology, check);
  if (morphology.age_years) {
    check.known(*morphology.age_years, "age");
    check.require(*morphology.age_years > 0.0, "age", "must be above 0");
    check.require(*morphology.age_years <= kOldest,
                  "age",
                  fmt::format("{} years is above the largest possible age ({}); check the unit",
                              *morphology.age_years,
                              kOldest));
  }
  validate_culm(morphology.culm, check);
  const double decay = morphology.decay_class.value_or(1.0);
  check.require(decay >= 1.0 && decay <= 5.0 && decay == std::floor(decay),
                "decay",
                fmt::format("{} is not a decay class; snags have 1 to 5", decay));
}

TreeShape complete(const Morphology& morphology, double relative_hc, const std::string& source) {
  validate(morphology);
  TreeShape shape{.dbh_cm = morphology.dbh_cm,
                  .h_m = morphology.h_m,
                  .hcb_m = morphology.hcb_m,
                  .age_years = morphology.age_years,
                  .culm = morphology.culm};
  if (!morphology.assumed.empty()) {
    shape.notes.push_back({"sizes", morphology.assumed + " not measured: assumed for the picture"});
  }
  if (morphology.hc_m) {
    shape.hc_m = *morphology.hc_m;
  } else {
    shape.hc_m = shape.hcb_m + relative_hc * (shape.h_m - shape.hcb_m);
    shape.notes.push_back(
        {"hc",
         fmt::format("height of the widest crown not measured: {} of the crown length is used ({})",
                     relative_hc,
                     source)});
  }
  if (morphology.radii) {
    shape.radii = *morphology.radii;
    const double width = shape.radii.width_m();
    if (morphology.cw_m && std::abs(*morphology.cw_m - width) > kLikeWidths * width) {
      shape.notes.push_back(
          {"cw",
           fmt::format("crown width {} m not used: the four crown radii give {:.4g} m",
                       *morphology.cw_m,
                       width)});
    }
  } else {
    const double radius = 0.5 * *morphology.cw_m;
    shape.radii = {radius, radius, radius, radius};
    shape.notes.push_back(
        {"radii",
         "not all four crown radii were measured: half the crown width is used in all directions"});
  }
  return shape;
}

}  // namespace silvafit::tree
