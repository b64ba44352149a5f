// SPDX-License-Identifier: MIT
// The points of a line that are needed to keep its shape.
//
// Douglas, D. H., Peucker, T. K. (1973). Algorithms for the reduction of the number of points
// required to represent a digitized line or its caricature. Cartographica 10, 112-122.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace silvafit::tree {

/// Marks the points between `first` and `last` that are needed for an error of at most the
/// tolerance if the marked points are joined by straight lines.
/// \param error   error(a, b, p): the error of the straight line between points a and b at p, in
///                the unit of the tolerance
/// \param needed  as many as points; marks that are set stay set
template <typename Vertex, typename Error>
void mark_needed(std::span<const Vertex> line,
                 std::size_t first,
                 std::size_t last,
                 double tolerance,
                 const Error& error,
                 std::vector<bool>& needed) {
  double worst = tolerance;
  std::size_t at = first;
  for (std::size_t i = first + 1; i < last; ++i) {
    const double off = error(line[first], line[last], line[i]);
    if (off > worst) {
      worst = off;
      at = i;
    }
  }
  if (at == first) return;
  needed[at] = true;
  mark_needed(line, first, at, tolerance, error, needed);
  mark_needed(line, at, last, tolerance, error, needed);
}

/// Marks of the points of a line that are needed in this way: the ends, those that are fixed, and
/// as many between them as the tolerance needs.
template <typename Vertex, typename Error, typename Fixed>
std::vector<bool> needed_of(std::span<const Vertex> line,
                            double tolerance,
                            const Error& error,
                            const Fixed& is_fixed) {
  std::vector<bool> needed(line.size(), false);
  needed.front() = true;
  std::size_t from = 0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    if (i + 1 < line.size() && !is_fixed(line[i])) continue;
    needed[i] = true;
    mark_needed(line, from, i, tolerance, error, needed);
    from = i;
  }
  return needed;
}

/// The marked points, in their order.
template <typename Vertex>
void take_marked(std::span<const Vertex> line,
                 const std::vector<bool>& needed,
                 std::vector<Vertex>& taken) {
  taken.clear();
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (needed[i]) taken.push_back(line[i]);
  }
}

}  // namespace silvafit::tree
