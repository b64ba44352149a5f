// SPDX-License-Identifier: MIT
// Work on a separate thread, so that the user can interrupt it.
#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "silvafit/study/callbacks.hpp"

namespace silvafit::r {

/// What work on another thread reports to R's thread. R is called by R's thread only.
class Reports {
 public:
  explicit Reports(std::stop_token stop) : stop_(std::move(stop)) {}

  std::stop_token stop() const { return stop_; }
  /// Keeps notes; ends the work by the exception Stopped at its next progress once the user has
  /// interrupted it.
  study::Callbacks callbacks();
  /// A line for the console.
  void print(const std::string& line);

  /// Shows new lines and the progress in the console; from R's thread.
  void show(bool shows_progress);
  void end_progress();
  std::vector<std::string> notes() const;

 private:
  struct Stage {
    std::string name{};
    std::size_t done = 0;
    std::size_t total = 0;
  };
  std::stop_token stop_;
  mutable std::mutex mutex_;
  std::vector<std::string> notes_;
  std::vector<std::string> lines_;
  Stage stage_;
  Stage shown_;
};

/// Runs work on another thread until it ends or the user interrupts R.
/// \return the notes of the work
/// \throws cpp11::unwind_exception after an interrupt or a time limit of R; else what the work
/// throws
std::vector<std::string> run_in_background(const std::function<void(Reports&)>& work,
                                           bool shows_progress);

/// The result of work on another thread, and its notes.
template <typename Work>
auto in_background(Work work, bool shows_progress = false) {
  std::optional<std::invoke_result_t<Work&, Reports&>> result;
  auto notes =
      run_in_background([&](Reports& reports) { result.emplace(work(reports)); }, shows_progress);
  return std::pair(std::move(*result), std::move(notes));
}

}  // namespace silvafit::r
