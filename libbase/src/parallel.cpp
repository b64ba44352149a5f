// SPDX-License-Identifier: MIT
#include "silvafit/base/parallel.hpp"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

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

}  // namespace

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
  LoopOrder order;
  arena.execute([&] {
    // One task at a time: fits differ in cost by orders of magnitude.
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          const LoopOrder::Task ordered(order);
          for (std::size_t i = range.begin(); i != range.end(); ++i) task(i);
        },
        tbb::simple_partitioner());
  });
}

}  // namespace silvafit
