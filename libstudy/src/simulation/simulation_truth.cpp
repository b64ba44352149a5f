// SPDX-License-Identifier: MIT
// The true parameters of a simulated stand as JSON.
#include <nlohmann/json.hpp>

#include "silvafit/base/json_text.hpp"
#include "silvafit/study/simulate.hpp"

namespace silvafit::study {
namespace {

using Json = nlohmann::ordered_json;

Json list(const Eigen::VectorXd& values) {
  return std::vector<double>(values.data(), values.data() + values.size());
}

Json matrix(const Eigen::MatrixXd& values) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < values.rows(); ++i) rows.push_back(list(values.row(i).transpose()));
  return rows;
}

Json random_effects(const ResponseDesign& design,
                    const DrawnResponse& drawn,
                    const std::vector<PlotDesign>& plots) {
  Json by_plot = Json::object();
  for (std::size_t plot = 0; plot < plots.size(); ++plot) {
    by_plot[plots[plot].id] =
        list(drawn.random_effects.row(static_cast<Eigen::Index>(plot)).transpose());
  }
  return {{"group", "plot"},
          {"effects", design.model.random.front().coefficients},
          {"covariance", matrix(design.random_covariance)},
          {"drawn", by_plot}};
}

Json response(const ResponseDesign& design,
              const DrawnResponse& drawn,
              const std::vector<PlotDesign>& plots) {
  Json result{{"formula", design.model.formula.text}};
  for (const fit::ParameterModel& parameter : design.model.parameters) {
    result["parameters"][parameter.name] = parameter.text();
  }
  const std::vector<std::string> names = design.model.coefficient_names();
  for (std::size_t i = 0; i < names.size(); ++i) {
    result["fixed"][names[i]] = design.fixed[static_cast<Eigen::Index>(i)];
  }
  if (!design.model.random.empty()) result["random"] = random_effects(design, drawn, plots);
  result["variance"]["function"] = design.model.variance.text();
  const int parameters = design.model.variance.parameter_count();
  if (parameters >= 1) result["variance"]["delta"] = design.delta;
  if (parameters >= 2) result["variance"]["constant"] = design.constant;
  result["sigma"] = drawn.sigma;
  result["redrawn"] = drawn.redrawn;
  result["clamped"] = drawn.clamped;
  return result;
}

Json dbh(const SpeciesDesign& design, const DrawnSpecies& drawn) {
  return {{"minimum", design.dbh.minimum_cm},
          {"mean", design.dbh.mean_cm},
          {"sd", design.dbh.sd_cm},
          {"plot_log_sd", design.dbh.plot_log_sd},
          {"plot_factor", drawn.dbh_plot_factor}};
}

}  // namespace

std::string truth_json(const SimulationDesign& design,
                       const SimulatedStand& stand,
                       std::uint64_t seed) {
  Json result{{"schema", "silvafit-truth/1"}, {"name", design.name}, {"seed", seed}};
  result["trees"] = stand.inventory.size();
  for (const PlotDesign& plot : design.plots) {
    result["plots"].push_back(
        {{"id", plot.id}, {"x0", plot.x0}, {"y0", plot.y0}, {"x1", plot.x1}, {"y1", plot.y1}});
  }
  result["crowding"] = {{"passes", stand.crowding_passes}, {"unsettled", stand.crowding_unsettled}};
  for (std::size_t s = 0; s < design.species.size(); ++s) {
    const SpeciesDesign& species = design.species[s];
    const DrawnSpecies& drawn = stand.species[s];
    result["species"][species.code] = {{"name", species.name},
                                       {"trees", drawn.trees},
                                       {"dbh", dbh(species, drawn)},
                                       {"h", response(species.h, drawn.h, design.plots)},
                                       {"hcb", response(species.hcb, drawn.hcb, design.plots)},
                                       {"cw", response(species.cw, drawn.cw, design.plots)}};
  }
  return json_text(result, 2) + "\n";
}

}  // namespace silvafit::study
