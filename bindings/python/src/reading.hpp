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

/// Takes the arguments of ReadingSettings: columns (a dictionary), trust_units, missing, fill_down,
/// dead, case_sensitive.
study::ReadingSettings take_reading(Arguments& arguments);

/// Takes the arguments of UnitSettings: window (a file), windows (in memory), circle, edge, buffer,
/// per, neighbors, alpha, dominance, crowding, further, competition_radius, open_grown.
study::UnitSettings take_units(Arguments& arguments);

/// Takes the arguments of SamplingSettings: plots (a file or Table), plots_columns (a dictionary),
/// circles (texts), angle_count, smallest_dbh, expansion, subplots, subplot, slope_correction.
study::SamplingSettings take_sampling(Arguments& arguments);

/// Takes the arguments of EquationSettings: equations, equation_files, models (a folder).
study::EquationSettings take_equations(Arguments& arguments);

/// Windows from a list of (plot or None, polygons), a polygon being a list of rings (N x 2), the
/// outer one first.
std::vector<stand::NamedWindow> windows_of(const pybind11::object& windows);

/// (N) numbers of the rows that a table has of those that were read, from 0.
std::vector<std::size_t> rows_of(const data::Table& table);

}  // namespace silvafit::python
