// SPDX-License-Identifier: MIT
// Growth between the measurements of plots: trees are followed, added up by plot and by stratum.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "figures/ratio_estimates.hpp"
#include "growth/growth_parts.hpp"
#include "silvafit/stand/growth.hpp"
#include "silvafit/stand/plots_at_times.hpp"
#include "trees/measured_plots.hpp"

namespace silvafit::stand {

inline constexpr std::size_t kNoTreeRow = static_cast<std::size_t>(-1);

/// A tree in a period, with its rows of the living trees.
struct TreeInPeriod {
  std::size_t start = kNoTreeRow;
  std::size_t end = kNoTreeRow;
  TreeFate fate = TreeFate::kSurvivor;
};

struct Period {
  std::size_t plot = 0;      ///< number of the plot
  std::size_t occasion = 0;  ///< of the start
  std::vector<TreeInPeriod> trees{};
};

class GrowthMaker {
 public:
  GrowthMaker(const Inventory& inventory, const StandReportOptions& options)
      : inventory_(inventory), options_(options), design_(design_for(inventory, options.design)) {}

  GrowthReport run();

 private:
  bool is_alive(std::size_t row) const {
    return status_.empty() || status_[row] == TreeStatus::kAlive;
  }
  void read_status();
  std::vector<std::size_t> living_rows(const MeasuredPlot& plot,
                                       const MeasuredTree& tree,
                                       LivingTrees& living);
  TreeFate fate_at_end(const MeasuredTree& tree, std::size_t occasion) const;
  void follow_plot(std::size_t number, LivingTrees& living);
  void follow_trees();
  void place_trees();
  void find_areas();
  void note_uncounted();
  std::vector<PlotAtTime> plots_at_occasions() const;
  void add_trees();
  void add_tree(const Period& period, const TreeInPeriod& tree);
  GrowthParts parts_of_value(const Period& period,
                             const TreeValue& value,
                             const SampledArea& start,
                             const SampledArea& end,
                             double years) const;
  bool is_value_missing(const TreeInPeriod& tree, const TreeValue& value) const;
  void find_missing(const Period& period,
                    const TreeValue& value,
                    std::vector<std::string>& places) const;
  void note_missing();
  void note_moved();
  std::vector<TreeValue> values() const;
  void add_plots();
  void check_density() const;
  void find_strata();
  void add_strata();
  void add_notes();
  void note_if(std::size_t count, const std::string& text);
  void note_odd_increments();
  void note_thick_ingrowth();
  void note_years_beside_dates();

  const Inventory& inventory_;
  const StandReportOptions& options_;
  SamplingDesign design_;
  std::vector<MeasuredPlot> plots_{};
  std::vector<TreeStatus> status_{};  ///< of each row at its time; none if all are alive
  bool is_status_of_last_visit_ = false;
  std::vector<Period> periods_{};
  std::vector<std::vector<std::size_t>> rows_of_trees_{};  ///< of the living trees, by occasion
  Inventory living_{};
  std::unordered_map<std::string, SampledArea> areas_{};  ///< by label
  std::vector<char> is_counted_{};                        ///< of the living trees
  std::set<std::size_t> interpolated_{};
  std::size_t carried_ = 0;         ///< rows of trees that ended, with the dbh of an earlier one
  std::vector<double> areas_ha_{};  ///< sizes in ratios, of GrowthReport::plots
  std::vector<double> whole_ha_{};  ///< the same of whole plots
  std::map<std::string, double> stratum_sizes_{};
  bool are_weights_ = false;
  StratumSettings strata_settings_{};
  std::vector<std::vector<std::string>> missing_{};  ///< by GrowthReport::values: trees without it
  std::size_t revived_ = 0;
  std::string first_revived_{};
  std::size_t never_alive_ = 0;
  std::vector<std::string> renamed_{};  ///< trees with another species at the end of a period
  GrowthReport report_{};
};

}  // namespace silvafit::stand
