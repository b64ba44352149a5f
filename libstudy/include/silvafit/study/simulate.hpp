// SPDX-License-Identifier: MIT
// Inventories with known parameters: a design, the stand that is drawn from it, and the record of
// the draws.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/fit/model_specification.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/structural_units.hpp"

namespace silvafit::study {

/// A rectangular plot [m].
struct PlotDesign {
  std::string id{};
  double x0 = 0.0;
  double y0 = 0.0;
  double x1 = 0.0;
  double y1 = 0.0;

  double area_m2() const { return (x1 - x0) * (y1 - y0); }
};

/// Minimum distance and clustering of stems.
struct StemDesign {
  double minimum_distance_m = 0.5;
  double patch_length_m = 25.0;  ///< distance over which a species' density changes
};

/// Elevation: a plane, smooth hills on it, and a step per plot.
struct TerrainDesign {
  double base_m = 0.0;
  double slope_east = 0.0;   ///< rise per meter to the east
  double slope_north = 0.0;  ///< rise per meter to the north
  double hill_sd_m = 0.0;
  double hill_length_m = 100.0;
  double plot_sd_m = 0.0;
};

/// DBH = minimum + gamma variate, with the given mean and standard deviation over the stand. Part
/// of it is a factor per plot on DBH - minimum, lognormal with mean 1 and this log-scale sd.
struct DbhDesign {
  double minimum_cm = 5.0;
  double mean_cm = 0.0;
  double sd_cm = 0.0;
  double plot_log_sd = 0.0;
};

/// One response of one species: mean, random effects per plot, residual.
///
/// Model: y_ij = f(x_ij; beta + b_i) + e_ij, b_i ~ N(0, Psi), sd(e_ij) = sigma g(v_ij) with g as in
/// fit::VarianceFunction, delta and constant its parameters, v the mean given b_i or a column.
struct ResponseDesign {
  fit::ModelSpecification model;  ///< of dbh, h (hcb only), W, M, U, C, z
  Eigen::VectorXd fixed{};        ///< (p) in the order of model.coefficient_names()
  /// (q x q) of the term in model.random; none without random effects.
  Eigen::MatrixXd random_covariance{};
  double delta = 0.0;
  double constant = 0.0;
  /// Either sigma itself, or the root mean square of residual sds over the species' trees.
  std::optional<double> sigma{};
  std::optional<double> residual_rms{};
};

struct SpeciesDesign {
  std::string code{};
  std::string name{};
  double density_per_ha = 0.0;
  double patchiness = 0.0;  ///< sd of the logarithm of its relative density; 0: even
  DbhDesign dbh{};
  ResponseDesign h;
  ResponseDesign hcb;
  ResponseDesign cw;
};

struct SimulationDesign {
  std::string name{};
  std::vector<PlotDesign> plots{};
  StemDesign stems{};
  TerrainDesign terrain{};
  std::vector<SpeciesDesign> species{};
  std::size_t neighbors = 4;
  stand::SearchScope scope = stand::SearchScope::kStand;
  double crown_asymmetry = 0.12;  ///< sd of a crown radius over the tree's mean radius
};

/// Reads a design; docs/simulation.md describes the keys.
/// \throws InputError that names the key of the first thing that cannot be used
SimulationDesign read_design(const std::filesystem::path& path);
/// The same from a text; `file` is for messages.
SimulationDesign parse_design(std::string_view text, const std::string& file);

/// What was drawn for one response of one species.
struct DrawnResponse {
  double sigma = 0.0;
  Eigen::MatrixXd random_effects{};  ///< (plots x q)
  std::size_t redrawn = 0;           ///< residuals drawn again since the value was out of limits
  std::size_t clamped = 0;           ///< values set to a limit
};

struct DrawnSpecies {
  std::size_t trees = 0;
  std::vector<double> dbh_plot_factor{};  ///< (plots)
  DrawnResponse h{};
  DrawnResponse hcb{};
  DrawnResponse cw{};
};

struct SimulatedStand {
  stand::Inventory inventory{};         ///< trees by plot, in the order of the design
  std::vector<DrawnSpecies> species{};  ///< in the order of the design
  /// Crown widths depend on C, and C on crown widths: rounds until both agreed.
  std::size_t crowding_passes = 0;
  /// Trees whose C still changed in the last round; 0 where both agree everywhere.
  std::size_t crowding_unsettled = 0;
};

/// Draws a stand. The same design and seed give the same stand, for any number of threads.
///
/// Stems by sequential inhibition in species' patchy density; values rounded as measured (position
/// and radii 0.01 m, DBH 0.1 cm, h and hcb 0.1 m) where they arise, so that C of the file is the C
/// behind its crowns. Limits, before rounding: h >= 2 m, 0.15 m <= hcb <= 0.95 h,
/// cw >= 0.4 m.
/// \throws InputError if the stems find no room, or a plot has too few trees for its neighbors;
///         DomainError if a mean is not finite for some tree
SimulatedStand simulate(const SimulationDesign& design, std::uint64_t seed, unsigned threads = 0);

/// Notes on responses of which limits made a tenth of a species' trees or more: redrawn or clamped.
std::vector<std::string> notes_on_limits(const SimulationDesign& design,
                                         const SimulatedStand& stand);

/// The truth behind a stand as JSON text (schema silvafit-truth/1).
std::string truth_json(const SimulationDesign& design,
                       const SimulatedStand& stand,
                       std::uint64_t seed);

}  // namespace silvafit::study
