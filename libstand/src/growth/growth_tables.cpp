// SPDX-License-Identifier: MIT
// A growth report as tables and as JSON, and the names in them.
#include <array>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "figures/figure_columns.hpp"
#include "silvafit/base/json_values.hpp"
#include "silvafit/data/list_table.hpp"
#include "silvafit/stand/growth.hpp"
#include "silvafit/stand/stand_json.hpp"

namespace silvafit::stand {
namespace {

using nlohmann::ordered_json;

GrowthPart growth_part(std::size_t number) { return static_cast<GrowthPart>(number); }

std::string part_name(std::size_t part) { return word_of(growth_part(part)); }

data::Table trees_table(const GrowthReport& report) {
  using Tree = TreeGrowth;
  data::ListTable<Tree> table(report.trees);
  table.add("plot", &Tree::plot);
  table.add("tree", &Tree::tree);
  table.add("species", &Tree::species);
  table.add("from", &Tree::from);
  table.add("to", &Tree::to);
  table.add("fate", [](const Tree& tree) { return word_of(tree.fate); });
  table.add("years", &Tree::years);
  // The columns at the start have the standard names, so that the file can be used for fits.
  table.add("dbh", &Tree::dbh_start_cm);
  table.add("dbh_end", &Tree::dbh_end_cm);
  table.add("h", &Tree::h_start_m);
  table.add("h_end", &Tree::h_end_m);
  table.add("id", &Tree::dbh_cm_per_year);
  table.add("ih", &Tree::h_m_per_year);
  table.add("ig", &Tree::basal_area_cm2_per_year);
  for (std::size_t i = 0; i < report.quantities.size(); ++i) {
    table.add("i_" + report.quantities[i],
              [i](const Tree& tree) { return tree.quantities_per_year[i]; });
  }
  table.add("interpolated", &Tree::is_interpolated);
  return std::move(table).table();
}

data::Table plots_table(const GrowthReport& report) {
  data::ListTable<PlotGrowth> table(report.plots);
  table.add("plot", &PlotGrowth::plot);
  table.add("stratum", &PlotGrowth::stratum);
  table.add("from", &PlotGrowth::from);
  table.add("to", &PlotGrowth::to);
  table.add("years", &PlotGrowth::years);
  table.add("area_ha", &PlotGrowth::area_ha);
  for (std::size_t value = 0; value < report.values.size(); ++value) {
    for (std::size_t part = 0; part < kGrowthParts; ++part) {
      table.add(report.values[value] + "_" + part_name(part),
                [=](const PlotGrowth& plot) { return plot.values[value][part]; });
    }
  }
  return std::move(table).table();
}

/// A part of the growth of one value in a stratum.
struct StratumPart {
  const StratumGrowth& stratum;
  std::size_t value = 0;
  std::size_t part = 0;
};

data::Table growth_strata_table(const GrowthReport& report) {
  std::vector<StratumPart> parts;
  for (const StratumGrowth& stratum : report.strata) {
    for (std::size_t value = 0; value < report.values.size(); ++value) {
      for (std::size_t part = 0; part < kGrowthParts; ++part) {
        parts.push_back({.stratum = stratum, .value = value, .part = part});
      }
    }
  }
  data::ListTable<StratumPart> table(parts);
  const auto of_stratum = [&table](const char* name, auto value) {
    table.add(name, [value](const StratumPart& one) { return std::invoke(value, one.stratum); });
  };
  of_stratum("stratum", [](const StratumGrowth& stratum) {
    return stratum.kind == StratumFigures::Kind::kAll ? "all" : stratum.name;
  });
  of_stratum("kind", [](const StratumGrowth& stratum) { return name_of(stratum.kind); });
  of_stratum("period", &StratumGrowth::period);
  of_stratum("from", &StratumGrowth::from);
  of_stratum("to", &StratumGrowth::to);
  of_stratum("plots", &StratumGrowth::plots);
  table.add("value", [&report](const StratumPart& one) { return report.values[one.value]; });
  table.add("part", [](const StratumPart& one) { return part_name(one.part); });
  const auto of_estimate = [&table](const char* name, double Estimate::*member) {
    table.add(name, [member](const StratumPart& one) {
      return one.stratum.values[one.value][one.part].*member;
    });
  };
  of_estimate("per_ha", &Estimate::per_ha);
  of_estimate("per_ha_se", &Estimate::standard_error);
  of_estimate("total", &Estimate::total);
  of_estimate("total_se", &Estimate::total_standard_error);
  return std::move(table).table();
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
        entry[report.values[value]][part_name(part)] = number_or_null(plot.values[value][part]);
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
                       {"kind", name_of(stratum.kind)},
                       {"period", stratum.period},
                       {"from", stratum.from},
                       {"to", stratum.to},
                       {"plots", stratum.plots}};
    for (std::size_t value = 0; value < report.values.size(); ++value) {
      for (std::size_t part = 0; part < kGrowthParts; ++part) {
        entry[report.values[value]][part_name(part)] = json_of(stratum.values[value][part]);
      }
    }
    list.push_back(std::move(entry));
  }
  return list;
}

}  // namespace

std::vector<std::pair<std::string, data::Table>> tables_of(const GrowthReport& report) {
  std::vector<std::pair<std::string, data::Table>> tables;
  tables.emplace_back("growth_trees", trees_table(report));
  tables.emplace_back("growth_plots", plots_table(report));
  tables.emplace_back("growth_strata", growth_strata_table(report));
  return tables;
}

ordered_json json_of(const GrowthReport& report) {
  ordered_json fates = ordered_json::object();
  for (const TreeFate fate : all_values<TreeFate>()) {
    std::size_t count = 0;
    for (const TreeGrowth& tree : report.trees) count += tree.fate == fate ? 1 : 0;
    fates[word_of(fate)] = count;
  }
  return {{"trees", std::move(fates)},
          {"plots", plots_json(report)},
          {"strata", strata_of_growth_json(report)}};
}

}  // namespace silvafit::stand
