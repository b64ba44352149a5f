// SPDX-License-Identifier: MIT
// Chooses the trees of a sampling design and the areas that they stand for.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/stand/sampling_design.hpp"

namespace silvafit::stand {

/// The origin of positions.
enum class Origin {
  kNone,    ///< not known
  kCenter,  ///< the center of the plot or subplot is 0, 0
  kMap,     ///< centers are those of the table of plots
};

class SampleMaker {
 public:
  SampleMaker(const Inventory& inventory, const SamplingDesign& design)
      : inventory_(inventory), design_(design) {}

  DesignedSample run();

 private:
  void join();
  void note_unmatched();
  void note_gaps();
  const PlotRecord* record_of(std::size_t tree) const {
    return records_[inventory_.plot.code(tree)];
  }
  void find_expansions();
  void find_plots_without_factors();
  void find_smallest_dbh();
  std::optional<std::size_t> circle_of(double dbh_cm) const;
  double reach_m(std::size_t tree) const;
  double mapped_m(std::size_t tree) const;
  double plot_area_m2(const PlotRecord* record) const;
  std::optional<SampledArea> area_of(const std::string& name, const PlotRecord* record) const;
  double per_ha_of_whole_plot(std::size_t tree, const PlotRecord* record) const;
  bool uses_table_areas() const;
  double slope_cosine(const PlotRecord* record) const;
  bool exceeds_circles() const;
  void find_origin();
  Point center_of(const PlotRecord* record, Origin origin) const;
  bool is_within(std::size_t tree, Origin origin, double radius_m) const;
  bool is_counted(std::size_t tree);
  void add_areas();
  void note_unused_areas();
  void add_empty_plots();
  void add_complete_circles();
  double complete_radius_m(const PlotRecord* record) const;
  void check_subplots() const;
  void check_density() const;
  void note_counts();

  const Inventory& inventory_;
  const SamplingDesign& design_;
  std::vector<const PlotRecord*> records_{};  ///< by code of the plot
  std::vector<double> expansions_{};          ///< (N) by the column; NaN for FIA's without one
  std::vector<char> has_factor_{};  ///< by code of the plot, whether a tree has one; empty: all
  double smallest_dbh_cm_ = 0.0;
  Origin origin_ = Origin::kNone;
  std::size_t below_smallest_ = 0;
  std::size_t outside_ = 0;
  std::string first_outside_{};
  std::size_t without_factor_ = 0;
  std::size_t outside_population_ = 0;
  std::string first_outside_population_{};
  DesignedSample sample_{};
};

/// Whether a tree has a position.
bool is_placed(const Inventory& inventory, std::size_t tree);

}  // namespace silvafit::stand
