// SPDX-License-Identifier: MIT
#include "silvafit/study/impute_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/json_values.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/idle_settings.hpp"
#include "silvafit/study/rows_with_columns.hpp"
#include "silvafit/study/table_checks.hpp"
#include "silvafit/study/tree_table.hpp"
#include "workflow/flow.hpp"

namespace silvafit::study {
namespace {

using nlohmann::ordered_json;

/// Columns that keep their spelling: the groups, and the column of separate models.
std::vector<std::string> label_columns(const ImputeOptions& options) {
  std::vector<std::string> labels{options.group.empty() ? "plot" : options.group, options.by};
  if (options.random.empty() || options.random == "none") return labels;
  for (const auto& random : fit::parse_random_effects(options.random)) {
    labels.push_back(random.group);
  }
  return labels;
}

/// The name of the response in the file.
std::string column_in(const ReadTable& read, const std::string& response) {
  const auto found = read.columns.find(response);
  return found == read.columns.end() ? response : found->second;
}

void check_columns(const ImputeOptions& options, const ReadTable& read) {
  const data::Table& table = read.table;
  for (const std::string& name : {options.response, options.by, options.group}) {
    if (name.empty() || table.has(name)) continue;
    throw InputError(data::no_such_column(name, table.names()), {.file = table.file()});
  }
  const std::string column = column_in(read, options.response);
  refuse_known_columns(
      imputation_columns(column, options.interval > 0.0), table.names(), table.file());
}

void add_to(const TableImputation& part, ImputationSummary& summary) {
  const Imputation& result = part.imputation;
  summary.trees += result.value.size();
  for (const ImputeSource source : result.source) ++summary.sources[source];
  for (const ImputeLevel level : result.level) ++summary.levels[level];
  for (const std::string& flag : result.flag) {
    if (!flag.empty()) ++summary.flags[flag];
  }
  summary.recognized = part.recognized;
  summary.models = result.models;
  summary.notes = result.notes;
}

template <class Key>
std::size_t count(const std::map<Key, std::size_t>& counts, Key key) {
  const auto found = counts.find(key);
  return found == counts.end() ? 0 : found->second;
}

ModelColumns model_columns(const ImputeOptions& options, ReadingState* state) {
  const std::vector<std::string> labels = label_columns(options);
  std::vector<std::string> wanted = labels;
  wanted.insert(wanted.end(), {options.response, "dbh"});
  // Plots may be numbered within stands; which coefficient varies does not matter for that.
  std::string random = options.random.empty() ? "a | " + labels.front() : options.random;
  if (random == "none") random.clear();
  return {.names = labels,
          .random = std::move(random),
          .wanted = std::move(wanted),
          .finds_dead = true,
          .state = state};
}

/// Rows of tables with the same columns, one after another.
data::Table joined(const std::vector<data::Table>& parts) {
  data::Table table;
  std::vector<std::uint32_t> lines;
  for (const data::Table& part : parts) {
    for (std::size_t row = 0; row < part.rows(); ++row) {
      lines.push_back(static_cast<std::uint32_t>(part.line(row)));
    }
  }
  table = data::Table(lines.size());
  for (const std::string& name : parts.front().names()) {
    std::vector<double> numbers;
    data::TextColumn texts;
    const bool is_numeric = parts.front().is_numeric(name);
    for (const data::Table& part : parts) {
      if (is_numeric) {
        const auto values = part.numbers(name);
        numbers.insert(numbers.end(), values.begin(), values.end());
        continue;
      }
      const data::TextColumn& own = part.text(name);
      for (std::size_t row = 0; row < own.size(); ++row) {
        own.is_missing(row) ? texts.append_missing() : texts.append(own[row]);
      }
    }
    is_numeric ? table.set(name, std::move(numbers)) : table.set(name, std::move(texts));
  }
  table.set_origin(parts.front().file(), std::move(lines));
  return table;
}

data::Table measured_rows(const data::Table& table, const std::string& response) {
  require_numbers(table, {response});
  const auto values = table.numbers(response);
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (std::isfinite(values[row])) rows.push_back(row);
  }
  return table.select(rows);
}

/// The column of the coarsest groups, whose trees are imputed together.
std::string group_column(const ImputeOptions& options) {
  if (!options.random.empty() && options.random != "none") {
    return fit::parse_random_effects(options.random).front().group;
  }
  return options.group.empty() ? "plot" : options.group;
}

/// The rows of a table that are observations of living trees. Other rows are copies of them, or of
/// dead trees, which are neither used for models nor filled in.
class Observed {
 public:
  explicit Observed(const ObservedTable& read) : table_(read.table) {
    for (std::size_t row = 0; row < table_.rows(); ++row) {
      const std::size_t first = read.place.empty() ? row : read.distinct[read.place[row]];
      const bool is_dead = !read.is_dead.empty() && read.is_dead[first] != 0;
      if (first == row && !is_dead) living_.push_back(row);
      place_.push_back(is_dead ? kDead : first == row ? living_.size() - 1 : place_[first]);
    }
  }

  data::Table living() const { return table_.select(living_); }

  /// The imputation of all rows by that of the living trees.
  Imputation completed(Imputation of_living, const std::string& response) const {
    if (living_.size() == table_.rows()) return of_living;
    const std::size_t rows = table_.rows();
    Imputation result{.models = std::move(of_living.models),
                      .value = std::vector<double>(rows, data::kMissing),
                      .source = std::vector<ImputeSource>(rows, ImputeSource::kMissing),
                      .level = std::vector<ImputeLevel>(rows, ImputeLevel::kNone),
                      .flag = std::vector<std::string>(rows, "no living tree"),
                      .notes = std::move(of_living.notes)};
    if (!of_living.lower.empty()) {
      result.lower.assign(rows, data::kMissing);
      result.upper = result.lower;
    }
    const auto measured = table_.numbers(response);
    for (std::size_t row = 0; row < rows; ++row) {
      const std::size_t place = place_[row];
      if (place == kDead) {
        result.value[row] = measured[row];
        if (std::isfinite(measured[row])) result.source[row] = ImputeSource::kMeasured;
        continue;
      }
      result.value[row] = of_living.value[place];
      if (!of_living.lower.empty()) {
        result.lower[row] = of_living.lower[place];
        result.upper[row] = of_living.upper[place];
      }
      result.source[row] = of_living.source[place];
      result.level[row] = of_living.level[place];
      result.flag[row] = of_living.flag[place];
    }
    return result;
  }

 private:
  static constexpr auto kDead = static_cast<std::size_t>(-1);

  const data::Table& table_;
  std::vector<std::size_t> living_{};
  std::vector<std::size_t> place_{};  ///< of each row, or of the row it copies, in the above
};

/// The models of a file that is read in parts.
ImputeModels models_of_parts(const data::TableSource& trees,
                             const Catalogue& catalogue,
                             const ImputeOptions& options,
                             const ReadingSettings& reading) {
  TableFlow flow(trees, reading, {.is_in_parts = true, .threads = 1}, [&](const auto&) {
    return group_column(options);
  });
  ReadingState state;
  std::vector<data::Table> measured;
  std::vector<std::string> labels;
  while (const auto rows = flow.next()) {
    const ObservedTable read = read_model_table(*rows, reading, model_columns(options, &state));
    check_columns(options, read);
    add_labels(read.table, options, labels);
    measured.push_back(measured_rows(Observed(read).living(), options.response));
  }
  // In the order of the file, on which rounding errors of sums depend.
  const data::Table all = joined(measured);
  std::vector<std::size_t> order(all.rows());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&all](std::size_t row) { return all.line(row); });
  return imputation_models(all.select(order), catalogue, options, labels);
}

/// Such as ", random a | stand; a + b | plot"; empty without.
std::string random_text(const fit::ModelSpecification& specification) {
  std::string text;
  for (const fit::RandomEffects& term : specification.random) {
    text +=
        fmt::format("{}{} | {}", text.empty() ? ", random " : "; ", term.text(), term.group_text());
  }
  return text;
}

/// The species or part that a model is for, if there are several models.
std::string label_of(const ImputeModel& model, const ImputeOptions& options) {
  if (options.by.empty()) return "";
  return (model.label.empty() ? "all others" : model.label) + ": ";
}

}  // namespace

ImputationSummary impute_trees(const data::TableSource& trees,
                               const Catalogue& catalogue,
                               const ImputeOptions& options,
                               const ReadingSettings& reading,
                               bool is_in_parts,
                               const ImputationSink& sink,
                               const Callbacks& callbacks) {
  IdleReasons idle;
  if (!options.random.empty()) idle["group"] = "beside `random`";
  refuse_idle_settings(options, {}, idle);
  if (is_in_parts && options.add_residual) {
    throw UsageError(
        "cannot be used with `stream`: random numbers are drawn for all plots together",
        {.column = "`add_residual`"});
  }
  ImputeModels models;
  if (is_in_parts) models = models_of_parts(trees, catalogue, options, reading);
  TableFlow flow(
      trees,
      reading,
      {.is_in_parts = is_in_parts, .threads = options.threads},
      [&](const auto&) { return group_column(options); },
      callbacks.note);
  ImputationSummary summary{.options = options};
  ReadingState state;
  while (const auto rows = flow.next()) {
    ObservedTable read = read_model_table(*rows,
                                          reading,
                                          model_columns(options, is_in_parts ? &state : nullptr),
                                          is_in_parts ? NoteCallback() : callbacks.note);
    check_columns(options, read);
    TableImputation part{.options = options,
                         .column = column_in(read, options.response),
                         .is_in_file_order = !flow.is_sorted()};
    const Observed observed(read);
    const data::Table living = observed.living();
    part.imputation = observed.completed(
        is_in_parts ? impute_with(models, living, options) : impute(living, catalogue, options),
        options.response);
    part.table = std::move(read.table);
    part.recognized = std::move(read.recognized);
    add_to(part, summary);
    if (!is_in_parts) give_notes(summary.notes, callbacks.note);
    sink(*rows, part);
    if (is_in_parts && callbacks.progress) {
      callbacks.progress("trees", summary.trees, flow.rows());
    }
  }
  if (is_in_parts) give_notes(summary.recognized, callbacks.note);
  if (is_in_parts) give_notes(summary.notes, callbacks.note);
  return summary;
}

TableImputation impute_table(const data::TableSource& trees,
                             const Catalogue& catalogue,
                             const ImputeOptions& options,
                             const ReadingSettings& reading,
                             const Callbacks& callbacks) {
  TableImputation result;
  const auto take = [&](const data::TableSource&, TableImputation& all) {
    result = std::move(all);
  };
  impute_trees(trees, catalogue, options, reading, false, take, callbacks);
  return result;
}

std::vector<std::string> imputation_columns(const std::string& column, bool has_intervals) {
  std::vector<std::string> names{column + "_source", column + "_level", column + "_flag"};
  if (has_intervals) names.insert(names.end(), {column + "_lower", column + "_upper"});
  return names;
}

AddedColumns added_columns(const TableImputation& imputed, int digits) {
  return {.table = imputed_columns(imputed),
          .digits = digits,
          .replaced = imputed.column,
          .is_replaced = [&source = imputed.imputation.source](std::size_t row) {
            return source[row] == ImputeSource::kImputed;
          }};
}

data::Table imputed_columns(const TableImputation& imputed) {
  const Imputation& result = imputed.imputation;
  data::TextColumn source;
  data::TextColumn level;
  data::TextColumn flag;
  for (std::size_t row = 0; row < result.value.size(); ++row) {
    source.append(word_of(result.source[row]));
    level.append(word_of(result.level[row]));
    flag.append(result.flag[row]);
  }
  const bool has_intervals = !result.lower.empty();
  const std::vector<std::string> names = imputation_columns(imputed.column, has_intervals);
  data::Table table(result.value.size());
  table.set(imputed.column, result.value);
  table.set(names[0], std::move(source));
  table.set(names[1], std::move(level));
  table.set(names[2], std::move(flag));
  if (!has_intervals) return table;
  table.set(names[3], result.lower);
  table.set(names[4], result.upper);
  return table;
}

std::vector<std::string> summary_of(const ImputationSummary& summary) {
  std::vector<std::string> lines;
  for (const ImputeModel& model : summary.models) {
    const fit::FittedModel& fit = model.fit;
    lines.push_back(fmt::format("{}{}{}{}, variance {}, {} trees, {}RMSE {:.4g}",
                                label_of(model, summary.options),
                                fit.model.empty() ? "" : fit.model + " ",
                                fit.specification.formula.text,
                                random_text(fit.specification),
                                fit.specification.variance.text(),
                                fit.observations,
                                fit.specification.random.empty() ? "" : "conditional ",
                                fit.conditional.rmse));
  }
  const std::size_t stand = count(summary.levels, ImputeLevel::kStand);
  lines.push_back(
      fmt::format("{}: {} measured, {} imputed with the curve of their plot, {}{} with the "
                  "population curve, {} left empty",
                  summary.options.response,
                  count(summary.sources, ImputeSource::kMeasured),
                  count(summary.levels, ImputeLevel::kPlot),
                  stand > 0 ? fmt::format("{} with their stand, ", stand) : "",
                  count(summary.levels, ImputeLevel::kPopulation),
                  count(summary.sources, ImputeSource::kMissing)));
  for (const auto& [flag, trees] : summary.flags) {
    lines.push_back(fmt::format("{}: {}", counted(trees, "tree", "trees"), flag));
  }
  return lines;
}

std::vector<std::string> summary_of(const TableImputation& imputed) {
  ImputationSummary summary{.options = imputed.options};
  add_to(imputed, summary);
  return summary_of(summary);
}

ordered_json json_of(const ImputationSummary& summary, const std::string& out) {
  ordered_json models = ordered_json::array();
  for (const ImputeModel& model : summary.models) {
    models.push_back({{"label", text_or_null(model.label)}, {"fit", fit::json_of(model.fit)}});
  }
  return {{"schema", "silvafit-impute/1"},
          {"silvafit", SILVAFIT_VERSION},
          {"response", summary.options.response},
          {"out", text_or_null(out)},
          {"n", summary.trees},
          {"measured", count(summary.sources, ImputeSource::kMeasured)},
          {"imputed",
           {{"plot", count(summary.levels, ImputeLevel::kPlot)},
            {"stand", count(summary.levels, ImputeLevel::kStand)},
            {"population", count(summary.levels, ImputeLevel::kPopulation)}}},
          {"missing", count(summary.sources, ImputeSource::kMissing)},
          {"flags", summary.flags},
          {"residual_added", summary.options.add_residual},
          {"models", std::move(models)},
          {"recognized", summary.recognized},
          {"notes", summary.notes}};
}

}  // namespace silvafit::study
