// SPDX-License-Identifier: MIT
// Sums over plots of the trees of each kind, such as a species and diameter class.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "figures/plot_sums.hpp"

namespace silvafit::stand {

/// Domains of estimation (Bechtold and Patterson 2005, 4.3): trees of other kinds have the value 0.
class DomainSums {
 public:
  /// \param by  columns whose values make a kind: dbh means classes of this width
  DomainSums(std::vector<std::string> by, double class_width_cm)
      : by_(std::move(by)), class_width_cm_(class_width_cm) {}

  /// \param column  the labels of a column of the inventory
  /// \param plots   the number of plots that were added before
  void add(const Inventory& inventory,
           const std::vector<SampledArea>& areas,
           const std::function<data::TextColumn(const std::string& column)>& labels,
           std::size_t plots);

  /// \param estimate  the figures of all strata from sums over plots
  /// \param plots     their areas; sums over trees are replaced
  std::vector<DomainFigures> figures(
      PlotSums plots, const std::function<StratumFigures(const PlotSums&)>& estimate) const;

 private:
  /// A class of diameters by its number, or a label.
  using Key = std::vector<std::pair<double, std::string>>;

  std::vector<std::string> labels_of(const Key& key) const;

  std::vector<std::string> by_;
  double class_width_cm_;
  /// A plot that has trees of a kind.
  struct Part {
    std::size_t plot = 0;
    std::size_t trees = 0;
    std::vector<double> totals{};  ///< in the order of each_total()
  };
  std::map<Key, std::vector<Part>> parts_{};
};

}  // namespace silvafit::stand
