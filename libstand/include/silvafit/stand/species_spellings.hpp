// SPDX-License-Identifier: MIT
// Several spellings of one species: sm, SM.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::stand {

/// Finds spellings that differ only in case and blanks, in an inventory or in its parts one after
/// another.
class SpeciesSpellings {
 public:
  /// Species whose spelling is given, as by a library of models. If two of them differ only in case
  /// and blanks, no spelling is changed.
  void know(const std::vector<std::string>& species);
  /// Gives all trees of a species its given or most frequent spelling; later parts get that of the
  /// first.
  void unify(data::TextColumn& species);
  /// A note on the changed spellings; empty if none was changed.
  std::string note() const;

 private:
  std::map<std::string, std::string> spelling_of_{};  ///< by the folded name
  bool are_distinct_ = false;  ///< two given species differ only in case or blanks
  struct Change {
    std::string to{};
    std::size_t trees = 0;
  };
  std::map<std::string, Change> changes_{};  ///< by the spelling in the file
};

}  // namespace silvafit::stand
