// SPDX-License-Identifier: MIT
// Sums over trees for the values of an area, which can be added over parts of an inventory.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <vector>

#include "figures/moments.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/stand_summary.hpp"

namespace silvafit::stand {

/// All StandFigures but the dominant height, which needs the trees in the order of their sizes.
class FigureSums {
 public:
  /// \param trees  may be empty; the columns of the inventory count nevertheless
  void add(const Inventory& inventory, std::span<const std::size_t> trees);
  StandFigures figures(double area_m2) const;

 private:
  struct QuantitySum {
    double sum = 0.0;
    std::size_t without = 0;
  };

  std::size_t trees_ = 0;
  Moments dbh_{};
  Moments heights_{};
  double basal_m2_ = 0.0;
  double basal_with_height_m2_ = 0.0;
  double basal_times_height_ = 0.0;
  double crowns_m2_ = 0.0;
  double count_ = 0.0;
  std::size_t without_crown_width_ = 0;
  bool has_crown_column_ = false;
  std::vector<QuantitySum> quantities_{};
};

/// Sums over the thickest trees.
class DominantSums {
 public:
  /// \param h_m  NaN: the tree is one of the thickest, but not in the mean height
  void add(double dbh_cm, double h_m, double weight = 1.0);
  std::size_t trees() const { return trees_; }
  /// Sets the dominant height and diameter.
  void set(StandFigures& figures) const;

 private:
  std::size_t trees_ = 0;
  std::size_t without_height_ = 0;
  Moments squares_cm2_{};
  Moments heights_{};
  double basal_with_height_ = 0.0;
  double basal_times_height_ = 0.0;
};

/// Sets the mean height of the thickest trees.
/// \param wanted  number of trees
void set_dominant_height(const Inventory& inventory,
                         std::span<const std::size_t> trees,
                         double wanted,
                         StandFigures& figures);

/// The number of the class of a diameter, from 0. A diameter on the class limit belongs to the
/// upper class; the tolerance covers rounding.
double diameter_class(double dbh_cm, double width_cm);

/// Classes of one width, starting at 0, from the first to the last class with a tree.
class DiameterSums {
 public:
  explicit DiameterSums(double width_cm) : width_cm_(width_cm) {}
  /// \throws UsageError if the width is not above 0, or would make more than 10,000 classes
  void add(const Inventory& inventory, std::span<const std::size_t> trees);
  std::vector<DiameterClass> classes(double area_m2) const;

 private:
  struct Sums {
    std::size_t trees = 0;
    double represented = 0.0;
    double basal_m2 = 0.0;
  };

  double width_cm_;
  std::map<double, Sums> classes_{};  ///< by number of the class
};

}  // namespace silvafit::stand
