// SPDX-License-Identifier: MIT
// Words of living, dead and cut trees in several languages, alone and in phrases.
#pragma once

#include <optional>
#include <string_view>

#include "silvafit/stand/tree_status.hpp"

namespace silvafit::stand {

/// What a text is that may have such words.
enum class StatusText {
  kStatus,  ///< a value of a status column, which may be a letter
  kAny,     ///< a value of another column: short codes and words with other meanings are no status
};

/// The status that a text names: by a word (`dead`, `D`) or by a phrase (`2 - dead`, `Dead, decay
/// 2`, `morta em pé`). Trees with dead parts (`dead top`) and `not dead` ones are alive.
/// \return none if there is no such word, or if the phrase is not clear (`dead?`, `alive/dead`)
std::optional<TreeStatus> status_in(std::string_view text, StatusText kind);

}  // namespace silvafit::stand
