// SPDX-License-Identifier: MIT
// A stand report as tables.
#include <algorithm>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/stand/stand_json.hpp"

namespace silvafit::stand {
namespace {

/// Builder of a table: columns from a list of entries.
template <class Entry>
class Columns {
 public:
  explicit Columns(const std::vector<Entry>& entries) : entries_(entries), table_(entries.size()) {}

  void text(const std::string& name, const std::function<std::string(const Entry&)>& value) {
    data::TextColumn column;
    for (const Entry& entry : entries_) column.append(value(entry));
    table_.set(name, std::move(column));
  }
  void number(const std::string& name, const std::function<double(const Entry&)>& value) {
    std::vector<double> column;
    for (const Entry& entry : entries_) column.push_back(value(entry));
    table_.set(name, std::move(column));
  }
  data::Table table() && { return std::move(table_); }

 private:
  const std::vector<Entry>& entries_;
  data::Table table_;
};

template <class Entry>
void add_figures(Columns<Entry>& columns, const std::vector<std::string>& quantities) {
  using Figures = StandFigures;
  const auto add = [&columns](const std::string& name, double Figures::*member) {
    columns.number(name, [member](const Entry& entry) { return entry.figures.*member; });
  };
  columns.number("trees",
                 [](const Entry& entry) { return static_cast<double>(entry.figures.trees); });
  add("area_ha", &Figures::area_ha);
  add("stems_per_ha", &Figures::stems_per_ha);
  add("basal_area_m2_per_ha", &Figures::basal_area_m2_per_ha);
  add("mean_dbh_cm", &Figures::mean_dbh_cm);
  add("sd_dbh_cm", &Figures::sd_dbh_cm);
  add("quadratic_mean_dbh_cm", &Figures::quadratic_mean_dbh_cm);
  add("mean_height_m", &Figures::mean_height_m);
  add("sd_height_m", &Figures::sd_height_m);
  add("lorey_height_m", &Figures::lorey_height_m);
  add("dominant_height_m", &Figures::dominant_height_m);
  add("dominant_lorey_height_m", &Figures::dominant_lorey_height_m);
  add("dominant_dbh_cm", &Figures::dominant_dbh_cm);
  add("crown_cover_percent", &Figures::crown_cover_percent);
  for (std::size_t i = 0; i < quantities.size(); ++i) {
    columns.number(quantities[i] + "_per_ha",
                   [i](const Entry& entry) { return entry.figures.quantities_per_ha[i]; });
  }
}

data::Table areas_table(const StandReport& report) {
  using Area = AreaReport;
  Columns<Area> columns(report.areas);
  columns.text("plot", [](const Area& area) { return area.area.name; });
  const auto has_stratum = [](const Area& area) { return !area.stratum.empty(); };
  if (std::ranges::any_of(report.areas, has_stratum)) {
    columns.text("stratum", [](const Area& area) { return area.stratum; });
  }
  add_figures(columns, report.quantities);
  const auto add = [&columns](const std::string& name, double ClarkEvans::*member) {
    columns.number(name, [member](const Area& area) {
      return area.clark_evans ? (*area.clark_evans).*member : data::kMissing;
    });
  };
  add("clark_evans_R", &ClarkEvans::R);
  add("clark_evans_R_donnelly", &ClarkEvans::R_donnelly);
  add("clark_evans_p_donnelly", &ClarkEvans::p_donnelly);
  return std::move(columns).table();
}

/// Estimates with standard errors.
template <class Entry>
void add_estimates(Columns<Entry>& columns,
                   const std::vector<std::string>& quantities,
                   const std::function<const StratumFigures&(const Entry&)>& figures) {
  using Stratum = StratumFigures;
  const auto number = [&](const std::string& name, std::function<double(const Stratum&)> value) {
    columns.number(name, [figures, value = std::move(value)](const Entry& entry) {
      return value(figures(entry));
    });
  };
  number("trees", [](const Stratum& stratum) { return static_cast<double>(stratum.trees); });
  using Pick = std::function<const Estimate&(const Stratum&)>;
  const auto add = [&](const std::string& name, const Pick& pick) {
    const auto part = [&](const std::string& suffix, double Estimate::*member) {
      number(name + suffix,
             [pick, member](const Stratum& stratum) { return pick(stratum).*member; });
    };
    part("_per_ha", &Estimate::per_ha);
    part("_per_ha_se", &Estimate::standard_error);
    part("_total", &Estimate::total);
    part("_total_se", &Estimate::total_standard_error);
  };
  add("stems", [](const Stratum& stratum) -> const Estimate& { return stratum.stems; });
  add("basal_area_m2",
      [](const Stratum& stratum) -> const Estimate& { return stratum.basal_area_m2; });
  const auto add_mean = [&](const std::string& name,
                            const std::function<const Mean&(const Stratum&)>& pick) {
    number(name, [pick](const Stratum& stratum) { return pick(stratum).value; });
    number(name + "_se", [pick](const Stratum& stratum) { return pick(stratum).standard_error; });
  };
  for (std::size_t i = 0; i < quantities.size(); ++i) {
    add(quantities[i],
        [i](const Stratum& stratum) -> const Estimate& { return stratum.quantities[i]; });
    add_mean(quantities[i] + "_of_tree",
             [i](const Stratum& stratum) -> const Mean& { return stratum.quantities_of_tree[i]; });
  }
  add_mean("mean_height_m",
           [](const Stratum& stratum) -> const Mean& { return stratum.mean_height_m; });
  add_mean("quadratic_mean_dbh_cm",
           [](const Stratum& stratum) -> const Mean& { return stratum.quadratic_mean_dbh_cm; });
}

data::Table strata_table(const StandReport& report) {
  using Stratum = StratumFigures;
  Columns<Stratum> columns(report.strata);
  columns.text("stratum", [](const Stratum& stratum) {
    return stratum.kind == Stratum::Kind::kAll ? "all" : stratum.name;
  });
  columns.number("plots",
                 [](const Stratum& stratum) { return static_cast<double>(stratum.plots); });
  columns.number("sampled_ha", [](const Stratum& stratum) { return stratum.sampled_ha; });
  columns.number("area_ha", [](const Stratum& stratum) { return stratum.area_ha; });
  add_estimates<Stratum>(
      columns, report.quantities, [](const Stratum& s) -> const Stratum& { return s; });
  // A stratum may be called "all".
  columns.text("kind", [](const Stratum& stratum) { return std::string(kind_of(stratum)); });
  return std::move(columns).table();
}

data::Table domains_table(const StandReport& report) {
  Columns<DomainFigures> columns(report.domains);
  for (std::size_t i = 0; i < report.by.size(); ++i) {
    columns.text(report.by[i], [i](const DomainFigures& domain) { return domain.labels[i]; });
  }
  add_estimates<DomainFigures>(
      columns, report.quantities, [](const DomainFigures& domain) -> const StratumFigures& {
        return domain.figures;
      });
  return std::move(columns).table();
}

data::Table species_table(const StandReport& report) {
  using Row = SpeciesRow;
  Columns<Row> columns(report.species);
  columns.text("species", [](const Row& row) { return row.species; });
  add_figures(columns, report.quantities);
  columns.number("basal_area_m2", [](const Row& row) { return row.basal_area_m2; });
  using Pick = std::function<const Importance&(const Row&)>;
  const auto add = [&columns](const std::string& prefix, const Pick& pick) {
    const auto part = [&](const std::string& name, double Importance::*member) {
      columns.number(prefix + name, [pick, member](const Row& row) { return pick(row).*member; });
    };
    part("importance", &Importance::value);
    part("importance_plot_mean", &Importance::plot_mean);
    part("importance_plot_sd", &Importance::plot_sd);
    part("relative_density", &Importance::relative_density);
    part("relative_frequency", &Importance::relative_frequency);
    part("relative_dominance", &Importance::relative_dominance);
  };
  add("", [](const Row& row) -> const Importance& { return row.all; });
  const std::size_t layers = report.species.empty() ? 0 : report.species.front().layers.size();
  for (std::size_t i = 0; i < layers; ++i) {
    add(report.layers.name_of(i) + "_",
        [i](const Row& row) -> const Importance& { return row.layers[i]; });
  }
  return std::move(columns).table();
}

data::Table diameters_table(const StandReport& report) {
  using Class = DiameterClass;
  Columns<Class> columns(report.diameters);
  columns.number("low_cm", [](const Class& one) { return one.low_cm; });
  columns.number("high_cm", [](const Class& one) { return one.high_cm; });
  columns.number("trees", [](const Class& one) { return static_cast<double>(one.trees); });
  columns.number("stems_per_ha", [](const Class& one) { return one.stems_per_ha; });
  columns.number("basal_area_m2_per_ha", [](const Class& one) { return one.basal_area_m2_per_ha; });
  return std::move(columns).table();
}

data::Table classes_table(const StandReport& report) {
  data::TextColumn first;
  data::TextColumn second;
  std::vector<double> first_value;
  std::vector<double> second_value;
  std::vector<double> share;
  for (const NamedJointDistribution& joint : report.joint) {
    const std::size_t n = joint.distribution.neighbors;
    const auto value = [n](std::size_t i) {
      return static_cast<double>(i) / static_cast<double>(n);
    };
    for (std::size_t i = 0; i <= n; ++i) {
      for (std::size_t j = 0; j <= n; ++j) {
        first.append(joint.first);
        second.append(joint.second);
        first_value.push_back(value(i));
        second_value.push_back(value(j));
        share.push_back(joint.distribution.at(i, j));
      }
    }
  }
  data::Table table(share.size());
  table.set("first", std::move(first));
  table.set("second", std::move(second));
  table.set("first_value", std::move(first_value));
  table.set("second_value", std::move(second_value));
  table.set("share", std::move(share));
  return table;
}

}  // namespace

std::string_view kind_of(const StratumFigures& stratum) {
  using Kind = StratumFigures::Kind;
  if (stratum.kind == Kind::kAll) return "all";
  return stratum.kind == Kind::kWithout ? "none" : "stratum";
}

std::vector<std::pair<std::string, data::Table>> tables_of(const StandReport& report) {
  std::vector<std::pair<std::string, data::Table>> tables;
  tables.emplace_back("plots", areas_table(report));
  tables.emplace_back("strata", strata_table(report));
  if (!report.by.empty()) tables.emplace_back("domains", domains_table(report));
  tables.emplace_back("species", species_table(report));
  tables.emplace_back("diameters", diameters_table(report));
  if (report.units) tables.emplace_back("classes", classes_table(report));
  return tables;
}

void write_stand(const Inventory& inventory,
                 const StandReport& report,
                 const std::filesystem::path& folder) {
  const ResultFolder results(folder);
  for (const auto& [name, table] : tables_of(report)) {
    data::write_csv_table(table, folder / (name + ".csv"));
  }
  if (!report.units) return;
  AtomicFile indices(folder / "indices.csv");
  write_structural_units(inventory, *report.units, indices.stream());
  indices.commit();
}

}  // namespace silvafit::stand
