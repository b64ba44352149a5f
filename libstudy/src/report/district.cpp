// SPDX-License-Identifier: MIT
// The part of the report for foresters: stand table, diameters and height curves.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "report/report_json.hpp"
#include "silvafit/base/json_values.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/fit/prediction.hpp"

namespace silvafit::study {
namespace {

using nlohmann::ordered_json;

/// Plots and species in one table, beyond which species are shown for all plots only.
constexpr std::size_t kMostRows = 200;
/// Significant digits of coefficients: heights agree to a millimeter.
constexpr int kDigits = 7;

std::string name_or(const std::string& name, const char* otherwise) {
  return name.empty() ? otherwise : name;
}

/// A value with its standard error, if it has one.
TableCell cell(double value, double error, int decimals) {
  if (std::isnan(value)) return {};
  if (!std::isfinite(error)) return value;
  return MarkedNumber{.value = value, .after = fmt::format(" \u00B1 {:.{}f}", error, decimals)};
}

std::vector<TableColumn> size_columns(const std::vector<std::string>& quantities) {
  std::vector<TableColumn> columns{{"trees", "Trees", ColumnKind::kCount},
                                   {"stems_per_ha", "N/ha", ColumnKind::kCount},
                                   {"basal_area_per_ha", "G/ha (m\u00B2)", ColumnKind::kPercent},
                                   {"quadratic_mean_dbh", "dg (cm)", ColumnKind::kPercent},
                                   {"dominant_dbh", "d100 (cm)", ColumnKind::kPercent},
                                   {"mean_height", "Mean height (m)", ColumnKind::kPercent},
                                   {"dominant_height", "h100 (m)", ColumnKind::kPercent}};
  for (const std::string& name : quantities) {
    const std::size_t line = name.rfind('_');
    std::string title = name.substr(0, line) + "/ha";
    if (line != std::string::npos) title += " (" + name.substr(line + 1) + ")";
    if (title.ends_with("m3)")) title.replace(title.size() - 2, 1, "\u00B3");
    title.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(title.front())));
    columns.push_back({name + "_per_ha", title, ColumnKind::kPercent});
  }
  return columns;
}

void add_figures(const stand::StandFigures& figures, TableRow& row) {
  const double trees = static_cast<double>(figures.trees);
  for (const double value : {trees,
                             std::round(figures.stems_per_ha),
                             figures.basal_area_m2_per_ha,
                             figures.quadratic_mean_dbh_cm,
                             figures.dominant_dbh_cm,
                             figures.mean_height_m,
                             figures.dominant_height_m}) {
    row.emplace_back(value);
  }
  for (const double value : figures.quantities_per_ha) row.emplace_back(value);
}

/// \param sizes  dominant diameter and height, which have no standard errors
void add_estimates(const stand::StratumFigures& figures,
                   const stand::StandFigures& sizes,
                   TableRow& row) {
  row.emplace_back(static_cast<double>(figures.trees));
  row.push_back(cell(std::round(figures.stems.per_ha), figures.stems.standard_error, 0));
  row.push_back(cell(figures.basal_area_m2.per_ha, figures.basal_area_m2.standard_error, 1));
  row.push_back(
      cell(figures.quadratic_mean_dbh_cm.value, figures.quadratic_mean_dbh_cm.standard_error, 1));
  row.emplace_back(sizes.dominant_dbh_cm);
  row.push_back(cell(figures.mean_height_m.value, figures.mean_height_m.standard_error, 1));
  row.emplace_back(sizes.dominant_height_m);
  for (const stand::Estimate& estimate : figures.quantities) {
    row.push_back(cell(estimate.per_ha, estimate.standard_error, 1));
  }
}

/// Removes columns without any value.
FormattedTable without_empty_columns(FormattedTable table) {
  const auto has_value = [](const TableCell& cell) {
    const auto* const number = std::get_if<double>(&cell);
    return number == nullptr ? !std::holds_alternative<std::monostate>(cell)
                             : std::isfinite(*number);
  };
  for (std::size_t i = table.columns.size(); i-- > 0;) {
    const auto has = [&](const TableRow& row) { return has_value(row[i]); };
    if (std::ranges::any_of(table.rows, has)) continue;
    const auto at = static_cast<std::ptrdiff_t>(i);
    table.columns.erase(table.columns.begin() + at);
    for (TableRow& row : table.rows) row.erase(row.begin() + at);
  }
  return table;
}

class District {
 public:
  explicit District(const StudyRecord& record)
      : record_(record), report_(*record.stand), inventory_(record.inventory.inventory) {}

  ordered_json json() const {
    ordered_json tables = ordered_json::array();
    tables.push_back(json_of(without_empty_columns(species_table())));
    if (report_.areas.size() > 1) {
      tables.push_back(json_of(without_empty_columns(plot_table())));
    }
    if (record_.thinning) tables.push_back(json_of(thinning_table()));
    if (!record_.sites.empty()) tables.push_back(json_of(site_table()));
    return {{"tables", std::move(tables)},
            {"diameters", diameters()},
            {"curves", curves()},
            {"left_out", left_out()}};
  }

 private:
  std::size_t plots() const { return report_.areas.size(); }
  /// Whether plots are parts of one window.
  bool is_stand() const { return plots() == 1 && report_.areas.front().area.name.empty(); }
  bool has_areas() const { return !std::isnan(report_.all.stems_per_ha); }
  FormattedTable species_table() const;
  FormattedTable plot_table() const;
  FormattedTable thinning_table() const;
  FormattedTable site_table() const;
  ordered_json diameters() const;
  ordered_json curves() const;
  ordered_json left_out() const;
  std::string volume_text() const {
    return record_.volume.empty() ? std::string() : " Volume: " + record_.volume + ".";
  }

  const StudyRecord& record_;
  const stand::StandReport& report_;
  const stand::Inventory& inventory_;
};

/// Species of all plots together, and all species.
FormattedTable District::species_table() const {
  const bool is_sample = std::isfinite(report_.strata.back().stems.standard_error);
  const std::string sizes =
      !has_areas()
          ? std::string(". Nothing is per hectare, because the area of plots is unknown.")
          : fmt::format("; d100, h100: of the {} thickest trees per ha of all or of the species.{}",
                        report_.dominant_trees_per_ha,
                        volume_text());
  FormattedTable table{
      .name = "stand",
      .caption = fmt::format("Stand table{}.{} dg: quadratic mean diameter{}",
                             is_stand() ? "" : " of " + counted(plots(), "plot", "plots"),
                             is_sample ? " \u00B1: standard error over plots." : "",
                             sizes),
      .columns = {{"species", "Species"}}};
  for (TableColumn& column : size_columns(report_.quantities)) {
    table.columns.push_back(std::move(column));
  }
  TableRow all{std::string("all")};
  if (has_areas()) {
    add_estimates(report_.strata.back(), report_.all, all);
  } else {
    add_figures(report_.all, all);
  }
  table.rows.push_back(std::move(all));
  for (const stand::SpeciesRow& species : report_.species) {
    TableRow row{name_or(species.species, "(none)")};
    const auto domain = std::ranges::find_if(report_.domains, [&](const stand::DomainFigures& one) {
      return one.labels == std::vector<std::string>{species.species};
    });
    if (domain == report_.domains.end() || !has_areas()) {
      add_figures(species.figures, row);
    } else {
      add_estimates(domain->figures, species.figures, row);
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// Each plot, with its species if there are not too many rows.
FormattedTable District::plot_table() const {
  FormattedTable table{.name = "plots",
                       .caption = "Stand table of the plots and their species",
                       .columns = {{"plot", "Plot"}, {"species", "Species"}}};
  for (TableColumn& column : size_columns(report_.quantities)) {
    table.columns.push_back(std::move(column));
  }
  const bool has_species = report_.areas.size() * (1 + report_.species.size()) <= kMostRows;
  for (const stand::AreaReport& area : report_.areas) {
    const std::string plot = name_or(area.area.name, "stand");
    TableRow row{plot, std::string("all")};
    add_figures(area.figures, row);
    table.rows.push_back(std::move(row));
    if (!has_species) continue;
    std::map<std::string, std::vector<std::size_t>> trees_of;
    for (const std::size_t tree : area.area.trees) {
      trees_of[std::string(inventory_.species[tree])].push_back(tree);
    }
    if (trees_of.size() < 2) continue;
    for (const auto& [species, trees] : trees_of) {
      TableRow own{plot, name_or(species, "(none)")};
      add_figures(
          stand::stand_figures(inventory_, trees, area.area.area_m2, report_.dominant_trees_per_ha),
          own);
      table.rows.push_back(std::move(own));
    }
  }
  return table;
}

/// The plots before the thinning, the removed trees, and the plots after it.
FormattedTable District::thinning_table() const {
  using Figures = stand::StandFigures;
  struct Value {
    const char* name;
    const char* title;
    ColumnKind kind;
    double Figures::*member;
    bool is_of_removed;
  };
  static constexpr std::array kValues{
      Value{"stems_per_ha", "N/ha", ColumnKind::kCount, &Figures::stems_per_ha, true},
      Value{"basal_area_per_ha",
            "G/ha (m\u00B2)",
            ColumnKind::kPercent,
            &Figures::basal_area_m2_per_ha,
            true},
      Value{"quadratic_mean_dbh",
            "dg (cm)",
            ColumnKind::kPercent,
            &Figures::quadratic_mean_dbh_cm,
            true},
      Value{
          "dominant_height", "h100 (m)", ColumnKind::kPercent, &Figures::dominant_height_m, false}};
  FormattedTable table{.name = "thinning",
                       .caption =
                           "The stand before the thinning, the removed trees, and the stand "
                           "after it",
                       .columns = {{"plot", "Plot"}}};
  for (const Value& value : kValues) {
    for (const std::string stage : {"before", "removed", "after"}) {
      if (stage == "removed" && !value.is_of_removed) continue;
      table.columns.push_back(
          {value.name + ("_" + stage), value.title + (", " + stage), value.kind});
    }
  }
  const auto add = [&table](const stand::ThinningFigures& plot, const char* unnamed) {
    TableRow row{name_or(plot.name, unnamed)};
    for (const Value& value : kValues) {
      row.emplace_back(plot.before.*value.member);
      if (value.is_of_removed) row.emplace_back(plot.removed.*value.member);
      row.emplace_back(plot.after.*value.member);
    }
    table.rows.push_back(std::move(row));
  };
  for (const stand::ThinningFigures& plot : record_.thinning->plots) add(plot, "stand");
  if (record_.thinning->plots.size() > 1) add(record_.thinning->all, "all");
  return table;
}

FormattedTable District::site_table() const {
  FormattedTable table{.name = "sites",
                       .caption = "Site index: the dominant height at the base age of the curve",
                       .columns = {{"plot", "Plot"},
                                   {"age", "Age", ColumnKind::kPercent},
                                   {"dominant_height", "h100 (m)", ColumnKind::kPercent},
                                   {"site_index", "Site index (m)", ColumnKind::kPercent}}};
  for (const SiteIndex& site : record_.sites) {
    table.rows.push_back(
        {name_or(site.plot, "stand"), site.age, site.dominant_m, site.at_base_age});
  }
  return table;
}

ordered_json District::diameters() const {
  ordered_json classes = ordered_json::array();
  for (const stand::DiameterClass& one : report_.diameters) {
    classes.push_back({{"low", one.low_cm},
                       {"high", one.high_cm},
                       {"trees", one.trees},
                       {"stems_per_ha", number_or_null(one.stems_per_ha)},
                       {"basal_area_per_ha", number_or_null(one.basal_area_m2_per_ha)}});
  }
  return classes;
}

ordered_json District::curves() const {
  constexpr int kPoints = 40;
  ordered_json list = ordered_json::array();
  for (const HeightCurve& curve : record_.height_curves) {
    const fit::FittedModel& fit = curve.fit;
    const auto range = std::ranges::find(fit.ranges, "dbh", &fit::ColumnRange::column);
    const std::string formula = spreadsheet_formula(fit, "A2");
    if (range == fit.ranges.end() || formula.empty()) continue;
    std::vector<double> dbh;
    for (int i = 0; i <= kPoints; ++i) {
      dbh.push_back(range->low + (range->high - range->low) * i / kPoints);
    }
    data::Table grid;
    grid.set("dbh", dbh);
    const Eigen::VectorXd heights = fit::predict(fit, grid, fit::Level::kPopulation).value;
    list.push_back({{"species", curve.species},
                    {"formula", formula},
                    {"trees", fit.observations},
                    {"rmse", number_or_null(fit.population.rmse)},
                    {"dbh", numbers_or_null(dbh)},
                    {"h", numbers_or_null({heights.begin(), heights.end()})}});
  }
  return list;
}

/// Sentences on rows and plots that are not in the tables.
ordered_json District::left_out() const {
  ordered_json sentences = ordered_json::array();
  const std::size_t excluded = record_.inventory.excluded_tree_count;
  if (excluded > 0) {
    std::map<std::string, std::size_t> reasons;
    for (const stand::ExcludedRow& row : record_.inventory.excluded) {
      // Values differ between rows: "0.9 m is not above breast height".
      std::string reason = row.reason;
      const std::size_t first = reason.find_first_not_of("-0123456789. ");
      ++reasons[first == std::string::npos ? reason : reason.substr(first)];
    }
    std::vector<std::string> texts;
    for (const auto& [reason, count] : reasons)
      texts.push_back(fmt::format("{} {}", count, reason));
    sentences.push_back(fmt::format("{} of {} left out: {}.",
                                    excluded,
                                    counted(excluded + inventory_.size(), "row", "rows"),
                                    data::list_of(texts)));
  }
  std::size_t counted_trees = 0;
  for (const stand::AreaReport& area : report_.areas) counted_trees += area.figures.trees;
  if (counted_trees < inventory_.size()) {
    sentences.push_back(
        fmt::format("{} of {} not counted: outside the plots, without a position or "
                    "neighbors only.",
                    inventory_.size() - counted_trees,
                    counted(inventory_.size(), "tree", "trees")));
  }
  return sentences;
}

/// The expression as spreadsheets read it.
std::string in_spreadsheet(const std::string& text) {
  static const std::map<std::string, std::string> names{
      {"log", "LN"}, {"ifelse", "IF"}, {"pi", "PI()"}};
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (std::isalpha(byte) != 0) {
      std::size_t end = i;
      while (end < text.size() && std::isalnum(static_cast<unsigned char>(text[end])) != 0) ++end;
      std::string word = text.substr(i, end - i);
      const auto known = names.find(word);
      if (known != names.end()) {
        word = known->second;
      } else {
        std::ranges::transform(
            word, word.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
      }
      result += word;
      i = end;
      continue;
    }
    if (std::isdigit(byte) != 0) {
      std::size_t end = i;
      // 1.5e-05 has a sign of its own.
      while (end < text.size() &&
             (std::isdigit(static_cast<unsigned char>(text[end])) != 0 || text[end] == '.' ||
              text[end] == 'e' || (text[end] == '-' && text[end - 1] == 'e'))) {
        ++end;
      }
      result += text.substr(i, end - i);
      i = end;
      continue;
    }
    const bool begins = result.empty() || result.back() == '(' || result.back() == ',';
    if (text[i] == '-' && begins) result += '0';
    if (text[i] != ' ') result += text[i];
    ++i;
  }
  return result;
}

}  // namespace

std::string spreadsheet_formula(const fit::FittedModel& fit, const std::string& cell) {
  const fit::ModelSpecification& specification = fit.specification;
  if (specification.predictors() != std::vector<std::string>{"dbh"}) return {};
  data::Expression curve = specification.formula.right;
  for (std::size_t k = 0; k < fit.coefficient_names.size(); ++k) {
    const double value = fit.estimate[static_cast<Eigen::Index>(k)];
    if (!std::isfinite(value)) return {};
    const double rounded = std::stod(fmt::format("{:.{}g}", value, kDigits));
    curve = curve.substitute(fit.coefficient_names[k], data::Expression::constant(rounded));
  }
  curve = curve.substitute("dbh", data::Expression::variable(cell));
  if (curve.variables() != std::vector<std::string>{cell}) return {};
  return "=" + in_spreadsheet(curve.text());
}

std::optional<ordered_json> district_object(const StudyRecord& record) {
  if (!record.stand) return std::nullopt;
  return District(record).json();
}

}  // namespace silvafit::study
