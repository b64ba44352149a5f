// SPDX-License-Identifier: MIT
// Makes a stand report of an inventory or of its parts.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <unordered_set>
#include <vector>

#include "figures/domain_sums.hpp"
#include "figures/dominant_trees.hpp"
#include "figures/figure_sums.hpp"
#include "figures/joint_sums.hpp"
#include "figures/plot_sums.hpp"
#include "figures/species_sums.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/stand_report.hpp"

namespace silvafit::stand {

/// Plots whose area differs from the convex hull of their trees.
struct HullDifference {
  std::size_t plots = 0;
  std::string first{};
};

/// Adds up an inventory, or its parts of whole plots in the order of plots_in_order().
class ReportMaker {
 public:
  /// \param sample        none: the inventory has no sampling design, or its areas are given
  ///                      otherwise
  /// \param is_only_plot  for an inventory in parts: whether it has only one plot
  ReportMaker(const StandReportOptions& options,
              const DesignedSample* sample,
              std::optional<bool> is_only_plot = std::nullopt);

  /// \param inventory  one that is not a part must live until finish()
  void add(const Inventory& inventory);
  /// Of the inventory added last; null if there are none.
  const StructuralUnits* units() const { return report_.units ? &*report_.units : nullptr; }
  /// \param file  for messages
  StandReport finish(const std::string& file);

 private:
  void take_labels(const Inventory& inventory);
  std::vector<SampledArea> find_areas(const Inventory& inventory);
  void add_empty_plots(const Inventory& inventory, std::vector<SampledArea>& areas);
  void count_trees_without_window(const Inventory& inventory, const PlotWindows& windows);
  static void sort_areas(const Inventory& inventory, std::vector<SampledArea>& areas);
  void count_trees_left_out(const Inventory& inventory, const std::vector<SampledArea>& areas);
  static data::TextColumn labels_of(const Inventory& inventory,
                                    const std::string& column,
                                    const char* setting);
  void check_one_stratum(const Inventory& inventory,
                         const SampledArea& area,
                         const data::TextColumn& column) const;
  void require_trees_of_strata(const std::vector<SampledArea>& areas,
                               const std::string& file) const;
  std::vector<std::string> strata_of(const Inventory& inventory,
                                     const std::vector<SampledArea>& areas);
  std::vector<std::string> strata_of_table(const std::vector<SampledArea>& areas);
  bool has_structure(const Inventory& inventory) const;
  void add_structure(const Inventory& inventory);
  void add_species(const Inventory& inventory, const std::vector<SampledArea>& areas);
  void add_dominant(const Inventory& inventory, const std::vector<SampledArea>& areas);
  AreaReport report_on(const Inventory& inventory, SampledArea area);
  void compare_with_hull(const Inventory& inventory, const SampledArea& area);
  void add_figures(const Inventory& inventory,
                   std::vector<SampledArea> areas,
                   const std::vector<std::string>& strata);
  [[noreturn]] void refuse_no_areas(const std::string& file) const;
  void add_plots_without_rows();
  void finish_structure(const std::string& file);
  void finish_figures();
  void check_density(const std::string& file) const;

  // Notes, in stand_report_notes.cpp.
  void note(const std::vector<std::string>& notes);
  void write_notes();
  void note_areas();
  void note_dense_plots();
  void note_trees_left_out();
  void note_plots_left_out();
  void note_plots_without_trees();
  bool is_outside_note_of_units() const;
  std::string outside_text(bool are_neighbors) const;
  void note_strata();
  void note_units();
  void note_single_plots();
  void note_dominant_height();

  StandReportOptions options_;
  const DesignedSample* sample_;
  bool is_part_;
  bool is_only_plot_;
  StandReport report_{};

  // Sums.
  FigureSums all_{};
  FigureSums without_trees_sums_{};  ///< of no tree, with the columns of the inventory
  Inventory without_rows_{};         ///< of no tree, with the quantities of the inventory
  DiameterSums diameters_;
  PlotSums plots_{};
  DomainSums domains_;
  std::vector<std::string> stratum_of_area_{};
  std::map<std::string, double> stratum_sizes_{};
  bool are_weights_ = false;
  std::optional<SpeciesSums> species_{};
  UnitSummaries unit_sums_{};
  std::vector<JointSums> joint_{};
  UnitFindings findings_{};
  double area_m2_ = 0.0;
  bool have_areas_ = true;

  // Trees for dominant heights, of parts and of a whole inventory.
  DominantTrees dominant_{};
  const Inventory* inventory_ = nullptr;
  std::vector<std::size_t> trees_{};
  std::vector<std::vector<std::size_t>> trees_of_species_{};

  // For notes.
  std::string expansion_{};  ///< Inventory::expansion
  bool is_hull_ = false;
  std::string offered_{};  ///< other source of areas than hulls
  PlotNames plots_without_window_{};
  std::size_t plots_without_window_count_ = 0;
  std::size_t without_window_ = 0;  ///< trees with a position whose plot has no window
  std::size_t outside_ = 0;         ///< trees with a position that are outside of a window
  std::size_t without_position_ = 0;
  std::size_t empty_ = 0;  ///< plots without trees
  HullDifference
      smaller_than_hull_{};            ///< plots whose area is smaller than the hull of their trees
  HullDifference larger_than_hull_{};  ///< plots on a small part of which all trees stand
  std::vector<std::string> plots_left_out_{};
  std::vector<std::string> plots_without_trees_{};  ///< but for those with a window
  std::vector<std::string> plots_of_table_without_trees_{};
  std::vector<std::string> plots_of_table_without_window_{};
  std::unordered_set<std::string> windows_without_rows_{};
  std::vector<std::string> notes_on_strata_{};
  PlotNames without_stratum_{};
  std::size_t without_stratum_count_ = 0;
  std::vector<std::string> notes_on_units_{};
};

}  // namespace silvafit::stand
