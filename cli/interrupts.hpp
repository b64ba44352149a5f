// SPDX-License-Identifier: MIT
// Removes incomplete files when the program is interrupted.
#pragma once

namespace silvafit::cli {

/// After this call SIGINT, SIGTERM and SIGHUP first remove incomplete files and then end the
/// process as usual. Call it once, before any other thread is started.
void clean_up_on_interrupts();

}  // namespace silvafit::cli
