// SPDX-License-Identifier: MIT
// A stand report as text tables.
#include "stand_output.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "silvafit/stand/growth.hpp"
#include "standard_output.hpp"
#include "text_table.hpp"

namespace silvafit::cli {
namespace {

void print_areas(const stand::StandReport& report) {
  std::vector<std::string> header{"plot",
                                  "trees",
                                  "ha",
                                  "N/ha",
                                  "G m2/ha",
                                  "QMD cm",
                                  "mean h",
                                  "dom. h",
                                  "cover %",
                                  "R",
                                  "R Donnelly"};
  for (const std::string& name : report.quantities) header.push_back(name + "/ha");
  TextTable table(header);
  const auto add = [&table](const std::string& name,
                            const stand::StandFigures& figures,
                            const std::optional<stand::ClarkEvans>& pattern) {
    std::vector<std::string> row{name,
                                 std::to_string(figures.trees),
                                 rounded(figures.area_ha, 4),
                                 rounded(figures.stems_per_ha),
                                 rounded(figures.basal_area_m2_per_ha),
                                 rounded(figures.quadratic_mean_dbh_cm),
                                 rounded(figures.mean_height_m),
                                 rounded(figures.dominant_height_m),
                                 rounded(figures.crown_cover_percent),
                                 pattern ? rounded(pattern->R, 3) : "-",
                                 pattern ? rounded(pattern->R_donnelly, 3) : "-"};
    for (const double per_ha : figures.quantities_per_ha) row.push_back(rounded(per_ha));
    table.add(std::move(row));
  };
  for (const stand::AreaReport& area : report.areas) {
    add(name_or(area.area.name, "stand"), area.figures, area.clark_evans);
  }
  if (report.areas.size() > 1) add("all", report.all, std::nullopt);
  print_text("Plots (dominant height: the {} thickest trees per ha)\n",
             report.dominant_trees_per_ha);
  table.print();
}

/// Estimates with standard errors, of strata or of kinds of trees.
class EstimateTable {
 public:
  EstimateTable(const stand::StandReport& report, std::vector<std::string> labels)
      : has_totals_(std::isfinite(report.strata.back().area_ha)),
        table_(header(report, std::move(labels))) {}

  void add(std::vector<std::string> row, const stand::StratumFigures& figures) {
    row.push_back(std::to_string(figures.trees));
    row.push_back(per_ha(figures.stems));
    row.push_back(per_ha(figures.basal_area_m2, 2));
    row.push_back(text_of(figures.quadratic_mean_dbh_cm));
    row.push_back(text_of(figures.mean_height_m));
    for (const stand::Estimate& quantity : figures.quantities) row.push_back(per_ha(quantity));
    if (has_totals_) {
      row.push_back(rounded(figures.area_ha, 2));
      row.push_back(total(figures.stems));
      row.push_back(total(figures.basal_area_m2));
      for (const stand::Estimate& quantity : figures.quantities) row.push_back(total(quantity));
    }
    table_.add(std::move(row));
  }
  void print() const { table_.print(); }

 private:
  std::vector<std::string> header(const stand::StandReport& report,
                                  std::vector<std::string> names) const {
    names.insert(names.end(), {"trees", "N/ha", "G m2/ha", "QMD cm", "mean h"});
    for (const std::string& name : report.quantities) names.push_back(name + "/ha");
    if (!has_totals_) return names;
    names.insert(names.end(), {"ha", "N", "G m2"});
    names.insert(names.end(), report.quantities.begin(), report.quantities.end());
    return names;
  }
  static std::string per_ha(const stand::Estimate& estimate, int digits = 1) {
    return with_error(estimate.per_ha, estimate.standard_error, digits);
  }
  static std::string total(const stand::Estimate& estimate) {
    return with_error(estimate.total, estimate.total_standard_error, 0);
  }
  static std::string text_of(const stand::Mean& mean) {
    return with_error(mean.value, mean.standard_error);
  }

  bool has_totals_;
  TextTable table_;
};

void print_strata(const stand::StandReport& report) {
  EstimateTable table(report, {"stratum", "plots"});
  for (const stand::StratumFigures& stratum : report.strata) {
    const bool is_all = stratum.kind == stand::StratumFigures::Kind::kAll;
    table.add({is_all ? "all" : name_or(stratum.name, "(none)"), std::to_string(stratum.plots)},
              stratum);
  }
  print_text("Strata, with standard errors over plots\n");
  table.print();
}

void print_domains(const stand::StandReport& report) {
  if (report.by.empty()) return;
  EstimateTable table(report, report.by);
  for (const stand::DomainFigures& domain : report.domains) {
    std::vector<std::string> labels;
    for (const std::string& label : domain.labels) labels.push_back(name_or(label, "(none)"));
    table.add(std::move(labels), domain.figures);
  }
  print_text("Trees by {}, with standard errors over plots\n", fmt::join(report.by, " and "));
  table.print();
}

void print_species(const stand::StandReport& report) {
  std::vector<std::string> header{"species", "N/ha"};
  const std::size_t layers = report.species.empty() ? 0 : report.species.front().layers.size();
  for (std::size_t i = layers; i > 0; --i) header.push_back("IV " + report.layers.name_of(i - 1));
  header.insert(header.end(), {"IV %", "dbh cm", "h m", "G m2", "dom. h"});
  TextTable table(header);
  for (const stand::SpeciesRow& row : report.species) {
    std::vector<std::string> cells{name_or(row.species, "(none)"),
                                   rounded(row.figures.stems_per_ha)};
    for (std::size_t i = layers; i > 0; --i) {
      cells.push_back(with_error(row.layers[i - 1].value, row.layers[i - 1].plot_sd, 2));
    }
    cells.push_back(with_error(row.all.value, row.all.plot_sd, 2));
    cells.push_back(with_error(row.figures.mean_dbh_cm, row.figures.sd_dbh_cm, 2));
    cells.push_back(with_error(row.figures.mean_height_m, row.figures.sd_height_m, 2));
    cells.push_back(rounded(row.basal_area_m2, 2));
    cells.push_back(rounded(row.figures.dominant_height_m));
    table.add(std::move(cells));
  }
  print_text(
      "Species (IV: importance value in %, +- standard deviation over plots; frequency from {})\n",
      report.quadrat_m > 0.0 ? fmt::format("quadrats of {} m", report.quadrat_m) : "plots");
  table.print();
}

void print_diameters(const stand::StandReport& report) {
  TextTable table({"dbh cm", "trees", "N/ha", "G m2/ha"});
  for (const stand::DiameterClass& one : report.diameters) {
    table.add({fmt::format("{}-{}", one.low_cm, one.high_cm),
               std::to_string(one.trees),
               rounded(one.stems_per_ha),
               rounded(one.basal_area_m2_per_ha, 2)});
  }
  print_text("Diameters\n");
  table.print();
}

void print_structure(const stand::StandReport& report) {
  if (!report.units) return;
  std::vector<std::string> header{"species", "core trees", "W", "M", "U", "C"};
  for (const stand::FurtherValues& one : report.units->further) {
    header.emplace_back(name_of(one.index));
  }
  TextTable table(header);
  const auto add = [&table](const std::string& name, const stand::UnitSummary& summary) {
    std::vector<std::string> row{name, std::to_string(summary.core_trees)};
    for (const double mean : {summary.W, summary.M, summary.U, summary.C}) {
      row.push_back(rounded(mean, 3));
    }
    for (const double mean : summary.further) row.push_back(rounded(mean, 3));
    table.add(std::move(row));
  };
  for (const stand::UnitSummary& summary : report.unit_means_by_species) {
    add(name_or(summary.species, "(none)"), summary);
  }
  add("all", *report.unit_means);
  print_text("Structure, means over core trees ({} neighbors)\n", report.units->neighbors);
  table.print();
}

void print_joint(const stand::StandReport& report) {
  for (const stand::NamedJointDistribution& joint : report.joint) {
    const std::size_t classes = joint.distribution.neighbors + 1;
    const auto class_name = [classes](std::size_t i) {
      return fmt::format("{:.3g}", static_cast<double>(i) / static_cast<double>(classes - 1));
    };
    std::vector<std::string> header{joint.first + " \\ " + joint.second};
    for (std::size_t i = 0; i < classes; ++i) header.push_back(class_name(i));
    TextTable table(header);
    for (std::size_t i = 0; i < classes; ++i) {
      std::vector<std::string> row{class_name(i)};
      for (std::size_t j = 0; j < classes; ++j) {
        row.push_back(rounded(100.0 * joint.distribution.at(i, j)));
      }
      table.add(std::move(row));
    }
    print_text(
        "{} and {}: % of {} core trees\n", joint.first, joint.second, joint.distribution.trees);
    table.print();
  }
}

using stand::GrowthPart;

constexpr std::array<GrowthPart, 8> kShownParts{GrowthPart::kStart,
                                                GrowthPart::kEnd,
                                                GrowthPart::kNetChange,
                                                GrowthPart::kSurvivorGrowth,
                                                GrowthPart::kIngrowth,
                                                GrowthPart::kMortality,
                                                GrowthPart::kCut,
                                                GrowthPart::kNotFound};

/// Column headings; changes are per year.
std::vector<std::string> header_of(std::vector<std::string> first) {
  for (const char* name : {"start",
                           "end",
                           "net /yr",
                           "survivors /yr",
                           "ingrowth /yr",
                           "mortality /yr",
                           "cut /yr",
                           "not found /yr"}) {
    first.emplace_back(name);
  }
  return first;
}

void print_fates(const stand::GrowthReport& report) {
  std::map<std::string_view, std::size_t> trees;
  for (const stand::TreeGrowth& tree : report.trees) ++trees[stand::name_of(tree.fate)];
  print_text("Trees by fate in a period:");
  for (const auto& [fate, count] : trees) print_text(" {} {}", count, fate);
  print_text("\n\n");
}

void print_growth_of_plots(const stand::GrowthReport& report, std::size_t value) {
  TextTable table(header_of({"plot", "from", "to", "years"}));
  for (const stand::PlotGrowth& plot : report.plots) {
    std::vector<std::string> row{plot.plot, plot.from, plot.to, rounded(plot.years)};
    for (const GrowthPart part : kShownParts) {
      row.push_back(rounded(plot.values[value][static_cast<std::size_t>(part)], 2));
    }
    table.add(std::move(row));
  }
  print_text("{} per ha, by plot\n", report.values[value]);
  table.print();
}

void print_growth_of_strata(const stand::GrowthReport& report, std::size_t value) {
  if (report.strata.empty()) return;
  TextTable table(header_of({"stratum", "period", "plots"}));
  for (const stand::StratumGrowth& stratum : report.strata) {
    const bool is_all = stratum.kind == stand::StratumFigures::Kind::kAll;
    std::vector<std::string> row{is_all ? "all" : name_or(stratum.name, "(none)"),
                                 std::to_string(stratum.period),
                                 std::to_string(stratum.plots)};
    for (const GrowthPart part : kShownParts) {
      const stand::Estimate& estimate = stratum.values[value][static_cast<std::size_t>(part)];
      row.push_back(with_error(estimate.per_ha, estimate.standard_error, 2));
    }
    table.add(std::move(row));
  }
  print_text("{} per ha, by stratum, with standard errors over plots\n", report.values[value]);
  table.print();
}

void print_thinning(const stand::Thinning& thinning) {
  TextTable table({"plot",
                   "N/ha",
                   "removed",
                   "after",
                   "G m2/ha",
                   "removed",
                   "after",
                   "QMD cm",
                   "removed",
                   "after",
                   "dom. h",
                   "after"});
  const auto add = [&table](const stand::ThinningFigures& plot, const std::string& name) {
    std::vector<std::string> row{name};
    for (double stand::StandFigures::*const value : {&stand::StandFigures::stems_per_ha,
                                                     &stand::StandFigures::basal_area_m2_per_ha,
                                                     &stand::StandFigures::quadratic_mean_dbh_cm}) {
      for (const stand::StandFigures* const stage : {&plot.before, &plot.removed, &plot.after}) {
        row.push_back(rounded(stage->*value));
      }
    }
    row.push_back(rounded(plot.before.dominant_height_m));
    row.push_back(rounded(plot.after.dominant_height_m));
    table.add(std::move(row));
  };
  for (const stand::ThinningFigures& plot : thinning.plots) add(plot, name_or(plot.name, "stand"));
  if (thinning.plots.size() > 1) add(thinning.all, "all");
  print_text("Thinning: before, removed trees, after\n");
  table.print();
}

void print_sites(const std::vector<study::SiteIndex>& sites) {
  TextTable table({"plot", "age", "dom. h", "site index m"});
  for (const study::SiteIndex& site : sites) {
    table.add({name_or(site.plot, "stand"),
               rounded(site.age),
               rounded(site.dominant_m),
               rounded(site.at_base_age)});
  }
  print_text("Site index\n");
  table.print();
}

}  // namespace

void print_stand(const study::StandSummary& summary) {
  const stand::StandReport& report = summary.report;
  print_areas(report);
  print_strata(report);
  print_domains(report);
  print_species(report);
  print_diameters(report);
  if (summary.thinning) print_thinning(*summary.thinning);
  if (!summary.sites.empty()) print_sites(summary.sites);
  print_structure(report);
  print_joint(report);
}

void print_growth(const stand::GrowthReport& report) {
  print_fates(report);
  for (std::size_t value = 0; value < report.values.size(); ++value) {
    print_growth_of_plots(report, value);
    print_growth_of_strata(report, value);
  }
}

}  // namespace silvafit::cli
