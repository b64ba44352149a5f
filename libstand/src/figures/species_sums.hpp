// SPDX-License-Identifier: MIT
// Sums over trees for the table of species, which can be added over parts of an inventory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "figures/figure_sums.hpp"
#include "figures/moments.hpp"
#include "silvafit/stand/species_table.hpp"

namespace silvafit::stand {

/// The data of a tree for importance values.
struct SpeciesMember {
  std::size_t species = 0;  ///< its number
  std::size_t plot = 0;
  std::size_t layer = 0;
  double represented = 1.0;  ///< trees
  double basal_area_m2 = 0.0;
  /// Area, and quadrat within it, or the plot.
  std::tuple<std::size_t, long long, long long> quadrat{};
};

/// Sums of the species among some trees.
class CompositionSums {
 public:
  /// \param members  trees of whole quadrats
  void add(const std::vector<const SpeciesMember*>& members, std::size_t species_count);
  /// By number of the species, without means over plots.
  std::vector<Importance> importance() const;

 private:
  std::vector<Importance> species_{};  ///< sums of what is relative later
  double stems_ = 0.0;
  double basal_m2_ = 0.0;
  double occurrences_ = 0.0;  ///< of species in quadrats
};

/// The importance values of a layer or of all trees, and their moments over plots.
class LayerSums {
 public:
  /// \param members  trees of whole plots, by plot
  void add(const std::vector<std::vector<const SpeciesMember*>>& plots,
           const std::vector<const SpeciesMember*>& members,
           std::size_t species_count);
  std::vector<Importance> importance() const;

 private:
  CompositionSums all_{};
  std::vector<Moments> over_plots_{};
  std::size_t plots_ = 0;
};

/// Accumulates species_table(). Species have numbers in the order in which they are added; 0 is
/// that of trees without species.
class SpeciesSums {
 public:
  explicit SpeciesSums(const SpeciesTableOptions& options) : options_(options) {}

  /// \param areas  with trees of whole plots, whose order is that of the sums
  /// \throws as species_table()
  void add(const Inventory& inventory, const std::vector<SampledArea>& areas);
  /// The number of each tree's species, in the inventory added last.
  std::size_t number_of(const Inventory& inventory, std::size_t tree) const {
    return inventory.species.is_missing(tree) ? 0 : number_of_code_[inventory.species.code(tree)];
  }
  std::size_t species_count() const { return species_.size(); }
  /// \param set_dominant_height  for the trees of a species, by number
  std::vector<SpeciesRow> rows(
      double area_m2,
      const std::function<void(std::size_t species, StandFigures&)>& set_dominant_height) const;

 private:
  struct Species {
    std::string name{};
    std::uint32_t first_line = std::numeric_limits<std::uint32_t>::max();
    bool has_trees = false;
    FigureSums figures{};
  };

  void check(const std::vector<SampledArea>& areas) const;
  void find_species(const Inventory& inventory);
  std::vector<SpeciesMember> members_of(const Inventory& inventory,
                                        const std::vector<SampledArea>& areas) const;
  void add_layer(const Inventory& inventory,
                 const std::vector<SpeciesMember>& members,
                 std::size_t layer);

  SpeciesTableOptions options_;
  std::vector<Species> species_ = std::vector<Species>(1);
  std::unordered_map<std::string, std::size_t> numbers_{};
  std::vector<std::size_t> number_of_code_{};
  std::vector<LayerSums> layers_{};  ///< by layer; the last: all trees
  bool has_heights_ = false;
};

}  // namespace silvafit::stand
