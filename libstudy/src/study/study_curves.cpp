// SPDX-License-Identifier: MIT
#include "study/study_curves.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "silvafit/fit/prediction.hpp"
#include "study/chosen_fits.hpp"

namespace silvafit::study {
namespace {

constexpr std::size_t kGridPoints = 60;

/// Classes of covariates that are proportions, such as the structural indices of four neighbors.
const std::vector<double> kShareClasses{0.0, 0.25, 0.5, 0.75, 1.0};
/// Classes of other covariates are at these quantiles of the trees.
constexpr std::array<double, 5> kQuantiles{0.1, 0.3, 0.5, 0.7, 0.9};

std::vector<double> values_of(const data::Table& table,
                              const std::vector<std::size_t>& rows,
                              const std::string& name) {
  std::vector<double> values;
  values.reserve(rows.size());
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

CurveBand band_of(const fit::FittedModel& model, const data::Table& grid) {
  constexpr double kCoverage = 0.95;
  const fit::Prediction prediction =
      fit::predict(model,
                   grid,
                   fit::Level::kPopulation,
                   {.interval = kCoverage, .interval_kind = fit::IntervalKind::kConfidence});
  return {.low = {prediction.lower.begin(), prediction.lower.end()},
          .high = {prediction.upper.begin(), prediction.upper.end()}};
}

bool uses(const fit::FittedModel& model, const std::string& name) {
  return std::ranges::any_of(model.ranges,
                             [&](const fit::ColumnRange& range) { return range.column == name; });
}

bool any_uses(const ResponseStudy& result, const std::string& name) {
  return std::ranges::any_of(chosen_fits(result),
                             [&](const ChosenFit& chosen) { return uses(*chosen.fit, name); });
}

std::vector<double> classes_of(std::vector<double> values) {
  std::ranges::sort(values);
  if (values.front() >= 0.0 && values.back() <= 1.0) return kShareClasses;
  std::vector<double> classes;
  for (const double share : kQuantiles) {
    const double place = share * static_cast<double>(values.size() - 1);
    classes.push_back(values[static_cast<std::size_t>(std::lround(place))]);
  }
  classes.erase(std::unique(classes.begin(), classes.end()), classes.end());
  return classes;
}

std::vector<std::size_t> count_nearest(const std::vector<double>& classes,
                                       const std::vector<double>& values) {
  std::vector<std::size_t> counts(classes.size(), 0);
  for (const double value : values) {
    const auto nearest = std::ranges::min_element(
        classes, {}, [&](double center) { return std::abs(center - value); });
    ++counts[static_cast<std::size_t>(nearest - classes.begin())];
  }
  return counts;
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
    for (const ChosenFit& chosen : chosen_fits(result)) {
      for (const fit::ColumnRange& range : chosen.fit->ranges) hold(range.column);
    }
    if (any_uses(result, "h")) set_height();
    set_plot("");
  }

  const data::Table& table() const { return table_; }

  /// The grid with another value of a covariate than its mean, for all plots.
  data::Table with(const std::string& name, double value) {
    set_plot("");
    data::Table table = table_;
    table.set(name, std::vector<double>(kGridPoints, value));
    return table;
  }

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
    if (name == "dbh" || name == "h" || table_.has(name)) return;
    const double mean = mean_of(values_of(record_.table, result_.rows, name));
    table_.set(name, std::vector<double>(kGridPoints, mean));
    curves_.held_at[name] = mean;
  }

  void set_height() {
    if (const ResponseStudy* heights = height_study(result_.species, record_.study)) {
      const fit::FittedModel& model = heights->nlme ? heights->nlme->fit : heights->ols->fit;
      for (const fit::ColumnRange& range : model.ranges) hold(range.column);
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
    const std::string& period = record_.study.options.period;
    if (period.empty()) return;
    // The curve of a plot, without the effects of one of its periods and trees.
    data::TextColumn none;
    for (std::size_t i = 0; i < kGridPoints; ++i) none.append_missing();
    table_.set(period, none);
    // The trees' effects are within plots, too.
    if (record_.study.options.group != "plot") table_.set("plot", none);
    table_.set(kTree, std::move(none));
  }

  const ResponseStudy& result_;
  const StudyRecord& record_;
  Curves& curves_;
  std::vector<double> dbh_;
  data::Table table_;
};

std::vector<double> predicted_or_missing(const std::optional<fit::FitResult>& fit,
                                         const data::Table& grid) {
  if (!fit) return std::vector<double>(kGridPoints, data::kMissing);
  return predicted(fit->fit, grid, fit::Level::kPopulation);
}

ClassCurves class_curves(const std::string& name,
                         const ResponseStudy& result,
                         const StudyRecord& record,
                         CurveGrid& grid) {
  const std::vector<double> values = values_of(record.table, result.rows, name);
  ClassCurves curves{.covariate = name, .classes = classes_of(values)};
  curves.trees = count_nearest(curves.classes, values);
  for (const double value : curves.classes) {
    const data::Table table = grid.with(name, value);
    curves.covariates.push_back(predicted_or_missing(result.with_covariates, table));
    curves.population.push_back(predicted_or_missing(result.nlme, table));
  }
  return curves;
}

}  // namespace

std::vector<std::string> covariates_of(const ResponseStudy& result) {
  std::vector<std::string> names;
  const auto fits = chosen_fits(result);
  if (fits.empty()) return names;
  for (const fit::ColumnRange& range : fits.back().fit->ranges) {
    if (range.column != "dbh" && range.column != "h") names.push_back(range.column);
  }
  return names;
}

std::optional<Curves> curves_of(const ResponseStudy& result, const StudyRecord& record) {
  if (!result.ols) return std::nullopt;
  Curves curves;
  CurveGrid grid(result, record, curves);
  curves.ols = predicted(result.ols->fit, grid.table(), fit::Level::kPopulation);
  curves.ols_band = band_of(result.ols->fit, grid.table());
  for (const std::string& name : covariates_of(result)) {
    curves.by_class.push_back(class_curves(name, result, record, grid));
  }
  curves.population.assign(curves.dbh_cm.size(), data::kMissing);
  if (!result.nlme) return curves;
  const fit::FittedModel& mixed = result.nlme->fit;
  curves.population = predicted(mixed, grid.table(), fit::Level::kPopulation);
  curves.population_band = band_of(mixed, grid.table());
  for (const std::string& plot : mixed.random.front().labels) {
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
