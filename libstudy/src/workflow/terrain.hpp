// SPDX-License-Identifier: MIT
// Trees that stand on a terrain model.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "silvafit/data/raster.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::study {

/// Sets the column z to the elevations of a terrain at the trees' positions; missing outside of it.
/// \param columns  sources of standard columns; that of z is removed
/// \param is_whole     the table is no part of another
/// \param off_terrain  trees of earlier parts that are not on the terrain; those of this table are
///   added
/// \param notes        gets where elevations are from, and the number of these trees
/// \throws InputError if no tree of a whole table is on the terrain, with the ranges of both
void set_elevations(const data::Raster& terrain,
                    data::Table& table,
                    std::map<std::string, std::string>& columns,
                    bool is_whole,
                    std::size_t& off_terrain,
                    std::vector<std::string>& notes);

}  // namespace silvafit::study
