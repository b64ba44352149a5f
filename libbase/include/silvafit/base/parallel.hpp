// SPDX-License-Identifier: MIT
// Loops over independent tasks on several threads.
#pragma once

#include <cstddef>
#include <functional>

namespace silvafit {

/// Runs task(0) .. task(count - 1), in any order, on at most `threads` threads.
///
/// Tasks write to places of their own, so that the result does not depend on the number of threads.
/// \param threads  0 means as many as the machine has cores, which or 64 is the most
/// \throws the first exception of a task, after the running ones have ended
void parallel_for(std::size_t count,
                  unsigned threads,
                  const std::function<void(std::size_t)>& task);

/// The same for tasks that need memory to work in: task(i, worker). No two tasks that run at a time
/// have the same worker, a number from 0 to worker_count(threads) - 1.
void parallel_for(std::size_t count,
                  unsigned threads,
                  const std::function<void(std::size_t, std::size_t)>& task);

/// How many tasks at most run at a time.
std::size_t worker_count(unsigned threads);

}  // namespace silvafit
