// SPDX-License-Identifier: MIT
#include <cmath>
#include <utility>

#include "figures/ratio_estimates.hpp"
#include "growth/growth_parts.hpp"
#include "silvafit/data/table.hpp"
#include "trees/measurement_time.hpp"

namespace silvafit::stand {
namespace {

bool is_earlier(const std::string& left, const std::string& right) {
  return years_of(left).value_or(0.0) < years_of(right).value_or(0.0);
}

/// Estimates of one period number.
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

std::vector<StratumGrowth> strata_of_period(const GrowthReport& report,
                                            const std::vector<double>& areas_ha,
                                            const std::vector<double>& whole_ha,
                                            std::size_t period,
                                            const std::map<std::string, double>& sizes,
                                            bool are_weights,
                                            const StratumSettings& settings) {
  return PeriodEstimator(report, areas_ha, whole_ha, period).strata(sizes, are_weights, settings);
}

}  // namespace silvafit::stand
