// SPDX-License-Identifier: MIT
// The program as a desktop starts it: without a terminal that stays open.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace silvafit::cli {

/// Runs the program on the words of the command line. For a table that was dropped on it, this
/// is a study beside the file, whose report is then opened. Without words in a console window of
/// its own, it explains the first command. Such a window stays open until the user has read it.
/// \return the exit status
int run_as_started(const std::vector<std::string>& words,
                   const std::function<int(const std::vector<std::string>&)>& run);

}  // namespace silvafit::cli
