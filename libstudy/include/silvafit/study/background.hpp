// SPDX-License-Identifier: MIT
// Analyses on a thread of their own, so that the front end can show their progress and stop them.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "silvafit/study/analyses.hpp"

namespace silvafit::study {

/// What an analysis has reported since the last time.
struct Reports {
  std::vector<std::string> notes{};
  std::vector<std::string> lines{};  ///< of a trace
  std::string stage{};               ///< empty: no progress
  std::size_t done = 0;
  std::size_t total = 0;
};

/// Runs an analysis on another thread. The calling thread calls poll when that has started, every
/// 50 ms, and when it has ended, so that only the calling thread enters the language of the front
/// end.
/// \param poll  an exception that it throws stops the analysis, and is thrown on after that has
///              ended
/// \param wait  calls its argument, which waits: the place to release a lock
/// \throws what poll or the analysis throws
AnalysisResult run_in_background(
    const AnalysisWork& work,
    const std::function<void(const Reports&)>& poll,
    const std::function<void(const std::function<void()>&)>& wait = [](const auto& waits) {
      waits();
    });

}  // namespace silvafit::study
