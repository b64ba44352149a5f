// SPDX-License-Identifier: MIT
// The error of a failed read or write.
#pragma once

#include "silvafit/base/error.hpp"

namespace silvafit {

/// The system could not write a result, or failed while it read: a full disk, a folder without
/// permission, a failing device.
class IoError : public Error {
  using Error::Error;
};

}  // namespace silvafit
