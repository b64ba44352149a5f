// SPDX-License-Identifier: MIT
// A stand report as tables.
#include <algorithm>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "figures/figure_columns.hpp"
#include "silvafit/data/list_table.hpp"
#include "silvafit/stand/stand_json.hpp"

namespace silvafit::stand {
namespace {

using data::ListTable;

template <class Entry>
void add_figures(ListTable<Entry>& table, const std::vector<std::string>& quantities) {
  table.add("trees", [](const Entry& entry) { return entry.figures.trees; });
  for (const FigureColumn& column : kFigureColumns) {
    table.add(column.name, [&column](const Entry& entry) { return entry.figures.*column.value; });
  }
  for (std::size_t i = 0; i < quantities.size(); ++i) {
    table.add(quantities[i] + "_per_ha",
              [i](const Entry& entry) { return entry.figures.quantities_per_ha[i]; });
  }
}

data::Table areas_table(const StandReport& report) {
  ListTable<AreaReport> table(report.areas);
  table.add("plot", [](const AreaReport& area) { return area.area.name; });
  const auto has_stratum = [](const AreaReport& area) { return !area.stratum.empty(); };
  if (std::ranges::any_of(report.areas, has_stratum)) table.add("stratum", &AreaReport::stratum);
  add_figures(table, report.quantities);
  const auto add = [&table](std::string_view name, double ClarkEvans::*member) {
    table.add(name, [member](const AreaReport& area) {
      return area.clark_evans ? (*area.clark_evans).*member : data::kMissing;
    });
  };
  add("clark_evans_R", &ClarkEvans::R);
  add("clark_evans_R_donnelly", &ClarkEvans::R_donnelly);
  add("clark_evans_p_donnelly", &ClarkEvans::p_donnelly);
  return std::move(table).table();
}

/// Estimates with standard errors.
/// \param figures  of an entry
template <class Entry, class Figures>
void add_estimates(ListTable<Entry>& table,
                   const std::vector<std::string>& quantities,
                   Figures figures) {
  const auto number = [&](const std::string& name, auto pick, auto member) {
    table.add(name, [figures, pick, member](const Entry& entry) {
      return std::invoke(pick, figures(entry)).*member;
    });
  };
  table.add("trees", [figures](const Entry& entry) { return figures(entry).trees; });
  const auto add = [&](const std::string& name, auto pick) {
    number(name + "_per_ha", pick, &Estimate::per_ha);
    number(name + "_per_ha_se", pick, &Estimate::standard_error);
    number(name + "_total", pick, &Estimate::total);
    number(name + "_total_se", pick, &Estimate::total_standard_error);
  };
  const auto add_mean = [&](const std::string& name, auto pick) {
    number(name, pick, &Mean::value);
    number(name + "_se", pick, &Mean::standard_error);
  };
  add("stems", &StratumFigures::stems);
  add("basal_area_m2", &StratumFigures::basal_area_m2);
  for (std::size_t i = 0; i < quantities.size(); ++i) {
    add(quantities[i], [i](const StratumFigures& stratum) { return stratum.quantities[i]; });
    add_mean(quantities[i] + "_of_tree",
             [i](const StratumFigures& stratum) { return stratum.quantities_of_tree[i]; });
  }
  add_mean("mean_height_m", &StratumFigures::mean_height_m);
  add_mean("quadratic_mean_dbh_cm", &StratumFigures::quadratic_mean_dbh_cm);
}

data::Table strata_table(const StandReport& report) {
  ListTable<StratumFigures> table(report.strata);
  table.add("stratum", [](const StratumFigures& stratum) {
    return stratum.kind == StratumFigures::Kind::kAll ? "all" : stratum.name;
  });
  table.add("plots", &StratumFigures::plots);
  table.add("sampled_ha", &StratumFigures::sampled_ha);
  table.add("area_ha", &StratumFigures::area_ha);
  add_estimates(table, report.quantities, std::identity());
  // A stratum may be called "all".
  table.add("kind", [](const StratumFigures& stratum) { return name_of(stratum.kind); });
  return std::move(table).table();
}

data::Table domains_table(const StandReport& report) {
  ListTable<DomainFigures> table(report.domains);
  for (std::size_t i = 0; i < report.by.size(); ++i) {
    table.add(report.by[i], [i](const DomainFigures& domain) { return domain.labels[i]; });
  }
  add_estimates(
      table, report.quantities, [](const DomainFigures& domain) -> const auto& {
        return domain.figures;
      });
  return std::move(table).table();
}

data::Table species_table(const StandReport& report) {
  ListTable<SpeciesRow> table(report.species);
  table.add("species", &SpeciesRow::species);
  add_figures(table, report.quantities);
  table.add("basal_area_m2", &SpeciesRow::basal_area_m2);
  const auto add = [&table](const std::string& prefix, auto pick) {
    const auto part = [&](const char* name, double Importance::*member) {
      table.add(prefix + name,
                [pick, member](const SpeciesRow& row) { return std::invoke(pick, row).*member; });
    };
    part("importance", &Importance::value);
    part("importance_plot_mean", &Importance::plot_mean);
    part("importance_plot_sd", &Importance::plot_sd);
    part("relative_density", &Importance::relative_density);
    part("relative_frequency", &Importance::relative_frequency);
    part("relative_dominance", &Importance::relative_dominance);
  };
  add("", &SpeciesRow::all);
  const std::size_t layers = report.species.empty() ? 0 : report.species.front().layers.size();
  for (std::size_t i = 0; i < layers; ++i) {
    add(report.layers.name_of(i) + "_", [i](const SpeciesRow& row) { return row.layers[i]; });
  }
  return std::move(table).table();
}

data::Table diameters_table(const StandReport& report) {
  ListTable<DiameterClass> table(report.diameters);
  table.add("low_cm", &DiameterClass::low_cm);
  table.add("high_cm", &DiameterClass::high_cm);
  table.add("trees", &DiameterClass::trees);
  table.add("stems_per_ha", &DiameterClass::stems_per_ha);
  table.add("basal_area_m2_per_ha", &DiameterClass::basal_area_m2_per_ha);
  return std::move(table).table();
}

/// A class of two indices.
struct JointClass {
  const NamedJointDistribution& joint;
  std::size_t first = 0;
  std::size_t second = 0;

  double value(std::size_t number) const {
    return static_cast<double>(number) / static_cast<double>(joint.distribution.neighbors);
  }
};

data::Table classes_table(const StandReport& report) {
  std::vector<JointClass> classes;
  for (const NamedJointDistribution& joint : report.joint) {
    for (std::size_t i = 0; i <= joint.distribution.neighbors; ++i) {
      for (std::size_t j = 0; j <= joint.distribution.neighbors; ++j) {
        classes.push_back({.joint = joint, .first = i, .second = j});
      }
    }
  }
  ListTable<JointClass> table(classes);
  table.add("first", [](const JointClass& one) { return one.joint.first; });
  table.add("second", [](const JointClass& one) { return one.joint.second; });
  table.add("first_value", [](const JointClass& one) { return one.value(one.first); });
  table.add("second_value", [](const JointClass& one) { return one.value(one.second); });
  table.add("share",
            [](const JointClass& one) { return one.joint.distribution.at(one.first, one.second); });
  return std::move(table).table();
}

/// Means of structural units by species, and of all trees.
data::Table structure_table(const StandReport& report) {
  std::vector<UnitSummary> means = report.unit_means_by_species;
  means.push_back(*report.unit_means);
  ListTable<UnitSummary> table(means);
  const UnitSummary* const all = &means.back();
  table.add("species", &UnitSummary::species);
  table.add("kind", [all](const UnitSummary& mean) {
    if (&mean == all) return "all";
    return mean.species.empty() ? "none" : "species";
  });
  table.add("trees", &UnitSummary::trees);
  table.add("core_trees", &UnitSummary::core_trees);
  table.add("W", &UnitSummary::W);
  table.add("M", &UnitSummary::M);
  table.add("U", &UnitSummary::U);
  table.add("C", &UnitSummary::C);
  for (std::size_t i = 0; i < report.units->further.size(); ++i) {
    table.add(word_of(report.units->further[i].index),
              [i](const UnitSummary& mean) { return mean.further[i]; });
  }
  return std::move(table).table();
}

}  // namespace

std::string_view name_of(StratumFigures::Kind kind) {
  if (kind == StratumFigures::Kind::kAll) return "all";
  return kind == StratumFigures::Kind::kWithout ? "none" : "stratum";
}

std::vector<std::pair<std::string, data::Table>> tables_of(const StandReport& report) {
  std::vector<std::pair<std::string, data::Table>> tables;
  tables.emplace_back("plots", areas_table(report));
  tables.emplace_back("strata", strata_table(report));
  if (!report.by.empty()) tables.emplace_back("domains", domains_table(report));
  tables.emplace_back("species", species_table(report));
  tables.emplace_back("diameters", diameters_table(report));
  if (report.units) {
    tables.emplace_back("structure", structure_table(report));
    tables.emplace_back("classes", classes_table(report));
  }
  return tables;
}

}  // namespace silvafit::stand
