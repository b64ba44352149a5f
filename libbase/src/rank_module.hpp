// SPDX-License-Identifier: MIT
// The interface of the module silvafit_mpi.so. The library loads it only in a job of several
// processes, because MPI's libraries would slow every other start.
#pragma once

#include "silvafit/base/ranks.hpp"

namespace silvafit {

/// The name of the only function that the module exports: `Ranks* name()`. It joins the job; the
/// ranks leave it when the process exits.
inline constexpr const char* kRankModuleFunction = "silvafit_mpi_ranks";

}  // namespace silvafit
