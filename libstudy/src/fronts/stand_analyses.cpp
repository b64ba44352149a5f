// SPDX-License-Identifier: MIT
// Structural units, stands, imputation, studies, libraries, 3D.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "fronts/call.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "silvafit/stand/stand_json.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/grow_setting_list.hpp"
#include "silvafit/study/impute_table.hpp"
#include "silvafit/study/indices.hpp"
#include "silvafit/study/study_files.hpp"
#include "silvafit/study/view_page.hpp"
#include "silvafit/study/whole_study.hpp"

namespace silvafit::study {
namespace {

/// The rows that an inventory was read from.
std::vector<std::size_t> rows_of(const stand::Inventory& inventory) {
  std::vector<std::size_t> rows;
  for (const std::uint32_t line : inventory.lines) rows.push_back(line - 1);
  return rows;
}

/// Those that a table has of the rows that were read.
std::vector<std::size_t> rows_of(const data::Table& table) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    rows.push_back(table.line(row) > 0 ? table.line(row) - 1 : row);
  }
  return rows;
}

/// On the skipped rows; none if there are none.
std::vector<std::string> warnings_on(const stand::CheckedInventory& checked) {
  stand::ExcludedSummary excluded;
  excluded.add(checked);
  std::vector<std::string> warnings{excluded.text(checked.inventory.file)};
  std::erase(warnings, "");
  return warnings;
}

/// The columns that labels of stand tables are from.
std::map<std::string, std::string> label_columns(const stand::Inventory& inventory,
                                                 const StandOptions& options) {
  std::map<std::string, std::string> columns = inventory.label_columns;
  if (!options.report.stratum.empty()) columns["stratum"] = options.report.stratum;
  if (columns.contains("time")) columns["from"] = columns["to"] = columns["time"];
  return columns;
}

/// How many rows have no value, and the first of them; none if all have one.
std::vector<std::string> without_value(const std::string& column,
                                       const std::vector<std::size_t>& rows,
                                       const std::vector<std::string>& flags,
                                       const data::Table& table) {
  if (rows.empty()) return {};
  return {fmt::format("{} no {}, the first: {}",
                      counted(rows.size(), "row has", "rows have"),
                      column,
                      describe(data::place_of(table, rows.front(), ""), flags[rows.front()]))};
}

/// On values that could not be predicted although the predictors are known.
std::vector<std::string> warnings_on(const TablePrediction& found) {
  std::vector<std::string> warnings;
  const std::vector<std::string>& flags = found.predictions.flags;
  for (const PredictedResponse& response : found.predictions.responses) {
    std::vector<std::size_t> rows;
    for (std::size_t row = 0; row < flags.size(); ++row) {
      if (std::isnan(response.value[row]) && !flags[row].starts_with("missing"))
        rows.push_back(row);
    }
    std::ranges::move(without_value(response.response + "_pred", rows, flags, found.table),
                      std::back_inserter(warnings));
  }
  return warnings;
}

/// On values that could not be filled in.
std::vector<std::string> warnings_on(const TableImputation& found) {
  const Imputation& result = found.imputation;
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < result.source.size(); ++row) {
    if (result.source[row] == ImputeSource::kMissing) rows.push_back(row);
  }
  return without_value(found.options.response, rows, result.flag, found.table);
}

StandOptions stand_options(AnalysisCall& call) {
  auto options = call.read_with_threads<StandOptions>();
  options.reading = call.read<ReadingSettings>();
  options.units = call.units();
  options.sampling = call.sampling();
  options.equations = call.equations();
  return options;
}

/// The new columns, and the rows of a file with them.
std::vector<std::pair<std::string, data::Table>> tables_of(const data::TableSource& source,
                                                           const AddedColumns& added,
                                                           const ReadingSettings& reading) {
  std::vector<std::pair<std::string, data::Table>> tables{{"columns", added.table}};
  if (!std::holds_alternative<std::shared_ptr<const data::Table>>(source)) {
    tables.emplace_back("rows", rows_with_columns(source, added, reading));
  }
  return tables;
}

}  // namespace

AnalysisWork structural_units_work(AnalysisCall& call) {
  IndicesOptions options{
      .reading = call.read<ReadingSettings>(), .units = call.units(), .sampling = call.sampling()};
  call.add_threads(options);
  return [options, trees = call.table()](const AnalysisCallbacks& callbacks) {
    const TreeIndices found = tree_indices(trees, options, callbacks);
    return AnalysisResult{.tables = {{"units", found.table()}},
                          .rows = rows_of(found.inventory.inventory),
                          .label_columns = found.inventory.inventory.label_columns,
                          .json = json_text(json_of(found.summary)),
                          .warnings = warnings_on(found.inventory)};
  };
}

AnalysisWork stand_summary_work(AnalysisCall& call) {
  return [options = stand_options(call), trees = call.table()](const AnalysisCallbacks& callbacks) {
    const StandSummary found = stand_summary(trees, options, callbacks);
    return AnalysisResult{.tables = tables_of(found),
                          .label_columns = label_columns(found.inventory.inventory, options),
                          .json = json_text(json_of(found)),
                          .warnings = warnings_on(found.inventory)};
  };
}

AnalysisWork stand_growth_work(AnalysisCall& call) {
  return [options = stand_options(call), trees = call.table()](const AnalysisCallbacks& callbacks) {
    const GrowthSummary found = stand_growth(trees, options, callbacks);
    return AnalysisResult{.tables = stand::tables_of(found.report),
                          .label_columns = label_columns(found.inventory.inventory, options),
                          .json = json_text(json_of(found)),
                          .warnings = warnings_on(found.inventory)};
  };
}

AnalysisWork impute_work(AnalysisCall& call) {
  const auto options = call.read_with_threads<ImputeOptions>();
  const auto reading = call.read<ReadingSettings>();
  return [options,
          reading,
          trees = call.table(),
          catalogue = call.catalogue(),
          front = call.input().front](const AnalysisCallbacks& callbacks) {
    TableImputation found = impute_table(trees, *catalogue, options, reading, callbacks);
    AnalysisResult result{
        .tables = tables_of(trees, added_columns(found, AddedColumns().digits), reading),
        .rows = rows_of(found.table),
        .json = in_words({{"sentences", summary_of(found)}}, front),
        .warnings = warnings_on(found)};
    for (ImputeModel& model : found.imputation.models) {
      result.fits.emplace_back(model.label, std::move(model.fit));
    }
    return result;
  };
}

AnalysisWork predict_library_work(AnalysisCall& call) {
  auto settings = call.read_with_threads<PredictionSettings>();
  settings.reading = call.read<ReadingSettings>();
  settings.equations = call.equations();
  return [settings,
          trees = call.table(),
          catalogue = call.catalogue(),
          library = call.input().library](const AnalysisCallbacks& callbacks) {
    const TablePrediction found = predict_table(trees, *library, *catalogue, settings, callbacks);
    const AddedColumns added{.table = new_columns(found)};
    return AnalysisResult{.tables = tables_of(trees, added, settings.reading),
                          .rows = rows_of(found.table),
                          .warnings = warnings_on(found)};
  };
}

/// Arguments besides the settings: `config`, a study.json over which the other arguments have
/// priority; `out`, the folder of the files, if there are to be any; `call`, as the report shows
/// it.
AnalysisWork study_work(AnalysisCall& call) {
  auto settings = call.read<StudyConfiguration>();
  call.complete(settings.units);
  call.complete(settings.sampling);
  const auto catalogue = call.catalogue();
  if (const std::string file = call.text("config"); !file.empty()) {
    const auto is_given = [&call](std::string_view key) {
      const bool has_plots = key == "plots" && call.input().plots;
      const bool has_window = key == "window" && call.find("windows");
      return has_plots || has_window || call.find(key);
    };
    settings = read_study_configuration(
        file, catalogue.get(), {.settings = std::move(settings), .is_given = is_given});
  }
  call.add_threads(settings.study);
  return [settings,
          catalogue,
          trees = call.table(),
          out = call.text("out"),
          command = call.text("call"),
          page = call.input().data_folder / "viewer" / "report.html",
          front = call.input().front](const AnalysisCallbacks& callbacks) {
    StudyRecord record = whole_study(trees, *catalogue, settings, callbacks);
    record.command = command;
    if (!out.empty()) write_study(record, *catalogue, page, out);
    AnalysisResult result{.rows = rows_of(record.inventory.inventory),
                          .label_columns = record.inventory.inventory.label_columns,
                          .json = in_words(json_of(record, out), front),
                          .library = library_of(record),
                          .warnings = warnings_on(record.inventory)};
    if (record.study.results.empty()) {
      result.warnings.push_back(
          fmt::format("no model was fitted. {}", fmt::join(record.study.notes, " ")));
    }
    result.tables.emplace_back("predictions", predictions_of(record, *result.library));
    return result;
  };
}

AnalysisWork grow_work(AnalysisCall& call) {
  auto settings = call.read_with_threads<GrowSettings>();
  settings.reading = call.read<ReadingSettings>();
  settings.keeps_trees = true;
  return [settings, trees = call.table(), models = call.input().data_folder / "models"](
             const AnalysisCallbacks& callbacks) {
    const auto catalogue = tree::BuilderCatalogue::load(models);
    const GrowResult found = grow(trees, catalogue, settings, callbacks);
    return AnalysisResult{.json = json_text(json_of(found)), .warnings = notes_on(found.left_out)};
  };
}

/// With the argument `file`: the page to write.
AnalysisWork view_work(AnalysisCall& call) {
  ViewPageSettings settings{.reading = call.read<ReadingSettings>(),
                            .view = call.read_with_threads<ViewOptions>()};
  return
      [settings, trees = call.table(), folder = call.input().data_folder, page = call.text("file")](
          const AnalysisCallbacks& callbacks) {
        const auto catalogue = tree::BuilderCatalogue::load(folder / "models");
        const std::filesystem::path page_template = folder / "viewer" / "scene.html";
        return AnalysisResult{.json = json_text(json_of(write_view_page(
                                  trees, catalogue, page_template, page, settings, callbacks)))};
      };
}

}  // namespace silvafit::study
