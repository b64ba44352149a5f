// SPDX-License-Identifier: MIT
// Databases and queries that could read more than their own file.
#pragma once

#include <string>
#include <vector>

#include "silvafit/source/open_table.hpp"

namespace silvafit::source {

/// Whether a file is a database of SQLite, by its first bytes.
bool is_sqlite_file(const std::string& path);

/// Whether the pages of a database of SQLite fit together. Without this check SQLite reads the rows
/// that a damaged page leads to: too few, or those of another page.
bool is_sound_database(const std::string& path);

/// Refuses a database of SQLite whose virtual tables, views or generated columns, or the query of a
/// choice, could read other files or a network. GDAL and SpatiaLite have virtual tables and
/// functions that do; a table of GDAL connects as soon as the file is opened.
///
/// The check does not run anything: SQLite alone, without GDAL, prepares a query of each table and
/// view. Accepted are SQLite's own functions and tables, and functions of geometries (ST_...).
/// \param place  the file, for messages
/// \return whether the database can be read
/// \throws InputError that names the table or view; UsageError for the query
bool require_own_data(const std::string& path, const TableChoice& choice, const std::string& place);

/// A layer, as a query of GDAL's SQLite dialect sees it.
struct QueriedLayer {
  std::string name{};
  std::vector<std::string> columns{};
};

/// The same for a query of layers of another format: in it, the name of another file would be that
/// of a table.
/// \return the message of SQLite if the query is wrong; else empty
/// \throws UsageError if it uses a function that is not accepted
std::string require_own_layers(const std::string& sql, const std::vector<QueriedLayer>& layers);

}  // namespace silvafit::source
