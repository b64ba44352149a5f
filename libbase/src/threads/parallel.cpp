// SPDX-License-Identifier: MIT
// Loops on threads of the standard library, for the source package of R, which has no TBB.
//
// Each loop starts its threads, and a loop within a task of a parallel loop has one thread.
#include "silvafit/base/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "loop_depth.hpp"
#include "silvafit/base/system.hpp"

namespace silvafit {
namespace {

thread_local bool is_worker = false;

/// The tasks of a loop, which its threads take one by one.
class Tasks {
 public:
  Tasks(std::size_t count, const std::function<void(std::size_t, std::size_t)>& task)
      : count_(count), task_(task) {}

  void work(std::size_t worker) {
    const InLoop in_loop;
    is_worker = true;
    system::prepare_thread();
    try {
      for (std::size_t i = next_++; i < count_; i = next_++) task_(i, worker);
    } catch (...) {
      next_ = count_;
      const std::scoped_lock lock(mutex_);
      if (!error_) error_ = std::current_exception();
    }
    is_worker = false;
  }

  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  std::size_t count_;
  const std::function<void(std::size_t, std::size_t)>& task_;
  std::atomic<std::size_t> next_ = 0;
  std::mutex mutex_;
  std::exception_ptr error_;
};

}  // namespace

std::size_t core_count() { return std::max(1U, std::thread::hardware_concurrency()); }

void parallel_for(std::size_t count,
                  unsigned threads,
                  const std::function<void(std::size_t, std::size_t)>& task) {
  const std::size_t workers = std::min(worker_count(threads), count);
  if (workers < 2 || is_worker) {
    const InLoop in_loop;
    for (std::size_t i = 0; i < count; ++i) task(i, 0);
    return;
  }
  Tasks tasks(count, task);
  {
    std::vector<std::jthread> others;
    for (std::size_t worker = 1; worker < workers; ++worker) {
      others.emplace_back([&tasks, worker] { tasks.work(worker); });
    }
    tasks.work(0);
  }
  tasks.rethrow();
}

}  // namespace silvafit
