// SPDX-License-Identifier: MIT
// Reading of the next part of a file while the caller uses the current one.
#pragma once

#include <functional>
#include <future>
#include <system_error>
#include <utility>

#include "silvafit/base/parallel.hpp"

namespace silvafit {

/// Reads one part ahead of the caller on a separate thread. The parts and their order are those of
/// a simple loop; one more part is in memory. \tparam Part  false after the last part:
/// std::optional, a pointer
template <class Part>
class ReadAhead {
 public:
  /// \param read     returns the next part; objects that it refers to must outlive this one
  /// \param threads  as of parallel_for(); 1: no reading ahead
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
      // Without a thread there is no reading ahead.
      is_ahead_ = false;
    }
  }

  std::function<Part()> read_;
  bool is_ahead_;
  std::future<Part> pending_{};  ///< its destructor waits for the reading
};

}  // namespace silvafit
