// SPDX-License-Identifier: MIT
// 3D trees and their page.
#include <nlohmann/json.hpp>

#include "background.hpp"
#include "conversion.hpp"
#include "entry_points.hpp"
#include "settings.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/grow_setting_list.hpp"
#include "silvafit/study/view_page.hpp"
#include "silvafit/tree/builder.hpp"

namespace silvafit::r {

SEXP grow_trees(SEXP source, SEXP settings) {
  const Arguments arguments(settings);
  const data::TableSource trees = source_of(source);
  const auto catalogue = tree::BuilderCatalogue::load(data_folder(arguments) / "models");
  auto options = settings_of<study::GrowSettings>(arguments);
  options.reading = reading_settings(arguments);
  arguments.read("threads", options.threads);
  arguments.read("seed", options.seed);
  options.keeps_trees = true;
  const auto [result, notes] = in_background(
      [&](Reports& reports) { return study::grow(trees, catalogue, options, reports.callbacks()); },
      shows_progress(arguments));
  NamedList list;
  list.add("json", value_of(study::json_of(result)));
  list.add("notes", value_of(notes));
  list.add("left_out", value_of(study::notes_on(result.left_out)));
  return list.list();
}

SEXP view_page(SEXP source, SEXP settings) {
  const Arguments arguments(settings);
  const data::TableSource trees = source_of(source);
  const std::filesystem::path folder = data_folder(arguments);
  const auto catalogue = tree::BuilderCatalogue::load(folder / "models");
  study::ViewPageSettings options{.reading = reading_settings(arguments),
                                  .view = settings_of<study::ViewOptions>(arguments)};
  arguments.read("threads", options.view.threads);
  arguments.read("seed", options.view.seed);
  const std::filesystem::path page = text_of(arguments["file"]);
  const auto [result, notes] = in_background(
      [&](Reports& reports) {
        return study::write_view_page(
            trees, catalogue, folder / "viewer" / "scene.html", page, options, reports.callbacks());
      },
      shows_progress(arguments));
  NamedList list;
  list.add("json", value_of(study::json_of(result)));
  list.add("notes", value_of(notes));
  return list.list();
}

}  // namespace silvafit::r
