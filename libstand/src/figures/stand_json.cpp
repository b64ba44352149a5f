// SPDX-License-Identifier: MIT
// A stand report as JSON.
#include "silvafit/stand/stand_json.hpp"

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "figures/figure_columns.hpp"
#include "silvafit/base/json_values.hpp"

namespace silvafit::stand {
namespace {

using nlohmann::ordered_json;

ordered_json figures_json(const StandFigures& figures, const std::vector<std::string>& names) {
  ordered_json result{{"trees", figures.trees}};
  for (const auto& [name, value] : kFigureColumns) {
    result[std::string(name)] = number_or_null(figures.*value);
  }
  result["trees_without_crown_width"] = figures.trees_without_crown_width;
  result["dominant_trees"] = figures.dominant_trees;
  result["dominant_trees_without_height"] = figures.dominant_trees_without_height;
  for (std::size_t i = 0; i < names.size(); ++i) {
    result[names[i] + "_per_ha"] = number_or_null(figures.quantities_per_ha[i]);
    result["trees_without_" + names[i]] = figures.trees_without_quantity[i];
  }
  return result;
}

ordered_json clark_evans_json(const std::optional<ClarkEvans>& result) {
  if (!result) return nullptr;
  return {{"mean_distance_m", number_or_null(result->mean_distance_m)},
          {"R", number_or_null(result->R)},
          {"z", number_or_null(result->z)},
          {"p", number_or_null(result->p)},
          {"R_donnelly", number_or_null(result->R_donnelly)},
          {"z_donnelly", number_or_null(result->z_donnelly)},
          {"p_donnelly", number_or_null(result->p_donnelly)}};
}

ordered_json mean_json(const Mean& mean) {
  return {{"value", number_or_null(mean.value)},
          {"standard_error", number_or_null(mean.standard_error)}};
}

ordered_json importance_json(const Importance& importance) {
  return {{"relative_density", number_or_null(importance.relative_density)},
          {"relative_frequency", number_or_null(importance.relative_frequency)},
          {"relative_dominance", number_or_null(importance.relative_dominance)},
          {"importance", number_or_null(importance.value)},
          {"plot_mean", number_or_null(importance.plot_mean)},
          {"plot_sd", number_or_null(importance.plot_sd)}};
}

ordered_json areas_json(const StandReport& report) {
  ordered_json list = ordered_json::array();
  for (const AreaReport& area : report.areas) {
    ordered_json entry{{"plot", text_or_null(area.area.name)},
                       {"stratum", text_or_null(area.stratum)}};
    entry.update(figures_json(area.figures, report.quantities));
    entry["clark_evans"] = clark_evans_json(area.clark_evans);
    list.push_back(std::move(entry));
  }
  return list;
}

ordered_json estimates_json(const StratumFigures& figures, const std::vector<std::string>& names) {
  ordered_json result{{"trees", figures.trees},
                      {"stems", json_of(figures.stems)},
                      {"basal_area_m2", json_of(figures.basal_area_m2)},
                      {"mean_height_m", mean_json(figures.mean_height_m)},
                      {"quadratic_mean_dbh_cm", mean_json(figures.quadratic_mean_dbh_cm)}};
  for (std::size_t i = 0; i < names.size(); ++i) {
    result[names[i]] = json_of(figures.quantities[i]);
    result[names[i] + "_of_tree"] = mean_json(figures.quantities_of_tree[i]);
  }
  return result;
}

ordered_json strata_json(const StandReport& report) {
  ordered_json list = ordered_json::array();
  for (const StratumFigures& stratum : report.strata) {
    list.push_back({{"stratum", text_or_null(stratum.name)},
                    {"kind", name_of(stratum.kind)},
                    {"plots", stratum.plots},
                    {"sampled_ha", number_or_null(stratum.sampled_ha)},
                    {"area_ha", number_or_null(stratum.area_ha)}});
    list.back().update(estimates_json(stratum, report.quantities));
  }
  return list;
}

ordered_json domains_json(const StandReport& report) {
  ordered_json list = ordered_json::array();
  for (const DomainFigures& domain : report.domains) {
    ordered_json entry;
    for (std::size_t i = 0; i < report.by.size(); ++i) {
      entry["of"][report.by[i]] = text_or_null(domain.labels[i]);
    }
    entry.update(estimates_json(domain.figures, report.quantities));
    list.push_back(std::move(entry));
  }
  return list;
}

ordered_json species_json(const StandReport& report) {
  ordered_json list = ordered_json::array();
  for (const SpeciesRow& row : report.species) {
    ordered_json entry{{"species", text_or_null(row.species)}};
    entry.update(figures_json(row.figures, report.quantities));
    entry["basal_area_m2"] = number_or_null(row.basal_area_m2);
    entry["all"] = importance_json(row.all);
    entry["layers"] = ordered_json::object();
    for (std::size_t i = 0; i < row.layers.size(); ++i) {
      entry["layers"][report.layers.name_of(i)] = importance_json(row.layers[i]);
    }
    list.push_back(std::move(entry));
  }
  return list;
}

ordered_json diameters_json(const StandReport& report) {
  ordered_json list = ordered_json::array();
  for (const DiameterClass& diameters : report.diameters) {
    list.push_back({{"low_cm", diameters.low_cm},
                    {"high_cm", diameters.high_cm},
                    {"trees", diameters.trees},
                    {"stems_per_ha", number_or_null(diameters.stems_per_ha)},
                    {"basal_area_m2_per_ha", number_or_null(diameters.basal_area_m2_per_ha)}});
  }
  return list;
}

ordered_json joint_json(const NamedJointDistribution& joint) {
  ordered_json rows = ordered_json::array();
  const std::size_t classes = joint.distribution.neighbors + 1;
  for (std::size_t i = 0; i < classes; ++i) {
    ordered_json row = ordered_json::array();
    for (std::size_t j = 0; j < classes; ++j)
      row.push_back(number_or_null(joint.distribution.at(i, j)));
    rows.push_back(std::move(row));
  }
  return {{"rows", joint.first},
          {"columns", joint.second},
          {"trees", joint.distribution.trees},
          {"share", std::move(rows)}};
}

ordered_json structure_json(const StandReport& report) {
  if (!report.units) return nullptr;
  std::vector<FurtherIndex> further;
  for (const FurtherValues& values : report.units->further) further.push_back(values.index);
  ordered_json species = ordered_json::object();
  for (const UnitSummary& summary : report.unit_means_by_species) {
    species[summary.species] = json_of(summary, further);
  }
  ordered_json joint = ordered_json::array();
  for (const NamedJointDistribution& one : report.joint) joint.push_back(joint_json(one));
  return {{"neighbors", report.units->neighbors},
          {"alpha_deg", report.units->alpha0_deg},
          {"all", json_of(*report.unit_means, further)},
          {"species", std::move(species)},
          {"joint", std::move(joint)}};
}

}  // namespace

ordered_json json_of(const Estimate& estimate) {
  return {{"per_ha", number_or_null(estimate.per_ha)},
          {"standard_error", number_or_null(estimate.standard_error)},
          {"total", number_or_null(estimate.total)},
          {"total_standard_error", number_or_null(estimate.total_standard_error)}};
}

ordered_json json_of(const UnitSummary& summary, const std::vector<FurtherIndex>& further) {
  ordered_json result{{"trees", summary.trees},
                      {"core", summary.core_trees},
                      {"W", number_or_null(summary.W)},
                      {"M", number_or_null(summary.M)},
                      {"U", number_or_null(summary.U)},
                      {"C", number_or_null(summary.C)}};
  for (std::size_t i = 0; i < summary.further.size(); ++i) {
    result[word_of(further[i])] = number_or_null(summary.further[i]);
  }
  return result;
}

ordered_json json_of(const StandReport& report) {
  return {{"dominant_trees_per_ha", report.dominant_trees_per_ha},
          {"quadrat_m", report.quadrat_m > 0.0 ? ordered_json(report.quadrat_m) : nullptr},
          {"areas", areas_json(report)},
          {"all", figures_json(report.all, report.quantities)},
          {"strata", strata_json(report)},
          {"domains", domains_json(report)},
          {"species", species_json(report)},
          {"diameters", diameters_json(report)},
          {"structure", structure_json(report)}};
}

}  // namespace silvafit::stand
