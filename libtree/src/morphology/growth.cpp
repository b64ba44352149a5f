// SPDX-License-Identifier: MIT
#include "silvafit/tree/growth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "morphology/plot_choice.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

struct RowsOfMoment {
  std::string name{};
  double time = 0.0;
  std::vector<std::size_t> rows{};
};

std::vector<RowsOfMoment> rows_by(const data::Table& table,
                                  const std::string& by,
                                  std::vector<LeftOut>& left_out) {
  if (!table.has(by)) {
    throw InputError("no such column to split the table by time",
                     {.file = table.file(), .line = 1, .column = by});
  }
  const data::TextColumn labels = table.labels(by);
  std::vector<RowsOfMoment> moments(labels.levels().size());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (labels.is_missing(row)) {
      left_out.push_back(
          {{.file = table.file(), .line = table.line(row), .column = by}, "the time is missing"});
      continue;
    }
    RowsOfMoment& moment = moments[labels.code(row)];
    moment.name = labels[row];
    moment.time = table.is_numeric(by) ? table.numbers(by)[row] : labels.code(row);
    moment.rows.push_back(row);
  }
  std::erase_if(moments, [](const RowsOfMoment& moment) { return moment.rows.empty(); });
  std::sort(moments.begin(), moments.end(), [](const RowsOfMoment& a, const RowsOfMoment& b) {
    return a.time < b.time;
  });
  return moments;
}

/// The plots of the rows; nothing without such a column, which is an error when the table is read.
std::optional<data::TextColumn> plot_labels(const data::Table& table,
                                            const MorphologyTableOptions& options) {
  const auto mapped = options.columns.find("plot");
  const std::string column = mapped == options.columns.end() ? "plot" : mapped->second;
  if (!table.has(column)) return std::nullopt;
  return table.labels(column);
}

/// The chosen plots with a row; a plot may be measured at some times only.
std::vector<std::string> plots_in(const data::Table& table, const MorphologyTableOptions& options) {
  const auto labels = plot_labels(table, options);
  if (!labels) return options.plots;
  std::vector<std::string> plots;
  std::copy_if(options.plots.begin(),
               options.plots.end(),
               std::back_inserter(plots),
               [&](const std::string& plot) {
                 return labels->code_of(plot) != data::TextColumn::kMissingCode;
               });
  return plots;
}

/// Whether two measurements of a tree give the same model.
bool same(const Morphology& a, Morphology b) {
  b.position = a.position;
  return a == b;
}

/// East-west, up and north-south.
std::array<double, 3> extent_of(const Morphology& tree) {
  if (!tree.radii) return {tree.cw_m.value_or(1.0), tree.h_m, tree.cw_m.value_or(1.0)};
  return {
      tree.radii->east_m + tree.radii->west_m, tree.h_m, tree.radii->north_m + tree.radii->south_m};
}

constexpr std::array<double, 3> kWhole{1.0, 1.0, 1.0};
constexpr std::array<double, 3> kNothing{0.0, 0.0, 0.0};

std::array<double, 3> growth_between(const Morphology& from, const Morphology& to) {
  const std::array<double, 3> a = extent_of(from);
  const std::array<double, 3> b = extent_of(to);
  return {b[0] / a[0], b[1] / a[1], b[2] / a[2]};
}

/// Files store the times of keyframes in single precision; there, too, times must
/// increase.
void check_times(const std::vector<Keyframe>& keyframes, const std::string& moment) {
  double before = -1.0;
  for (const Keyframe& keyframe : keyframes) {
    // Converting a number beyond the range of floats is undefined.
    if (!(keyframe.time_s <= double{std::numeric_limits<float>::max()})) {
      throw UsageError(fmt::format(
          "the animation would last {:.3g} s, which is too long for a file; use fewer `seconds`",
          keyframe.time_s));
    }
    const double stored = static_cast<float>(keyframe.time_s);
    if (!(stored > before)) {
      throw UsageError(
          fmt::format("at time {} the animation has times that single precision cannot distinguish "
                      "({:.9g} s from its start); give times in larger units, such as years, "
                      "remove times that are far away, or use more `seconds`",
                      moment,
                      keyframe.time_s));
    }
    before = stored;
  }
}

}  // namespace

Moments read_moments(const data::Table& table,
                     const std::string& by,
                     const MorphologyTableOptions& options) {
  Moments result;
  const std::vector<RowsOfMoment> all = rows_by(table, by, result.left_out);
  if (const auto labels = plot_labels(table, options)) {
    require_plots(options.plots, *labels, table.file());
  }
  for (const RowsOfMoment& moment : all) {
    const data::Table part = table.select(moment.rows);
    MorphologyTableOptions of_part = options;
    of_part.plots = plots_in(part, options);
    if (of_part.plots.empty() && !options.plots.empty()) continue;
    MorphologyTable read = read_morphologies(part, of_part);
    result.left_out.insert(result.left_out.end(), read.left_out.begin(), read.left_out.end());
    if (read.morphologies.empty()) continue;
    result.moments.push_back({moment.name, moment.time, std::move(read.morphologies)});
  }
  return result;
}

std::vector<GrowingTree> growing_trees(std::span<const Moment> moments) {
  std::vector<GrowingTree> trees;
  std::map<std::pair<std::string, std::string>, std::size_t> places;
  for (std::size_t moment = 0; moment < moments.size(); ++moment) {
    for (const Morphology& tree : moments[moment].trees) {
      const auto [found, is_new] = places.try_emplace({tree.plot, tree.tree}, trees.size());
      if (is_new) trees.emplace_back();
      GrowingTree& growing = trees[found->second];
      growing.gone = moment + 1;
      if (is_new || !same(growing.stages.back().tree, tree)) {
        growing.stages.push_back({moment, tree});
      }
    }
  }
  return trees;
}

std::vector<AnimatedModel> animated(const GrowingTree& tree,
                                    std::span<const Moment> moments,
                                    std::span<const SceneWriter::Model> models,
                                    const Pace& pace) {
  if (!(pace.seconds_per_unit > 0.0 && pace.growing_up >= 0.0)) {
    throw UsageError("the duration per unit of time must be above 0 seconds");
  }
  const double start = moments.front().time;
  const auto seconds = [&](double time) { return pace.seconds_per_unit * (time - start); };
  const double end = seconds(moments.back().time + 1.0);
  const bool stays = tree.gone == moments.size();
  const double last = stays ? end : seconds(moments[tree.gone].time);
  std::vector<AnimatedModel> animated_models;
  for (std::size_t i = 0; i < tree.stages.size(); ++i) {
    const Stage& stage = tree.stages[i];
    const double time = moments[stage.moment].time;
    const double there = seconds(time);
    const bool is_last = i + 1 == tree.stages.size();
    const double until = is_last ? last : seconds(moments[tree.stages[i + 1].moment].time);
    double from = there;
    AnimatedModel model{.model = models[i], .name = moments[stage.moment].name};
    if (i == 0 && stage.moment > 0) {
      const double before = moments[stage.moment - 1].time;
      from = seconds(std::max(before, time - pace.growing_up));
      if (from < there) model.size.push_back({from, kNothing});
    }
    if (from > 0.0) model.shown.push_back({0.0, kNothing});
    model.shown.push_back({from, kWhole});
    if (until < end) model.shown.push_back({until, kNothing});
    model.shown.push_back({end, until < end ? kNothing : kWhole});
    if (!is_last) {
      model.size.push_back({there, kWhole});
      model.size.push_back({until, growth_between(stage.tree, tree.stages[i + 1].tree)});
    } else if (!model.size.empty()) {
      model.size.push_back({there, kWhole});
    }
    model.at_rest = is_last && stays;
    check_times(model.shown, model.name);
    check_times(model.size, model.name);
    animated_models.push_back(std::move(model));
  }
  return animated_models;
}

}  // namespace silvafit::tree
