// SPDX-License-Identifier: MIT
// SQLite stores any value in any column; the types that the columns of a layer need to hold theirs.
#pragma once

#include <ogrsf_frmts.h>

#include <string>

struct sqlite3;

namespace silvafit::source {

/// Changes the types of a layer's fields so that no value is cut off: whole numbers of 64 bits,
/// numbers with decimals in columns declared or guessed as whole or boolean, and texts in columns
/// of numbers and dates.
/// \param rows  what the layer's rows are selected from: a quoted name, or a query in parentheses
void take_stored_types(sqlite3& database, const std::string& rows, OGRLayer& layer);

/// A name as SQL has it.
std::string quoted_name(const std::string& name);

}  // namespace silvafit::source
