// SPDX-License-Identifier: MIT
#include "report/comparison_curves.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "silvafit/fit/prediction.hpp"

namespace silvafit::study {
namespace {

constexpr std::size_t kGridPoints = 60;

using Range = std::pair<double, double>;

std::optional<Range> range_of(const fit::FittedModel& fit, const std::string& column) {
  for (const fit::ColumnRange& range : fit.ranges) {
    if (range.column == column) return Range{range.low, range.high};
  }
  return std::nullopt;
}

/// Without a range of DBH, as in published libraries, the ends of the curve are unknown. A
/// covariate that is compared with text, such as species == "SM", has no middle value.
bool has_curve(const fit::FittedModel& fit) {
  const auto dbh = range_of(fit, "dbh");
  if (!dbh || !(dbh->first < dbh->second)) return false;
  return std::ranges::all_of(fit.specification.predictors(), [&](const std::string& name) {
    return range_of(fit, name).has_value();
  });
}

std::vector<double> grid_between(double low, double high) {
  std::vector<double> grid;
  for (std::size_t i = 0; i < kGridPoints; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(kGridPoints - 1);
    grid.push_back(low + share * (high - low));
  }
  return grid;
}

std::vector<double> predicted(const fit::FittedModel& fit, const data::Table& grid) {
  const Eigen::VectorXd values = fit::predict(fit, grid, fit::Level::kPopulation).value;
  return {values.begin(), values.end()};
}

/// The height model of a species for a model that reads h: of the same role if there is one.
const LibraryModel* height_model(const ModelLibrary& library, const LibraryModel& model) {
  const LibraryModel* found = nullptr;
  for (const LibraryModel& candidate : library.models) {
    const bool fits = candidate.species == model.species && candidate.response == "h" &&
                      candidate.fit.convergence.converged() && has_curve(candidate.fit);
    if (fits && (found == nullptr || candidate.role == model.role)) found = &candidate;
  }
  return found;
}

/// The ranges over which curves are drawn; each model that uses a column narrows its range.
class Setting {
 public:
  void widen_dbh(const Range& range) {
    dbh_ = dbh_ ? Range{std::min(dbh_->first, range.first), std::max(dbh_->second, range.second)}
                : range;
  }
  void use(const fit::FittedModel& fit, bool has_heights) {
    for (const fit::ColumnRange& range : fit.ranges) {
      if (range.column == "dbh" || (range.column == "h" && has_heights)) continue;
      const auto [place, is_new] = held_.try_emplace(range.column, Range{range.low, range.high});
      if (is_new) continue;
      Range& common = place->second;
      const Range narrower{std::max(common.first, range.low), std::min(common.second, range.high)};
      // Ranges that do not overlap have no common middle; that of the first model is used.
      if (narrower.first <= narrower.second) common = narrower;
    }
  }
  bool is_empty() const { return !dbh_; }
  std::vector<double> dbh() const { return grid_between(dbh_->first, dbh_->second); }
  std::map<std::string, double> held_at() const {
    std::map<std::string, double> values;
    for (const auto& [name, range] : held_) values[name] = 0.5 * (range.first + range.second);
    return values;
  }

 private:
  std::optional<Range> dbh_;
  std::map<std::string, Range> held_;
};

}  // namespace

ComparedCurves compared_curves(const std::vector<const LibraryModel*>& models,
                               const std::vector<ModelLibrary>& libraries) {
  Setting setting;
  std::vector<const LibraryModel*> heights(models.size(), nullptr);
  std::vector<bool> drawn(models.size(), false);
  ComparedCurves curves;
  curves.values.resize(models.size());
  for (std::size_t i = 0; i < models.size(); ++i) {
    drawn[i] =
        models[i] != nullptr && models[i]->fit.convergence.converged() && has_curve(models[i]->fit);
    if (!drawn[i]) continue;
    if (range_of(models[i]->fit, "h")) heights[i] = height_model(libraries[i], *models[i]);
    setting.widen_dbh(*range_of(models[i]->fit, "dbh"));
    setting.use(models[i]->fit, heights[i] != nullptr);
    if (heights[i] != nullptr) setting.use(heights[i]->fit, false);
    curves.own_heights |= heights[i] != nullptr;
  }
  if (setting.is_empty()) return curves;
  curves.dbh_cm = setting.dbh();
  curves.held_at = setting.held_at();
  data::Table common;
  common.set("dbh", curves.dbh_cm);
  for (const auto& [name, value] : curves.held_at) {
    common.set(name, std::vector<double>(curves.dbh_cm.size(), value));
  }
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (!drawn[i]) continue;
    data::Table grid = common;
    if (heights[i] != nullptr) grid.set("h", predicted(heights[i]->fit, common));
    const auto [low, high] = *range_of(models[i]->fit, "dbh");
    curves.values[i] = predicted(models[i]->fit, grid);
    for (std::size_t k = 0; k < curves.dbh_cm.size(); ++k) {
      const bool inside = curves.dbh_cm[k] >= low && curves.dbh_cm[k] <= high;
      if (!inside) curves.values[i][k] = data::kMissing;
    }
  }
  return curves;
}

}  // namespace silvafit::study
