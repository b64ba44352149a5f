// SPDX-License-Identifier: MIT
#include "silvafit/base/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <stdexcept>
#include <vector>

TEST_CASE("every task runs once, for any number of threads") {
  for (const unsigned threads : {0U, 1U, 2U, 5U}) {
    std::vector<int> runs(1000, 0);
    silvafit::parallel_for(runs.size(), threads, [&](std::size_t i) { ++runs[i]; });
    CHECK(runs == std::vector<int>(1000, 1));
  }
}

TEST_CASE("no two tasks at work have the same worker") {
  for (const unsigned threads : {0U, 1U, 2U, 5U}) {
    std::vector<std::atomic<int>> at_work(silvafit::worker_count(threads));
    std::atomic<int> shared = 0;
    silvafit::parallel_for(1000, threads, [&](std::size_t, std::size_t worker) {
      if (++at_work.at(worker) > 1) ++shared;
      --at_work.at(worker);
    });
    CHECK(shared == 0);
  }
}

TEST_CASE("a task that waits for a nested loop does not share its worker") {
  for (const unsigned threads : {2U, 5U}) {
    std::vector<std::atomic<int>> at_work(silvafit::worker_count(threads));
    std::atomic<int> shared = 0;
    std::atomic<int> runs = 0;
    silvafit::parallel_for(50, threads, [&](std::size_t, std::size_t worker) {
      if (++at_work.at(worker) > 1) ++shared;
      silvafit::parallel_for(50, threads, [&](std::size_t) { ++runs; });
      --at_work.at(worker);
    });
    CHECK(shared == 0);
    CHECK(runs == 2500);
  }
}

TEST_CASE("an exception of a task reaches the caller") {
  CHECK_THROWS_WITH(silvafit::parallel_for(10,
                                           2,
                                           [](std::size_t i) {
                                             if (i == 7) throw std::runtime_error("seven");
                                           }),
                    "seven");
}

TEST_CASE("a number of threads that no machine has is taken for a smaller one") {
  CHECK(silvafit::worker_count(5) == 5);
  CHECK(silvafit::worker_count(64) == 64);
  CHECK(silvafit::worker_count(65536) == std::max<std::size_t>(64, silvafit::worker_count(0)));
}
