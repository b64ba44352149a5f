// SPDX-License-Identifier: MIT
#include "silvafit/stand/stand_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "figures/figure_sums.hpp"
#include "figures/moments.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"
#include "units/density_indices.hpp"

namespace silvafit::stand {
namespace {

constexpr double kMostClasses = 1e4;

}  // namespace

void DominantSums::add(double dbh_cm, double h_m, double weight) {
  ++trees_;
  squares_cm2_.add(dbh_cm * dbh_cm, weight);
  if (std::isnan(h_m)) {
    ++without_height_;
    return;
  }
  heights_.add(h_m, weight);
  basal_with_height_ += weight * dbh_cm * dbh_cm;
  basal_times_height_ += weight * dbh_cm * dbh_cm * h_m;
}

void DominantSums::set(StandFigures& figures) const {
  figures.dominant_trees = trees_;
  figures.dominant_trees_without_height = without_height_;
  figures.dominant_height_m = heights_.mean();
  figures.dominant_lorey_height_m =
      basal_with_height_ > 0.0 ? basal_times_height_ / basal_with_height_ : data::kMissing;
  figures.dominant_dbh_cm = std::sqrt(squares_cm2_.mean());
}

void set_dominant_height(const Inventory& inventory,
                         std::span<const std::size_t> trees,
                         double wanted,
                         StandFigures& figures) {
  DominantSums().set(figures);
  if (trees.empty() || std::isnan(wanted)) return;
  std::vector<std::size_t> order(trees.begin(), trees.end());
  // Among equally thick trees, those without height are last.
  const auto height = [&inventory](std::size_t tree) {
    const bool is_known = !inventory.h_m.empty() && !std::isnan(inventory.h_m[tree]);
    return is_known ? inventory.h_m[tree] : 0.0;
  };
  const bool is_weighted = !inventory.represented.empty();
  const auto count = is_weighted
                         ? order.size()
                         : std::clamp<std::size_t>(
                               static_cast<std::size_t>(std::llround(wanted)), 1, order.size());
  std::partial_sort(order.begin(),
                    order.begin() + static_cast<std::ptrdiff_t>(count),
                    order.end(),
                    [&](std::size_t left, std::size_t right) {
                      return std::pair(inventory.dbh_cm[left], height(left)) >
                             std::pair(inventory.dbh_cm[right], height(right));
                    });
  DominantSums sums;
  double represented = 0.0;
  std::size_t used = 0;
  for (; used < count && (represented < wanted || used == 0); ++used) {
    const double own = inventory.trees_represented(order[used]);
    // The last tree counts only for the number that is still needed.
    const double weight = is_weighted && used > 0 ? std::min(own, wanted - represented) : own;
    represented += is_weighted ? own : 0.0;
    const double h_m = height(order[used]);
    sums.add(inventory.dbh_cm[order[used]], h_m > 0.0 ? h_m : data::kMissing, weight);
  }
  sums.set(figures);
}

void FigureSums::add(const Inventory& inventory, std::span<const std::size_t> trees) {
  trees_ += trees.size();
  has_crown_column_ = has_crown_column_ || !inventory.cw_m.empty();
  for (const std::size_t tree : trees) {
    const double represented = inventory.trees_represented(tree);
    const double own_m2 = represented * basal_area_m2(inventory.dbh_cm[tree]);
    count_ += represented;
    basal_m2_ += own_m2;
    dbh_.add(inventory.dbh_cm[tree], represented);
    if (!inventory.h_m.empty() && !std::isnan(inventory.h_m[tree])) {
      heights_.add(inventory.h_m[tree], represented);
      basal_with_height_m2_ += own_m2;
      basal_times_height_ += own_m2 * inventory.h_m[tree];
    }
    if (inventory.cw_m.empty() || std::isnan(inventory.cw_m[tree])) {
      ++without_crown_width_;
    } else {
      crowns_m2_ +=
          represented * std::numbers::pi / 4.0 * inventory.cw_m[tree] * inventory.cw_m[tree];
    }
  }
  quantities_.resize(inventory.quantities.size());
  for (std::size_t i = 0; i < quantities_.size(); ++i) {
    for (const std::size_t tree : trees) {
      const double value = inventory.quantities[i].values[tree];
      if (std::isnan(value)) {
        ++quantities_[i].without;
      } else {
        quantities_[i].sum += inventory.trees_represented(tree) * value;
      }
    }
  }
}

StandFigures FigureSums::figures(double area_m2) const {
  StandFigures figures{.trees = trees_, .area_ha = area_m2 / kSquareMetersPerHectare};
  for (const QuantitySum& quantity : quantities_) {
    const bool is_unknown = quantity.without > 0 && quantity.without == trees_;
    figures.quantities_per_ha.push_back(is_unknown ? data::kMissing
                                                   : quantity.sum / figures.area_ha);
    figures.trees_without_quantity.push_back(quantity.without);
  }
  figures.stems_per_ha = count_ / figures.area_ha;
  figures.basal_area_m2_per_ha = basal_m2_ / figures.area_ha;
  figures.mean_dbh_cm = dbh_.mean();
  figures.sd_dbh_cm = dbh_.standard_deviation();
  figures.quadratic_mean_dbh_cm =
      trees_ == 0 ? data::kMissing : 200.0 * std::sqrt(basal_m2_ / count_ / std::numbers::pi);
  figures.mean_height_m = heights_.mean();
  figures.sd_height_m = heights_.standard_deviation();
  figures.lorey_height_m =
      basal_with_height_m2_ > 0.0 ? basal_times_height_ / basal_with_height_m2_ : data::kMissing;
  DominantSums().set(figures);
  figures.trees_without_crown_width = without_crown_width_;
  const bool has_crowns = trees_ == 0 ? has_crown_column_ : without_crown_width_ < trees_;
  figures.crown_cover_percent = has_crowns ? 100.0 * crowns_m2_ / area_m2 : data::kMissing;
  return figures;
}

StandFigures stand_figures(const Inventory& inventory,
                           std::span<const std::size_t> trees,
                           double area_m2,
                           double dominant_trees_per_ha) {
  FigureSums sums;
  sums.add(inventory, trees);
  StandFigures figures = sums.figures(area_m2);
  set_dominant_height(inventory, trees, dominant_trees_per_ha * figures.area_ha, figures);
  return figures;
}

std::string note_on_crown_cover(const StandFigures& figures) {
  const std::size_t without = figures.trees_without_crown_width;
  if (without == 0 || without == figures.trees) return {};
  return fmt::format(
      "{} of {} trees {} no crown width and {} not included in the crown cover, which is therefore "
      "too small",
      without,
      figures.trees,
      without == 1 ? "has" : "have",
      without == 1 ? "is" : "are");
}

double diameter_class(double dbh_cm, double width_cm) {
  return std::floor(dbh_cm / width_cm + 1e-9);
}

void DiameterSums::add(const Inventory& inventory, std::span<const std::size_t> trees) {
  if (!(width_cm_ > 0.0) || std::isinf(width_cm_)) {
    throw UsageError(
        fmt::format("the width of a diameter class, {} cm, must be above 0", width_cm_),
        {.column = "`class_width`"});
  }
  for (const std::size_t tree : trees) {
    const double number = diameter_class(inventory.dbh_cm[tree], width_cm_);
    const auto [found, is_new] = classes_.try_emplace(number);
    // Class numbers are integers, and each is one more than the previous one, below 2^53.
    const double lowest = classes_.begin()->first;
    const double highest = classes_.rbegin()->first;
    if (is_new && (highest - lowest >= kMostClasses || highest >= 0x1p53)) {
      throw UsageError(
          fmt::format("diameter classes of {} cm are too narrow for these trees", width_cm_),
          {.column = "`class_width`"});
    }
    Sums& own = found->second;
    ++own.trees;
    const double represented = inventory.trees_represented(tree);
    own.represented += represented;
    own.basal_m2 += represented * basal_area_m2(inventory.dbh_cm[tree]);
  }
}

std::vector<DiameterClass> DiameterSums::classes(double area_m2) const {
  std::vector<DiameterClass> classes;
  if (classes_.empty()) return classes;
  const double hectares = area_m2 / kSquareMetersPerHectare;
  const double highest = classes_.rbegin()->first;
  for (double number = classes_.begin()->first; number <= highest; number += 1.0) {
    DiameterClass& one = classes.emplace_back(
        DiameterClass{.low_cm = number * width_cm_, .high_cm = (number + 1.0) * width_cm_});
    const auto found = classes_.find(number);
    if (found == classes_.end()) continue;
    one.trees = found->second.trees;
    one.stems_per_ha = found->second.represented / hectares;
    one.basal_area_m2_per_ha = found->second.basal_m2 / hectares;
  }
  return classes;
}

}  // namespace silvafit::stand
