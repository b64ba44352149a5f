// SPDX-License-Identifier: MIT
// Callbacks for the progress and the notes of an analysis.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace silvafit::study {

/// Called as a stage advances; may come from several threads.
using ProgressCallback =
    std::function<void(const std::string& stage, std::size_t done, std::size_t total)>;

/// Called with each note for people, such as how a file was read or what was assumed, as soon as it
/// is known; from the thread that runs the analysis.
using NoteCallback = std::function<void(const std::string& note)>;

/// Both are optional.
struct Callbacks {
  NoteCallback note{};
  ProgressCallback progress{};
};

/// Gives all notes of a list to a callback, if there is one.
template <class Notes>
void give_notes(const Notes& notes, const NoteCallback& callback) {
  if (!callback) return;
  for (const std::string& note : notes) callback(note);
}

}  // namespace silvafit::study
