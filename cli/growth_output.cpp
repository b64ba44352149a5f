// SPDX-License-Identifier: MIT
// A growth report as text tables.
#include <array>
#include <map>
#include <string>
#include <vector>

#include "silvafit/stand/growth.hpp"
#include "stand_output.hpp"
#include "standard_output.hpp"
#include "text_table.hpp"

namespace silvafit::cli {
namespace {

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

}  // namespace

void print_growth(const stand::GrowthReport& report) {
  print_fates(report);
  for (std::size_t value = 0; value < report.values.size(); ++value) {
    print_growth_of_plots(report, value);
    print_growth_of_strata(report, value);
  }
}

}  // namespace silvafit::cli
