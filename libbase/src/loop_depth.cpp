// SPDX-License-Identifier: MIT
#include "loop_depth.hpp"

#include <algorithm>

#include "silvafit/base/parallel.hpp"

namespace silvafit {
namespace {

thread_local std::size_t loop_depth = 0;

}  // namespace

bool is_in_loop() { return loop_depth > 0; }
InLoop::InLoop() { ++loop_depth; }
InLoop::~InLoop() { --loop_depth; }

std::size_t worker_count(unsigned threads) {
  const std::size_t cores = core_count();
  // TBB ends the process where the system refuses it a thread; so many were never refused.
  constexpr std::size_t kMostBeyondCores = 64;
  return threads == 0 ? cores : std::min<std::size_t>(threads, std::max(cores, kMostBeyondCores));
}

void parallel_for(std::size_t count,
                  unsigned threads,
                  const std::function<void(std::size_t)>& task) {
  parallel_for(count, threads, [&task](std::size_t i, std::size_t /*worker*/) { task(i); });
}

}  // namespace silvafit
