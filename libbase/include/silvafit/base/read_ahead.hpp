// SPDX-License-Identifier: MIT
// Parts of a file that are read while the caller works on those before.
#pragma once

#include <functional>
#include <future>
#include <system_error>
#include <utility>

#include "silvafit/base/parallel.hpp"

namespace silvafit {

/// Reads one part ahead of the caller, on a thread of its own, so that reading and work share the
/// time. The parts and their order are those of a plain loop; memory has one part more.
/// \tparam Part  false after the last part: std::optional, a pointer
template <class Part>
class ReadAhead {
 public:
  /// \param read     gives the next part; what it refers to must outlive this object
  /// \param threads  as of parallel_for(); 1: parts are read when they are asked for
  ReadAhead(std::function<Part()> read, unsigned threads)
      : read_(std::move(read)), is_ahead_(worker_count(threads) > 1) {}

  /// \throws as `read` for this part
  Part next() {
    Part part = pending_.valid() ? pending_.get() : read_();
    if (is_ahead_ && part) start();
    return part;
  }

 private:
  void start() {
    try {
      pending_ = std::async(std::launch::async, read_);
    } catch (const std::system_error&) {
      // The system refuses a thread: parts are read when they are asked for.
      is_ahead_ = false;
    }
  }

  std::function<Part()> read_;
  bool is_ahead_;
  std::future<Part> pending_{};  ///< its destructor waits for the reading
};

}  // namespace silvafit
