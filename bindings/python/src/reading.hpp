// SPDX-License-Identifier: MIT
// Keyword arguments on how trees are read and structural units computed.
#pragma once

#include <pybind11/pybind11.h>

#include <vector>

#include "arguments.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/window.hpp"
#include "silvafit/study/tree_equations.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::python {

/// Take the settings of docs/settings.md: columns are a dictionary; a window may also be in memory
/// (windows), plots a Table, and equations need the catalogue (models_folder).
study::ReadingSettings take_reading(Arguments& arguments);
study::UnitSettings take_units(Arguments& arguments);
study::SamplingSettings take_sampling(Arguments& arguments);
study::EquationSettings take_equations(Arguments& arguments);

/// Windows from a list of (plot or None, polygons), a polygon being a list of rings (N x 2), the
/// outer one first.
std::vector<stand::NamedWindow> windows_of(const pybind11::object& windows);

/// (N) numbers of the rows that a table has of those that were read, from 0.
std::vector<std::size_t> rows_of(const data::Table& table);

}  // namespace silvafit::python
