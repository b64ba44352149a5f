// SPDX-License-Identifier: MIT
// The end of long work at the wish of the caller.
#pragma once

#include <exception>
#include <stop_token>

namespace silvafit {

/// The caller has asked to stop. It is no Error: where failures of single fits are listed, all of
/// the work ends nevertheless.
class Stopped : public std::exception {
 public:
  const char* what() const noexcept override { return "stopped by the caller"; }
};

/// \throws Stopped if the caller has asked to stop
inline void check_stop(const std::stop_token& stop) {
  if (stop.stop_requested()) throw Stopped();
}

}  // namespace silvafit
