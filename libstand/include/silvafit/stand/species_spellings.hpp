// SPDX-License-Identifier: MIT
// Species that are spelled in several ways: sm, SM.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::stand {

/// Finds spellings that differ in capitals and blanks only, in an inventory or in its parts one
/// after another.
class SpeciesSpellings {
 public:
  /// Gives all trees of a species its commonest spelling; of a later part that of the first one.
  void unify(data::TextColumn& species);
  /// Says which spellings were changed; empty if none was.
  std::string note() const;

 private:
  std::map<std::string, std::string> spelling_of_{};  ///< by the folded name
  struct Change {
    std::string to{};
    std::size_t trees = 0;
  };
  std::map<std::string, Change> changes_{};  ///< by the spelling in the file
};

}  // namespace silvafit::stand
