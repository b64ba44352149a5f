// SPDX-License-Identifier: MIT
// The 3D page of a stand, from a table, a scene or a study's folder to the file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/study/callbacks.hpp"
#include "silvafit/study/unit_settings.hpp"
#include "silvafit/study/view_data.hpp"

namespace silvafit::study {

struct ViewPageSettings {
  ReadingSettings reading{};
  ViewOptions view{};  ///< an empty title is the name of the source; version and columns are set
  std::optional<data::TableSource> trees{};  ///< measurements of the trees of a GLB scene
};

struct ViewPage {
  std::filesystem::path file{};
  std::size_t bytes = 0;
  View view{};
  std::vector<std::string> recognized{};  ///< how the table was read
  double seconds = 0.0;
};

/// Whether a file is a GLB scene, by its ending or its first bytes.
bool is_glb(const std::filesystem::path& file);

/// The default page of a source: view.html in a folder, else beside the file.
std::filesystem::path view_page_path(const std::filesystem::path& source);

/// Writes the page of a stand.
/// \param source         table of trees, folder of a study, or GLB scene
/// \param page_template  the bundled page, `share/silvafit/viewer/scene.html`
/// \param page           file to write
/// \throws InputError if the source is none of these; else as read_tree_table, view_of_trees,
///   view_of_scene and write_report_page
ViewPage write_view_page(const data::TableSource& source,
                         const tree::BuilderCatalogue& catalogue,
                         const std::filesystem::path& page_template,
                         const std::filesystem::path& page,
                         const ViewPageSettings& settings = {},
                         const Callbacks& callbacks = {});

/// A summary as JSON, schema silvafit-view-command/1.
nlohmann::ordered_json json_of(const ViewPage& page);

}  // namespace silvafit::study
