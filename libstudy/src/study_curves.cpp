// SPDX-License-Identifier: MIT
#include "study_curves.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "silvafit/fit/prediction.hpp"

namespace silvafit::study {
namespace {

constexpr std::size_t kGridPoints = 60;

std::vector<double> values_of(const data::Table& table,
                              const std::vector<std::size_t>& rows,
                              const std::string& name) {
  std::vector<double> values;
  for (const std::size_t row : rows) values.push_back(table.numbers(name)[row]);
  return values;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

std::vector<double> predicted(const fit::FittedModel& model,
                              const data::Table& grid,
                              fit::Level level) {
  const Eigen::VectorXd values = fit::predict(model, grid, level).value;
  return {values.begin(), values.end()};
}

bool uses(const fit::FittedModel& model, const std::string& name) {
  return std::ranges::any_of(model.ranges,
                             [&](const fit::ColumnRange& range) { return range.column == name; });
}

const ResponseStudy* height_study(const std::string& species, const Study& study) {
  for (const ResponseStudy& result : study.results) {
    if (result.species == species && result.response == "h" && result.ols) return &result;
  }
  return nullptr;
}

/// The grid of DBH with all other columns of the models at their means.
class CurveGrid {
 public:
  CurveGrid(const ResponseStudy& result, const StudyRecord& record, Curves& curves)
      : result_(result), record_(record), curves_(curves) {
    dbh_ = values_of(record.table, result.rows, "dbh");
    const auto [low, high] = std::ranges::minmax(dbh_);
    for (std::size_t i = 0; i < kGridPoints; ++i) {
      const double share = static_cast<double>(i) / static_cast<double>(kGridPoints - 1);
      curves_.dbh_cm.push_back(low + share * (high - low));
    }
    table_.set("dbh", curves_.dbh_cm);
    for (const std::string& name : record.study.options.covariates) {
      if (record.table.has(name)) hold(name);
    }
    // What a formula of the user's own reads besides.
    for (const fit::ColumnRange& range : result.ols->fit.ranges) {
      if (!table_.has(range.column) && range.column != "h") hold(range.column);
    }
    if (uses(result.ols->fit, "h")) set_height();
    set_plot("");
  }

  const data::Table& table() const { return table_; }

  /// The grid for one plot's conditional curve.
  const data::Table& for_plot(const std::string& plot) {
    set_plot(plot);
    return table_;
  }

  /// Range of DBH of the plot's trees.
  std::pair<double, double> range_of(std::string_view plot) const {
    const data::TextColumn plots = record_.table.labels(record_.study.options.group);
    std::pair<double, double> range{std::numeric_limits<double>::infinity(),
                                    -std::numeric_limits<double>::infinity()};
    for (std::size_t i = 0; i < result_.rows.size(); ++i) {
      if (plots[result_.rows[i]] != plot) continue;
      range = {std::min(range.first, dbh_[i]), std::max(range.second, dbh_[i])};
    }
    return range;
  }

 private:
  void hold(const std::string& name) {
    const double mean = mean_of(values_of(record_.table, result_.rows, name));
    table_.set(name, std::vector<double>(kGridPoints, mean));
    const bool is_used = result_.with_covariates && uses(result_.with_covariates->fit, name);
    if (is_used) curves_.held_at[name] = mean;
  }

  void set_height() {
    if (const ResponseStudy* heights = height_study(result_.species, record_.study)) {
      const fit::FittedModel& model = heights->nlme ? heights->nlme->fit : heights->ols->fit;
      curves_.h_m = predicted(model, table_, fit::Level::kPopulation);
    } else {
      const double mean = mean_of(values_of(record_.table, result_.rows, "h"));
      curves_.held_at["h"] = mean;
      curves_.h_m.assign(kGridPoints, mean);
    }
    table_.set("h", curves_.h_m);
  }

  void set_plot(const std::string& plot) {
    data::TextColumn column;
    for (std::size_t i = 0; i < kGridPoints; ++i) column.append(plot);
    table_.set(record_.study.options.group, std::move(column));
  }

  const ResponseStudy& result_;
  const StudyRecord& record_;
  Curves& curves_;
  std::vector<double> dbh_;
  data::Table table_;
};

}  // namespace

std::optional<Curves> curves_of(const ResponseStudy& result, const StudyRecord& record) {
  if (!result.ols) return std::nullopt;
  Curves curves;
  CurveGrid grid(result, record, curves);
  curves.ols = predicted(result.ols->fit, grid.table(), fit::Level::kPopulation);
  curves.population.assign(curves.dbh_cm.size(), data::kMissing);
  if (!result.nlme) return curves;
  const fit::FittedModel& mixed = result.nlme->fit;
  curves.population = predicted(mixed, grid.table(), fit::Level::kPopulation);
  for (const std::string& plot : mixed.group_labels) {
    const auto [low, high] = grid.range_of(plot);
    std::vector<double> values = predicted(mixed, grid.for_plot(plot), fit::Level::kConditional);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (curves.dbh_cm[i] < low || curves.dbh_cm[i] > high) values[i] = data::kMissing;
    }
    curves.plots[plot] = std::move(values);
  }
  return curves;
}

}  // namespace silvafit::study
