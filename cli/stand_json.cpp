// SPDX-License-Identifier: MIT
// A stand report as JSON.
#include <cmath>
#include <string>

#include "stand_output.hpp"

namespace silvafit::cli {
namespace {

using nlohmann::ordered_json;

ordered_json number(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

ordered_json text_or_null(const std::string& text) {
  return text.empty() ? ordered_json(nullptr) : ordered_json(text);
}

ordered_json figures_json(const stand::StandFigures& figures) {
  return {{"trees", figures.trees},
          {"area_ha", number(figures.area_ha)},
          {"stems_per_ha", number(figures.stems_per_ha)},
          {"basal_area_m2_per_ha", number(figures.basal_area_m2_per_ha)},
          {"mean_dbh_cm", number(figures.mean_dbh_cm)},
          {"sd_dbh_cm", number(figures.sd_dbh_cm)},
          {"quadratic_mean_dbh_cm", number(figures.quadratic_mean_dbh_cm)},
          {"mean_height_m", number(figures.mean_height_m)},
          {"sd_height_m", number(figures.sd_height_m)},
          {"lorey_height_m", number(figures.lorey_height_m)},
          {"dominant_height_m", number(figures.dominant_height_m)},
          {"crown_cover_percent", number(figures.crown_cover_percent)}};
}

ordered_json clark_evans_json(const std::optional<stand::ClarkEvans>& result) {
  if (!result) return nullptr;
  return {{"mean_distance_m", number(result->mean_distance_m)},
          {"R", number(result->R)},
          {"z", number(result->z)},
          {"p", number(result->p)},
          {"R_donnelly", number(result->R_donnelly)},
          {"z_donnelly", number(result->z_donnelly)},
          {"p_donnelly", number(result->p_donnelly)}};
}

ordered_json estimate_json(const stand::Estimate& estimate) {
  return {{"per_ha", number(estimate.per_ha)},
          {"standard_error", number(estimate.standard_error)},
          {"total", number(estimate.total)},
          {"total_standard_error", number(estimate.total_standard_error)}};
}

ordered_json importance_json(const stand::Importance& importance) {
  return {{"relative_density", number(importance.relative_density)},
          {"relative_frequency", number(importance.relative_frequency)},
          {"relative_dominance", number(importance.relative_dominance)},
          {"importance", number(importance.value)},
          {"plot_mean", number(importance.plot_mean)},
          {"plot_sd", number(importance.plot_sd)}};
}

ordered_json areas_json(const stand::StandReport& report) {
  ordered_json list = ordered_json::array();
  for (const stand::AreaReport& area : report.areas) {
    ordered_json entry{{"plot", text_or_null(area.area.name)}};
    entry.update(figures_json(area.figures));
    entry["clark_evans"] = clark_evans_json(area.clark_evans);
    list.push_back(std::move(entry));
  }
  return list;
}

ordered_json strata_json(const stand::StandReport& report) {
  ordered_json list = ordered_json::array();
  for (const stand::StratumFigures& stratum : report.strata) {
    list.push_back({{"stratum", text_or_null(stratum.name)},
                    {"plots", stratum.plots},
                    {"trees", stratum.trees},
                    {"sampled_ha", number(stratum.sampled_ha)},
                    {"area_ha", number(stratum.area_ha)},
                    {"stems", estimate_json(stratum.stems)},
                    {"basal_area_m2", estimate_json(stratum.basal_area_m2)}});
  }
  return list;
}

ordered_json species_json(const stand::StandReport& report) {
  ordered_json list = ordered_json::array();
  for (const stand::SpeciesRow& row : report.species) {
    ordered_json entry{{"species", text_or_null(row.species)}};
    entry.update(figures_json(row.figures));
    entry["basal_area_m2"] = number(row.basal_area_m2);
    entry["all"] = importance_json(row.all);
    entry["layers"] = ordered_json::object();
    for (std::size_t i = 0; i < row.layers.size(); ++i) {
      entry["layers"][report.layers.name_of(i)] = importance_json(row.layers[i]);
    }
    list.push_back(std::move(entry));
  }
  return list;
}

ordered_json diameters_json(const stand::StandReport& report) {
  ordered_json list = ordered_json::array();
  for (const stand::DiameterClass& diameters : report.diameters) {
    list.push_back({{"low_cm", diameters.low_cm},
                    {"high_cm", diameters.high_cm},
                    {"trees", diameters.trees},
                    {"stems_per_ha", number(diameters.stems_per_ha)},
                    {"basal_area_m2_per_ha", number(diameters.basal_area_m2_per_ha)}});
  }
  return list;
}

ordered_json unit_means_json(const stand::UnitSummary& summary,
                             const stand::StructuralUnits& units) {
  ordered_json result{{"trees", summary.trees},
                      {"core", summary.core_trees},
                      {"W", number(summary.W)},
                      {"M", number(summary.M)},
                      {"U", number(summary.U)},
                      {"C", number(summary.C)}};
  for (std::size_t i = 0; i < units.further.size(); ++i) {
    result[std::string(name_of(units.further[i].index))] = number(summary.further[i]);
  }
  return result;
}

ordered_json joint_json(const stand::NamedJointDistribution& joint) {
  ordered_json rows = ordered_json::array();
  const std::size_t classes = joint.distribution.neighbors + 1;
  for (std::size_t i = 0; i < classes; ++i) {
    ordered_json row = ordered_json::array();
    for (std::size_t j = 0; j < classes; ++j) row.push_back(number(joint.distribution.at(i, j)));
    rows.push_back(std::move(row));
  }
  return {{"rows", joint.first},
          {"columns", joint.second},
          {"trees", joint.distribution.trees},
          {"share", std::move(rows)}};
}

ordered_json structure_json(const stand::StandReport& report) {
  if (!report.units) return nullptr;
  ordered_json species = ordered_json::object();
  for (const stand::UnitSummary& summary : report.unit_means_by_species) {
    species[summary.species] = unit_means_json(summary, *report.units);
  }
  ordered_json joint = ordered_json::array();
  for (const stand::NamedJointDistribution& one : report.joint) joint.push_back(joint_json(one));
  return {{"neighbors", report.units->neighbors},
          {"alpha_deg", report.units->alpha0_deg},
          {"all", unit_means_json(*report.unit_means, *report.units)},
          {"species", std::move(species)},
          {"joint", std::move(joint)}};
}

}  // namespace

nlohmann::ordered_json stand_json(const stand::StandReport& report) {
  return {{"dominant_trees_per_ha", report.dominant_trees_per_ha},
          {"quadrat_m", report.quadrat_m > 0.0 ? ordered_json(report.quadrat_m) : nullptr},
          {"areas", areas_json(report)},
          {"all", figures_json(report.all)},
          {"strata", strata_json(report)},
          {"species", species_json(report)},
          {"diameters", diameters_json(report)},
          {"structure", structure_json(report)}};
}

}  // namespace silvafit::cli
