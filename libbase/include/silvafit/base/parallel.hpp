// SPDX-License-Identifier: MIT
// Loops over independent tasks on several threads.
#pragma once

#include <cstddef>
#include <functional>

namespace silvafit {

/// Runs task(0) .. task(count - 1), in any order, on at most `threads` threads.
///
/// Tasks must not write to the same memory, so that the result does not depend on the number of
/// threads.
/// \param threads  0: the number of cores; never more than that or 64
/// \throws the first exception of a task, after the running tasks have ended
void parallel_for(std::size_t count,
                  unsigned threads,
                  const std::function<void(std::size_t)>& task);

/// The same for tasks that need working memory: task(i, worker). Tasks that run at the same time
/// have different workers, numbers from 0 to worker_count(threads) - 1.
void parallel_for(std::size_t count,
                  unsigned threads,
                  const std::function<void(std::size_t, std::size_t)>& task);

/// Maximum number of tasks that run at the same time.
std::size_t worker_count(unsigned threads);

}  // namespace silvafit
