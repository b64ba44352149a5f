// SPDX-License-Identifier: MIT
#include "interrupts.hpp"

#include <signal.h>

#include <system_error>
#include <thread>

#include "silvafit/base/atomic_file.hpp"

namespace silvafit::cli {
namespace {

sigset_t interrupting_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    // A signal that the caller ignores, as nohup does with SIGHUP, stays ignored.
    struct sigaction action {};
    sigaction(signal, nullptr, &action);
    if (action.sa_handler != SIG_IGN) sigaddset(&signals, signal);
  }
  return signals;
}

/// A separate thread may take locks and remove files, which a signal handler may not.
void wait_for_interrupt(const sigset_t& signals) {
  int signal = 0;
  if (sigwait(&signals, &signal) != 0) return;
  discard_unfinished_files();
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  raise(signal);
}

}  // namespace

void clean_up_on_interrupts() {
  const sigset_t signals = interrupting_signals();
  // All threads inherit the mask, so that only the one below sees the signals.
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  try {
    std::thread(wait_for_interrupt, signals).detach();
  } catch (const std::system_error&) {
    // If no thread can be started, signals end the process at once.
    pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  }
}

}  // namespace silvafit::cli
