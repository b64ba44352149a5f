// SPDX-License-Identifier: MIT
// What the module silvafit_mpi.so gives to the library, which loads it in a job of several
// processes only: MPI's libraries would slow every other start.
#pragma once

#include "silvafit/base/ranks.hpp"

namespace silvafit {

/// The name of the only function that the module exports: `Ranks* name()`. It joins the job; the
/// ranks leave it when the process exits.
inline constexpr const char* kRankModuleFunction = "silvafit_mpi_ranks";

}  // namespace silvafit
