// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include "figures/ratio_estimates.hpp"
#include "growth/growth_maker.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"
#include "trees/measurement_time.hpp"

namespace silvafit::stand {
namespace {

bool is_earlier(const std::string& left, const std::string& right) {
  return years_of(left).value_or(0.0) < years_of(right).value_or(0.0);
}

/// Estimates of the periods with one number; the last: all strata. None if no such plot has an
/// area. Sizes are those of ratios, NaN where unknown, and of whole plots (SampledArea::whole_m2).
class PeriodEstimator {
 public:
  PeriodEstimator(const GrowthReport& report,
                  const std::vector<double>& areas_ha,
                  const std::vector<double>& whole_ha,
                  std::size_t period)
      : report_(report),
        areas_ha_(areas_ha),
        of_strata_(areas_of_strata(areas_ha, whole_ha)),
        period_(period) {}

  std::vector<StratumGrowth> strata(const std::map<std::string, double>& sizes,
                                    bool are_weights,
                                    const StratumSettings& settings);

 private:
  StratumGrowth growth_of(const PlotNumbers& plots) const;
  PlotTotals totals(std::size_t value, std::size_t part) const;

  const GrowthReport& report_;
  const std::vector<double>& areas_ha_;
  const std::vector<double>& of_strata_;
  std::size_t period_;
};

PlotTotals PeriodEstimator::totals(std::size_t value, std::size_t part) const {
  PlotTotals totals;
  for (std::size_t i = 0; i < report_.plots.size(); ++i) {
    // A plot outside of the population has no value per hectare.
    totals.push_back(areas_ha_[i] == 0.0 ? 0.0
                                         : report_.plots[i].values[value][part] * areas_ha_[i]);
  }
  return totals;
}

StratumGrowth PeriodEstimator::growth_of(const PlotNumbers& plots) const {
  StratumGrowth growth{.period = period_, .plots = plots.size()};
  for (const std::size_t plot : plots) {
    const PlotGrowth& own = report_.plots[plot];
    if (growth.from.empty() || is_earlier(own.from, growth.from)) growth.from = own.from;
    if (growth.to.empty() || is_earlier(growth.to, own.to)) growth.to = own.to;
  }
  growth.values.resize(report_.values.size());
  for (std::size_t value = 0; value < growth.values.size(); ++value) {
    for (std::size_t part = 0; part < kGrowthParts; ++part) {
      growth.values[value][part] =
          estimate_of(ratio_of_sums(totals(value, part), areas_ha_, {.plots = plots}));
    }
  }
  return growth;
}

std::vector<StratumGrowth> PeriodEstimator::strata(const std::map<std::string, double>& sizes,
                                                   bool are_weights,
                                                   const StratumSettings& settings) {
  std::map<std::string, PlotNumbers> members;
  PlotNumbers without;
  PlotNumbers all;
  bool has_strata = false;
  for (const PlotGrowth& plot : report_.plots) has_strata = has_strata || !plot.stratum.empty();
  for (std::size_t i = 0; i < report_.plots.size(); ++i) {
    const PlotGrowth& plot = report_.plots[i];
    if (plot.period != period_ || std::isnan(areas_ha_[i])) continue;
    if (!plot.stratum.empty()) members[plot.stratum].push_back(i);
    if (plot.stratum.empty() && has_strata) without.push_back(i);
    if (!plot.stratum.empty() || sizes.empty()) all.push_back(i);
  }
  std::vector<StratumGrowth> result;
  if (all.empty()) return result;
  SizedStrata sized{.are_posterior = settings.are_posterior};
  for (const auto& [name, plots] : members) {
    StratumGrowth& stratum = result.emplace_back(growth_of(plots));
    stratum.name = name;
    const auto own = sizes.find(name);
    if (own == sizes.end()) continue;
    const auto unit = settings.unit_of_stratum.find(name);
    sized.list.push_back({.plots = plots,
                          .size = own->second,
                          .unit = unit == settings.unit_of_stratum.end() ? "" : unit->second});
    if (are_weights) continue;
    for (std::size_t value = 0; value < stratum.values.size(); ++value) {
      for (std::size_t part = 0; part < kGrowthParts; ++part) {
        add_total(stratum.values[value][part], totals(value, part), of_strata_, sized.list.back());
      }
    }
  }
  if (!without.empty()) {
    result.push_back(growth_of(without));
    result.back().kind = StratumFigures::Kind::kWithout;
  }
  StratumGrowth total = growth_of(all);
  total.kind = StratumFigures::Kind::kAll;
  for (std::size_t value = 0; !sized.list.empty() && value < total.values.size(); ++value) {
    for (std::size_t part = 0; part < kGrowthParts; ++part) {
      total.values[value][part] =
          over_strata(totals(value, part), areas_ha_, of_strata_, sized, are_weights);
    }
  }
  result.push_back(std::move(total));
  return result;
}

}  // namespace

/// By the table of plots, or a column of the trees.
void GrowthMaker::find_strata() {
  refuse_two_strata(options_.stratum, options_.design.plots);
  stratum_sizes_ = options_.stratum_areas_ha;
  strata_settings_ = options_.strata;
  if (!options_.stratum.empty()) {
    const data::Table table = to_table(inventory_);
    if (!table.has(options_.stratum)) {
      throw InputError(data::no_such_column(options_.stratum, table.names()),
                       {.file = inventory_.file, .column = "`stratum`"});
    }
    const data::TextColumn column = table.labels(options_.stratum);
    std::unordered_map<std::string, std::string> stratum_of;
    for (std::size_t row = 0; row < inventory_.size(); ++row) {
      const auto [found, is_new] =
          stratum_of.try_emplace(std::string(inventory_.plot[row]), std::string(column[row]));
      if (is_new || found->second == column[row]) continue;
      Place place = inventory_.place(row);
      place.column = options_.stratum;
      throw InputError(
          fmt::format("the plot belongs to two strata, '{}' and '{}'", found->second, column[row]),
          place);
    }
    for (PlotGrowth& plot : report_.plots) plot.stratum = stratum_of[plot.plot];
    return;
  }
  if (!options_.design.plots || !options_.design.plots->has_stratum) return;
  std::vector<SampledArea> areas;
  for (std::size_t i = 0; i < areas_ha_.size(); ++i) {
    areas.push_back(
        {.name = report_.plots[i].plot, .area_m2 = areas_ha_[i] * kSquareMetersPerHectare});
  }
  DesignStrata strata = strata_of_plots(*options_.design.plots, areas, stratum_sizes_);
  for (std::size_t i = 0; i < areas.size(); ++i) {
    report_.plots[i].stratum = std::move(strata.stratum_of_area[i]);
  }
  stratum_sizes_ = std::move(strata.sizes);
  are_weights_ = strata.are_weights;
  strata_settings_.unit_of_stratum = std::move(strata.unit_of_stratum);
  std::ranges::move(strata.notes, std::back_inserter(report_.notes));
}

void GrowthMaker::add_strata() {
  std::set<std::string> names;
  std::size_t periods = 0;
  for (const PlotGrowth& plot : report_.plots) {
    if (!plot.stratum.empty()) names.insert(plot.stratum);
    periods = std::max(periods, plot.period);
  }
  check_stratum_sizes(names, stratum_sizes_);
  if (options_.strata.is_finite) {
    throw UsageError("growth has no correction for finite populations; omit `finite_population`",
                     {.column = "`finite_population`"});
  }
  for (std::size_t period = 1; period <= periods; ++period) {
    std::vector<StratumGrowth> strata = PeriodEstimator(report_, areas_ha_, whole_ha_, period)
                                            .strata(stratum_sizes_, are_weights_, strata_settings_);
    std::ranges::move(strata, std::back_inserter(report_.strata));
  }
}

}  // namespace silvafit::stand
