// SPDX-License-Identifier: MIT
#include "silvafit/study/view_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/grow.hpp"
#include "silvafit/study/idle_settings.hpp"
#include "silvafit/study/report_page.hpp"
#include "silvafit/study/setting_list.hpp"
#include "silvafit/study/tree_table.hpp"
#include "silvafit/tree/scene_reader.hpp"
#include "workflow/flow.hpp"

namespace silvafit::study {
namespace {

namespace fs = std::filesystem;

/// Whether a file name has the ending of a table, or none.
bool is_called_table(const fs::path& file) {
  const std::string ending = file.extension().string();
  return ending.empty() || ending == ".csv" || ending == ".CSV" || ending == ".txt";
}

/// A GLB scene is shown unchanged; what chooses its trees needs a table of them.
void refuse_idle_on_scene(const ViewPageSettings& settings) {
  IdleReasons idle;
  for (const char* const looks : {"models", "lod", "textures", "season"}) {
    idle[looks] = "on a GLB scene, which is shown unchanged; use it in grow";
  }
  const char* const without_table = "on a GLB scene without a table of its trees";
  if (!settings.trees) {
    idle["plots"] = idle["mark"] = without_table;
    const auto note = [&](const auto& setting) { idle[setting.key] = without_table; };
    each_setting(settings.reading, note);
    each_setting(settings.reading.rows, note);
  }
  refuse_idle_settings(settings.view, {}, idle);
  refuse_idle_settings(settings.reading, {}, idle);
  refuse_idle_settings(settings.reading.rows, {}, idle);
}

/// Determines the kind of a source, and reads it.
class ViewSource {
 public:
  ViewSource(const tree::BuilderCatalogue& catalogue,
             const ViewPageSettings& settings,
             const Callbacks& callbacks)
      : catalogue_(catalogue), settings_(settings), options_(settings.view), callbacks_(callbacks) {
    options_.version = SILVAFIT_VERSION;
    options_.columns = column_map(settings.reading.columns);
    options_.terrain = settings.reading.terrain;
    std::ranges::sort(options_.levels);
    options_.levels.erase(std::unique(options_.levels.begin(), options_.levels.end()),
                          options_.levels.end());
  }

  View view_of(const data::TableSource& source) {
    const auto* const file = std::get_if<fs::path>(&source);
    if (file == nullptr) return view_of_trees(read_trees(source), catalogue_, options_);
    if (options_.title.empty()) options_.title = followed(*file).filename().string();
    if (kind_of(*file) == PathKind::kFolder) return view_of_folder(*file);
    if (is_glb(*file)) return view_of_glb(*file);
    if (file->extension() == ".gltf") {
      throw InputError("glTF with separate buffer files is not supported; use a .glb file",
                       {.file = file->string()});
    }
    return view_of_trees(table_of(*file), catalogue_, options_);
  }

  const std::string& title() const { return options_.title; }
  std::vector<std::string> recognized() && { return std::move(recognized_); }

 private:
  data::Table read_trees(const data::TableSource& source) {
    ReadTable read =
        read_tree_table(source, settings_.reading, "", options_.columns, callbacks_.note);
    recognized_ = std::move(read.recognized);
    options_.reads_codes = read.has_fia_species;
    return std::move(read.table);
  }

  /// The table of trees to show, or an error with the supported inputs.
  data::Table table_of(const fs::path& file) {
    try {
      return read_trees(file);
    } catch (const InputError& error) {
      if (is_called_table(file) || !is_there(file)) throw;
      throw InputError(
          fmt::format("not a folder of `silvafit study`, a GLB scene or a CSV table of "
                      "trees (as a table: {})",
                      error.message()),
          {.file = file.string()});
    }
  }

  View view_of_folder(const fs::path& folder) {
    const fs::path predictions = folder / "predictions.csv";
    if (!is_there(predictions)) {
      throw InputError("not a folder of `silvafit study`: it contains no predictions.csv",
                       {.file = folder.string()});
    }
    return view_of_trees(read_trees(predictions), catalogue_, options_);
  }

  View view_of_glb(const fs::path& file) {
    refuse_idle_on_scene(settings_);
    std::optional<data::Table> table;
    if (settings_.trees) table = read_trees(*settings_.trees);
    try {
      return view_of_scene(
          read_file(file, tree::kLargestScene), table ? &*table : nullptr, catalogue_, options_);
    } catch (const InputError& error) {
      if (!error.place().file.empty()) throw;
      throw InputError(error.message(), {.file = file.string()});
    }
  }

  const tree::BuilderCatalogue& catalogue_;
  const ViewPageSettings& settings_;
  ViewOptions options_;
  const Callbacks& callbacks_;
  std::vector<std::string> recognized_{};
};

}  // namespace

bool is_glb(const fs::path& file) {
  if (file.extension() == ".glb" || file.extension() == ".GLB") return true;
  if (kind_of(file) != PathKind::kFile) return false;
  std::string magic(4, '\0');
  std::ifstream stream(file, std::ios::binary);
  return stream.read(magic.data(), 4) && magic == "glTF";
}

fs::path view_page_path(const fs::path& source) {
  if (kind_of(source) == PathKind::kFolder) return source / "view.html";
  return fs::path(source).replace_extension(".html");
}

ViewPage write_view_page(const data::TableSource& source,
                         const tree::BuilderCatalogue& catalogue,
                         const fs::path& page_template,
                         const fs::path& page,
                         const ViewPageSettings& settings,
                         const Callbacks& callbacks) {
  const auto start = Clock::now();
  ViewSource read(catalogue, settings, callbacks);
  ViewPage result{.file = page, .view = read.view_of(source)};
  write_report_page(page_template, result.view.data, read.title(), page);
  result.recognized = std::move(read).recognized();
  std::error_code unknown;
  const std::uintmax_t size = fs::file_size(page, unknown);
  result.bytes = unknown ? 0 : size;
  result.seconds = seconds_since(start);
  give_notes(notes_on(result.view.left_out), callbacks.note);
  give_notes(result.view.notes, callbacks.note);
  return result;
}

nlohmann::ordered_json json_of(const ViewPage& page) {
  const View& view = page.view;
  return {{"schema", "silvafit-view-command/1"},
          {"silvafit", SILVAFIT_VERSION},
          {"page", page.file.string()},
          {"bytes", page.bytes},
          {"trees", view.trees},
          {"unmeasured", view.unmeasured},
          {"variants", view.variants},
          {"models", view.models},
          {"left_out", view.left_out.size()},
          {"recognized", page.recognized},
          {"notes", view.notes},
          {"seconds", page.seconds}};
}

}  // namespace silvafit::study
