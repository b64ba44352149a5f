// SPDX-License-Identifier: MIT
// What happens when the program is interrupted.
#pragma once

namespace silvafit::cli {

/// From now on SIGINT, SIGTERM and SIGHUP end the process as they always do, but not before files
/// that are not whole yet are removed. To be called once, before any other thread is started.
void clean_up_on_interrupts();

}  // namespace silvafit::cli
