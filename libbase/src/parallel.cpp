// SPDX-License-Identifier: MIT
#include "silvafit/base/parallel.hpp"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace silvafit {

void parallel_for(std::size_t count,
                  unsigned threads,
                  const std::function<void(std::size_t)>& task) {
  if (threads == 1 || count < 2) {
    for (std::size_t i = 0; i < count; ++i) task(i);
    return;
  }
  // Lets TBB have more threads than there are cores, where the caller asks for them.
  const tbb::global_control limit(
      tbb::global_control::max_allowed_parallelism,
      threads == 0 ? static_cast<std::size_t>(tbb::info::default_concurrency()) : threads);
  tbb::task_arena arena(threads == 0 ? tbb::task_arena::automatic : static_cast<int>(threads));
  arena.execute([&] {
    // One task at a time: fits differ in cost by orders of magnitude.
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, 1),
        [&task](const tbb::blocked_range<std::size_t>& range) {
          for (std::size_t i = range.begin(); i != range.end(); ++i) task(i);
        },
        tbb::simple_partitioner());
  });
}

}  // namespace silvafit
