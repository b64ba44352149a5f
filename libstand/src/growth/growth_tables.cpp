// SPDX-License-Identifier: MIT
// A growth report as tables and as JSON, and the names in them.
#include <array>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/base/json_values.hpp"
#include "silvafit/stand/growth.hpp"
#include "silvafit/stand/stand_json.hpp"

namespace silvafit::stand {
namespace {

using nlohmann::ordered_json;

GrowthPart growth_part(std::size_t number) { return static_cast<GrowthPart>(number); }

std::string name_of_stratum(const StratumGrowth& stratum) {
  return stratum.kind == StratumFigures::Kind::kAll ? "all" : stratum.name;
}

std::string_view kind_of_growth(const StratumGrowth& stratum) {
  using Kind = StratumFigures::Kind;
  if (stratum.kind == Kind::kAll) return "all";
  return stratum.kind == Kind::kWithout ? "none" : "stratum";
}

data::Table trees_table(const GrowthReport& report) {
  data::Table table(report.trees.size());
  const auto text = [&](const std::string& name,
                        const std::function<std::string(const TreeGrowth&)>& value) {
    data::TextColumn column;
    for (const TreeGrowth& tree : report.trees) column.append(value(tree));
    table.set(name, std::move(column));
  };
  const auto number = [&](const std::string& name,
                          const std::function<double(const TreeGrowth&)>& value) {
    std::vector<double> column;
    for (const TreeGrowth& tree : report.trees) column.push_back(value(tree));
    table.set(name, std::move(column));
  };
  text("plot", [](const TreeGrowth& tree) { return tree.plot; });
  text("tree", [](const TreeGrowth& tree) { return tree.tree; });
  text("species", [](const TreeGrowth& tree) { return tree.species; });
  text("from", [](const TreeGrowth& tree) { return tree.from; });
  text("to", [](const TreeGrowth& tree) { return tree.to; });
  text("fate", [](const TreeGrowth& tree) { return std::string(name_of(tree.fate)); });
  const auto member = [&number](const std::string& name, double TreeGrowth::*value) {
    number(name, [value](const TreeGrowth& tree) { return tree.*value; });
  };
  member("years", &TreeGrowth::years);
  // The columns at the start have the standard names, so that the file can be used for fits.
  member("dbh", &TreeGrowth::dbh_start_cm);
  member("dbh_end", &TreeGrowth::dbh_end_cm);
  member("h", &TreeGrowth::h_start_m);
  member("h_end", &TreeGrowth::h_end_m);
  member("id", &TreeGrowth::dbh_cm_per_year);
  member("ih", &TreeGrowth::h_m_per_year);
  member("ig", &TreeGrowth::basal_area_cm2_per_year);
  for (std::size_t i = 0; i < report.quantities.size(); ++i) {
    number("i_" + report.quantities[i],
           [i](const TreeGrowth& tree) { return tree.quantities_per_year[i]; });
  }
  number("interpolated", [](const TreeGrowth& tree) { return tree.is_interpolated ? 1.0 : 0.0; });
  return table;
}

data::Table plots_table(const GrowthReport& report) {
  data::Table table(report.plots.size());
  const auto text = [&](const std::string& name, std::string PlotGrowth::*member) {
    data::TextColumn column;
    for (const PlotGrowth& plot : report.plots) column.append(plot.*member);
    table.set(name, std::move(column));
  };
  const auto number = [&](const std::string& name,
                          const std::function<double(const PlotGrowth&)>& value) {
    std::vector<double> column;
    for (const PlotGrowth& plot : report.plots) column.push_back(value(plot));
    table.set(name, std::move(column));
  };
  text("plot", &PlotGrowth::plot);
  text("stratum", &PlotGrowth::stratum);
  text("from", &PlotGrowth::from);
  text("to", &PlotGrowth::to);
  number("years", [](const PlotGrowth& plot) { return plot.years; });
  number("area_ha", [](const PlotGrowth& plot) { return plot.area_ha; });
  for (std::size_t value = 0; value < report.values.size(); ++value) {
    for (std::size_t part = 0; part < kGrowthParts; ++part) {
      number(report.values[value] + "_" + std::string(name_of(growth_part(part))),
             [=](const PlotGrowth& plot) { return plot.values[value][part]; });
    }
  }
  return table;
}

data::Table growth_strata_table(const GrowthReport& report) {
  data::TextColumn stratum;
  data::TextColumn kind;
  data::TextColumn from;
  data::TextColumn to;
  data::TextColumn value_name;
  data::TextColumn part_name;
  std::vector<double> period;
  std::vector<double> plots;
  std::array<std::vector<double>, 4> numbers;
  for (const StratumGrowth& one : report.strata) {
    for (std::size_t value = 0; value < report.values.size(); ++value) {
      for (std::size_t part = 0; part < kGrowthParts; ++part) {
        stratum.append(name_of_stratum(one));
        kind.append(kind_of_growth(one));
        from.append(one.from);
        to.append(one.to);
        value_name.append(report.values[value]);
        part_name.append(name_of(growth_part(part)));
        period.push_back(static_cast<double>(one.period));
        plots.push_back(static_cast<double>(one.plots));
        const Estimate& estimate = one.values[value][part];
        numbers[0].push_back(estimate.per_ha);
        numbers[1].push_back(estimate.standard_error);
        numbers[2].push_back(estimate.total);
        numbers[3].push_back(estimate.total_standard_error);
      }
    }
  }
  data::Table table(period.size());
  table.set("stratum", std::move(stratum));
  table.set("kind", std::move(kind));
  table.set("period", std::move(period));
  table.set("from", std::move(from));
  table.set("to", std::move(to));
  table.set("plots", std::move(plots));
  table.set("value", std::move(value_name));
  table.set("part", std::move(part_name));
  table.set("per_ha", std::move(numbers[0]));
  table.set("per_ha_se", std::move(numbers[1]));
  table.set("total", std::move(numbers[2]));
  table.set("total_se", std::move(numbers[3]));
  return table;
}

ordered_json estimate_of_growth_json(const Estimate& estimate) {
  return {{"per_ha", number_or_null(estimate.per_ha)},
          {"standard_error", number_or_null(estimate.standard_error)},
          {"total", number_or_null(estimate.total)},
          {"total_standard_error", number_or_null(estimate.total_standard_error)}};
}

ordered_json plots_json(const GrowthReport& report) {
  ordered_json list = ordered_json::array();
  for (const PlotGrowth& plot : report.plots) {
    ordered_json entry{{"plot", plot.plot},
                       {"stratum", text_or_null(plot.stratum)},
                       {"from", plot.from},
                       {"to", plot.to},
                       {"years", plot.years},
                       {"area_ha", number_or_null(plot.area_ha)}};
    for (std::size_t value = 0; value < report.values.size(); ++value) {
      for (std::size_t part = 0; part < kGrowthParts; ++part) {
        entry[report.values[value]][std::string(name_of(growth_part(part)))] =
            number_or_null(plot.values[value][part]);
      }
    }
    list.push_back(std::move(entry));
  }
  return list;
}

ordered_json strata_of_growth_json(const GrowthReport& report) {
  ordered_json list = ordered_json::array();
  for (const StratumGrowth& stratum : report.strata) {
    ordered_json entry{{"stratum", text_or_null(stratum.name)},
                       {"kind", kind_of_growth(stratum)},
                       {"period", stratum.period},
                       {"from", stratum.from},
                       {"to", stratum.to},
                       {"plots", stratum.plots}};
    for (std::size_t value = 0; value < report.values.size(); ++value) {
      for (std::size_t part = 0; part < kGrowthParts; ++part) {
        entry[report.values[value]][std::string(name_of(growth_part(part)))] =
            estimate_of_growth_json(stratum.values[value][part]);
      }
    }
    list.push_back(std::move(entry));
  }
  return list;
}

}  // namespace

std::string_view name_of(TreeFate fate) {
  switch (fate) {
    case TreeFate::kSurvivor:
      return "survivor";
    case TreeFate::kIngrowth:
      return "ingrowth";
    case TreeFate::kMortality:
      return "mortality";
    case TreeFate::kCut:
      return "cut";
    case TreeFate::kNotFound:
      break;
  }
  return "not found";
}

std::string_view name_of(GrowthPart part) {
  constexpr std::array<std::string_view, kGrowthParts> kNames{"start",
                                                              "end",
                                                              "net_change",
                                                              "survivor_growth",
                                                              "ingrowth",
                                                              "mortality",
                                                              "cut",
                                                              "not_found",
                                                              "factor_change"};
  return kNames[static_cast<std::size_t>(part)];
}

std::vector<std::pair<std::string, data::Table>> tables_of(const GrowthReport& report) {
  std::vector<std::pair<std::string, data::Table>> tables;
  tables.emplace_back("growth_trees", trees_table(report));
  tables.emplace_back("growth_plots", plots_table(report));
  tables.emplace_back("growth_strata", growth_strata_table(report));
  return tables;
}

ordered_json json_of(const GrowthReport& report) {
  ordered_json fates = ordered_json::object();
  for (const TreeFate fate : {TreeFate::kSurvivor,
                              TreeFate::kIngrowth,
                              TreeFate::kMortality,
                              TreeFate::kCut,
                              TreeFate::kNotFound}) {
    std::size_t count = 0;
    for (const TreeGrowth& tree : report.trees) count += tree.fate == fate ? 1 : 0;
    fates[std::string(name_of(fate))] = count;
  }
  return {{"trees", std::move(fates)},
          {"plots", plots_json(report)},
          {"strata", strata_of_growth_json(report)}};
}

}  // namespace silvafit::stand
