// SPDX-License-Identifier: MIT
// Whether a thread is within a loop of parallel_for().
#pragma once

namespace silvafit {

bool is_in_loop();

/// The scope of a task.
class InLoop {
 public:
  InLoop();
  ~InLoop();
  InLoop(const InLoop&) = delete;
  InLoop& operator=(const InLoop&) = delete;
};

}  // namespace silvafit
