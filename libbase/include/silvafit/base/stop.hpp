// SPDX-License-Identifier: MIT
// Cancellation of long work by the caller.
#pragma once

#include <exception>
#include <stop_token>

namespace silvafit {

/// The caller has cancelled the work. Not derived from Error, because handlers of failures of
/// single fits must not catch it.
class Stopped : public std::exception {
 public:
  const char* what() const noexcept override { return "stopped by the caller"; }
};

/// \throws Stopped if the caller has cancelled the work
inline void check_stop(const std::stop_token& stop) {
  if (stop.stop_requested()) throw Stopped();
}

}  // namespace silvafit
