// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <system_error>
#include <thread>

#include "silvafit/base/system.hpp"

namespace silvafit::system {
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
void wait_for_interrupt(const sigset_t& signals, void (*clean_up)()) {
  int signal = 0;
  if (sigwait(&signals, &signal) != 0) return;
  clean_up();
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  raise(signal);
}

}  // namespace

std::vector<std::string> command_line(int argc, char** argv) { return {argv, argv + argc}; }

void prepare_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) != -1) continue;
    // The descriptor is the lowest free number. The direction is reversed, so that use fails.
    ::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }
}

bool is_terminal(std::FILE* stream) { return ::isatty(::fileno(stream)) == 1; }

int silence(std::FILE* stream) {
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  const int kept = ::fcntl(::fileno(stream), F_DUPFD_CLOEXEC, 3);
  ::dup2(nowhere, ::fileno(stream));
  ::close(nowhere);
  return kept;
}

void restore(std::FILE* stream, int descriptor) { ::dup2(descriptor, ::fileno(stream)); }

void prepare_thread() {}

bool takes_dropped_files() { return false; }

bool has_own_console() { return false; }

void clean_up_on_interrupts(void (*clean_up)()) {
  const sigset_t signals = interrupting_signals();
  // All threads inherit the mask, so that only the one below sees the signals.
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  try {
    std::thread(wait_for_interrupt, signals, clean_up).detach();
  } catch (const std::system_error&) {
    // If no thread can be started, signals end the process at once.
    pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  }
}

}  // namespace silvafit::system
