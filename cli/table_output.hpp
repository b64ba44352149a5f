// SPDX-License-Identifier: MIT
// Tables of trees as layers of GIS files and sheets of workbooks.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "command.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/source/write_layers.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/plot_windows.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::cli {

inline constexpr char kTableOutputHelp[] =
    "File to write: CSV, or by its ending a layer of points (.gpkg, .fgb) or a workbook (.xlsx, "
    ".ods) (default: CSV on standard output)";

/// Whether a file has layers or sheets, by its ending.
bool is_layer_output(const std::string& out);

/// Checks, before anything is computed, that such a file can be written.
/// \throws as source::require_layer_output
void require_table_output(const std::string& out);

/// The table of a CSV text. Positions are read as from an inventory: x and y by their usual names
/// or through --columns.
data::Table table_of_csv(std::string text,
                         const std::string& file,
                         const study::ReadingSettings& reading);

/// Writes one table: as CSV, or as a sheet or layer without geometry by the ending of the file.
/// \throws as source::write_layers
void write_table(const std::string& out, const std::string& name, data::Table table);

/// A layer of the windows of plots, with numbers of trees and areas; none without windows.
std::optional<source::Layer> plot_layer(const stand::Inventory& inventory,
                                        const stand::PlotWindows& windows);

/// Writes trees, as points if x and y are among the columns, and the plots below them.
/// \throws as source::write_layers
void write_trees(const std::string& out,
                 data::Table trees,
                 std::optional<source::Layer> plots,
                 const std::optional<source::CoordinateSystem>& coordinates,
                 const CommonOptions& common);

/// Writes the CSV files of a study's folder and of its folder of tables as the sheets of a
/// workbook.
/// \throws as source::write_layers
void write_sheets_of_folder(const std::string& out, const std::filesystem::path& folder);

}  // namespace silvafit::cli
