// SPDX-License-Identifier: MIT
#include "silvafit/base/parallel.hpp"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <map>
#include <optional>

#include "loop_depth.hpp"
#include "silvafit/base/system.hpp"

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#endif

namespace silvafit {
namespace {

/// A loop's order: what the caller did, then the tasks, then what the caller does next.
///
/// TBB keeps it; the thread sanitizer does not see into the library and must be told. Elsewhere
/// this does nothing.
class LoopOrder {
 public:
  class Task {
   public:
    explicit Task(LoopOrder& loop) : loop_(loop) { acquire(&loop_.begin_); }
    ~Task() { release(&loop_.end_); }
    Task(const Task&) = delete;
    Task& operator=(const Task&) = delete;

   private:
    LoopOrder& loop_;
    InLoop in_loop_{};
  };

  LoopOrder() { release(&begin_); }
  ~LoopOrder() { acquire(&end_); }
  LoopOrder(const LoopOrder&) = delete;
  LoopOrder& operator=(const LoopOrder&) = delete;

 private:
#if defined(__SANITIZE_THREAD__)
  static void release(char* place) { __tsan_release(place); }
  static void acquire(char* place) { __tsan_acquire(place); }
#else
  static void release(const char* /*place*/) {}
  static void acquire(const char* /*place*/) {}
#endif
  char begin_ = 0;
  char end_ = 0;
};

/// The arena of the calling thread with this many workers.
///
/// Arenas live as long as their thread: the workers of a new arena must be woken, which takes
/// longer than a short loop.
tbb::task_arena& arena_of(std::size_t workers) {
  thread_local std::map<std::size_t, tbb::task_arena> arenas;
  return arenas.try_emplace(workers, static_cast<int>(workers)).first->second;
}

}  // namespace

std::size_t core_count() { return static_cast<std::size_t>(tbb::info::default_concurrency()); }

void parallel_for(std::size_t count,
                  unsigned threads,
                  const std::function<void(std::size_t, std::size_t)>& task) {
  const std::size_t workers = worker_count(threads);
  if (workers == 1 || count < 2) {
    const InLoop in_loop;
    for (std::size_t i = 0; i < count; ++i) task(i, 0);
    return;
  }
  // Lets TBB have more threads than there are cores, where the caller asks for them.
  std::optional<tbb::global_control> limit;
  if (workers > core_count()) limit.emplace(tbb::global_control::max_allowed_parallelism, workers);
  LoopOrder order;
  const auto loop = [&] {
    // One task at a time: fits differ in cost by orders of magnitude.
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          const LoopOrder::Task ordered(order);
          system::prepare_thread();
          const auto worker =
              static_cast<std::size_t>(tbb::this_task_arena::current_thread_index());
          for (std::size_t i = range.begin(); i != range.end(); ++i) task(i, worker);
        },
        tbb::simple_partitioner());
  };
  // Isolated, so that a worker that waits for a loop within its task begins no other task of the
  // outer loop, whose buffers of the same worker are in use.
  arena_of(workers).execute([&] { tbb::this_task_arena::isolate(loop); });
}

}  // namespace silvafit
