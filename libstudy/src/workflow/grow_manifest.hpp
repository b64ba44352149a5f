// SPDX-License-Identifier: MIT
// The table of the trees that `silvafit grow` wrote.
#pragma once

#include <cstddef>
#include <string>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/data/ordered_rows.hpp"
#include "silvafit/study/grow.hpp"

namespace silvafit::study {

/// Writes a CSV file with a row for each tree at each level of detail, in the order of the trees in
/// their file: plot, tree, species, preset, level, file, triangles, bytes.
class GrowManifest {
 public:
  explicit GrowManifest(const std::string& file);

  /// \param line  of the tree
  void add(std::size_t line, const GrownTree& grown);
  void finish();

 private:
  AtomicFile file_;
  data::OrderedRows rows_;
};

}  // namespace silvafit::study
