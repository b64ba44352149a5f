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

/// The status of trees for which a column is true, by its header, also with a year: `is_alive`,
/// `morta`, `abgestorben`, `dead_2011`, `harvested`.
struct StatusOfHeader {
  TreeStatus status = TreeStatus::kAlive;
  bool is_clear = false;  ///< living or dead, by a word without other meanings and without a year
};
std::optional<StatusOfHeader> status_of_header(std::string_view header);

/// Whether a value says that its column is true or false: `1`, `no`, `ja`, `x`; none of both if it
/// says something else.
std::optional<bool> answer_in(std::string_view value);

}  // namespace silvafit::stand
