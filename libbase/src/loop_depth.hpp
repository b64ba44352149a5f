// SPDX-License-Identifier: MIT
// What the loops of TBB and those of the standard library share.
#pragma once

#include <cstddef>

namespace silvafit {

/// Whether the calling thread is within a loop of parallel_for().
bool is_in_loop();

/// The number of processors that the process may use.
std::size_t core_count();

/// The scope of a task.
class InLoop {
 public:
  InLoop();
  ~InLoop();
  InLoop(const InLoop&) = delete;
  InLoop& operator=(const InLoop&) = delete;
};

}  // namespace silvafit
