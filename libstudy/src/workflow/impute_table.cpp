// SPDX-License-Identifier: MIT
#include "silvafit/study/impute_table.hpp"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/json_values.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "silvafit/study/tree_table.hpp"
#include "workflow/repeated_rows.hpp"

namespace silvafit::study {
namespace {

using nlohmann::ordered_json;

/// Columns that keep their spelling: the groups, and those that get models of their own.
std::vector<std::string> label_columns(const ImputeOptions& options) {
  std::vector<std::string> labels{options.group.empty() ? "plot" : options.group, options.by};
  if (options.random.empty() || options.random == "none") return labels;
  for (const auto& random : fit::parse_random_effects(options.random)) {
    labels.push_back(random.group);
  }
  return labels;
}

void check_columns(const ImputeOptions& options, const data::Table& table) {
  for (const std::string& name : {options.response, options.by, options.group}) {
    if (name.empty() || table.has(name)) continue;
    throw InputError(data::no_such_column(name, table.names()), {.file = table.file()});
  }
  for (const std::string& name : imputation_columns(options.response)) {
    if (!table.has(name)) continue;
    throw InputError("the file already has this column; choose another name",
                     {.file = table.file(), .column = name});
  }
}

std::map<std::string, std::size_t> flag_counts(const Imputation& result) {
  std::map<std::string, std::size_t> counts;
  for (const std::string& flag : result.flag) {
    if (!flag.empty()) ++counts[flag];
  }
  return counts;
}

/// Such as ", random a | stand; a + b | plot"; empty without.
std::string random_text(const fit::ModelSpecification& specification) {
  std::string text;
  for (const fit::RandomEffects& term : specification.random) {
    text += fmt::format("{}{} | {}", text.empty() ? ", random " : "; ", term.text(), term.group);
  }
  return text;
}

/// The species or part that a model is for, if there are several models.
std::string label_of(const ImputeModel& model, const ImputeOptions& options) {
  if (options.by.empty()) return "";
  return (model.label.empty() ? "all others" : model.label) + ": ";
}

/// A copy of a row has its values.
void give_to_copies(const std::vector<std::size_t>& place, Imputation& imputation) {
  if (place.empty()) return;
  imputation.value = of_all_rows(imputation.value, place);
  imputation.source = of_all_rows(imputation.source, place);
  imputation.level = of_all_rows(imputation.level, place);
  imputation.flag = of_all_rows(imputation.flag, place);
}

}  // namespace

TableImputation impute_table(const data::TableSource& trees,
                             const Catalogue& catalogue,
                             const ImputeOptions& options,
                             const ReadingSettings& reading,
                             const Callbacks& callbacks) {
  const std::vector<std::string> labels = label_columns(options);
  std::vector<std::string> wanted = labels;
  wanted.insert(wanted.end(), {options.response, "dbh"});
  ObservedTable read = read_model_table(
      trees, reading, {.names = labels, .wanted = std::move(wanted)}, callbacks.note);
  check_columns(options, read.table);
  TableImputation result{.options = options};
  result.imputation = impute(read.observations(), catalogue, options);
  give_to_copies(read.place, result.imputation);
  result.table = std::move(read.table);
  result.recognized = std::move(read.recognized);
  give_notes(result.imputation.notes, callbacks.note);
  return result;
}

std::vector<std::string> imputation_columns(const std::string& response) {
  return {response + "_source", response + "_level", response + "_flag"};
}

data::Table imputed_columns(const TableImputation& imputed) {
  const Imputation& result = imputed.imputation;
  data::TextColumn source;
  data::TextColumn level;
  data::TextColumn flag;
  for (std::size_t row = 0; row < result.value.size(); ++row) {
    source.append(source_text(result.source[row]));
    level.append(level_text(result.level[row]));
    flag.append(result.flag[row]);
  }
  const std::vector<std::string> names = imputation_columns(imputed.options.response);
  data::Table table(result.value.size());
  table.set(imputed.options.response, result.value);
  table.set(names[0], std::move(source));
  table.set(names[1], std::move(level));
  table.set(names[2], std::move(flag));
  return table;
}

std::vector<std::string> summary_of(const TableImputation& imputed) {
  const Imputation& result = imputed.imputation;
  std::vector<std::string> lines;
  for (const ImputeModel& model : result.models) {
    const fit::FittedModel& fit = model.fit;
    lines.push_back(fmt::format("{}{}{}{}, variance {}, {} trees, conditional RMSE {:.4g}",
                                label_of(model, imputed.options),
                                fit.model.empty() ? "" : fit.model + " ",
                                fit.specification.formula.text,
                                random_text(fit.specification),
                                fit.specification.variance.text(),
                                fit.observations,
                                fit.conditional.rmse));
  }
  const std::size_t stand = result.count(ImputeLevel::kStand);
  lines.push_back(
      fmt::format("{}: {} measured, {} imputed with the curve of their plot, {}{} with the "
                  "population curve, {} left empty",
                  imputed.options.response,
                  result.count(ImputeSource::kMeasured),
                  result.count(ImputeLevel::kPlot),
                  stand > 0 ? fmt::format("{} with their stand, ", stand) : "",
                  result.count(ImputeLevel::kPopulation),
                  result.count(ImputeSource::kMissing)));
  for (const auto& [flag, count] : flag_counts(result)) {
    lines.push_back(fmt::format("{}: {}", counted(count, "tree", "trees"), flag));
  }
  return lines;
}

ordered_json json_of(const TableImputation& imputed, const std::string& out) {
  const Imputation& result = imputed.imputation;
  ordered_json models = ordered_json::array();
  for (const ImputeModel& model : result.models) {
    models.push_back({{"label", text_or_null(model.label)}, {"fit", fit::json_of(model.fit)}});
  }
  return {{"schema", "silvafit-impute/1"},
          {"silvafit", SILVAFIT_VERSION},
          {"response", imputed.options.response},
          {"out", text_or_null(out)},
          {"n", result.value.size()},
          {"measured", result.count(ImputeSource::kMeasured)},
          {"imputed",
           {{"plot", result.count(ImputeLevel::kPlot)},
            {"stand", result.count(ImputeLevel::kStand)},
            {"population", result.count(ImputeLevel::kPopulation)}}},
          {"missing", result.count(ImputeSource::kMissing)},
          {"flags", flag_counts(result)},
          {"residual_added", imputed.options.add_residual},
          {"models", std::move(models)},
          {"recognized", imputed.recognized},
          {"notes", result.notes}};
}

}  // namespace silvafit::study
