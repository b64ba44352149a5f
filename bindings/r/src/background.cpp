// SPDX-License-Identifier: MIT
#include "background.hpp"

#include <R_ext/Print.h>

#include <chrono>
#include <cpp11/R.hpp>
#include <cpp11/protect.hpp>
#include <csignal>
#include <future>

#include "silvafit/base/stop.hpp"

namespace silvafit::r {
namespace {

/// No signal reaches the threads that start while this lives: R handles them in its own thread.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~BlockedSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

 private:
  sigset_t before_{};
};

}  // namespace

study::Callbacks Reports::callbacks() {
  return {.note =
              [this](const std::string& note) {
                const std::scoped_lock lock(mutex_);
                notes_.push_back(note);
              },
          .progress =
              [this](const std::string& stage, std::size_t done, std::size_t total) {
                check_stop(stop_);
                const std::scoped_lock lock(mutex_);
                // Threads report in any order.
                if (stage == stage_.name && done < stage_.done) return;
                stage_ = {.name = stage, .done = done, .total = total};
              }};
}

void Reports::print(const std::string& line) {
  const std::scoped_lock lock(mutex_);
  lines_.push_back(line);
}

void Reports::show(bool shows_progress) {
  std::vector<std::string> lines;
  Stage stage;
  {
    const std::scoped_lock lock(mutex_);
    lines.swap(lines_);
    stage = stage_;
  }
  for (const std::string& line : lines) REprintf("%s\n", line.c_str());
  if (!shows_progress || stage.name.empty()) return;
  if (stage.name == shown_.name && stage.done == shown_.done) return;
  if (!shown_.name.empty() && stage.name != shown_.name) REprintf("\n");
  REprintf("\r%s %zu/%zu", stage.name.c_str(), stage.done, stage.total);
  shown_ = stage;
}

void Reports::end_progress() {
  if (!shown_.name.empty()) REprintf("\n");
}

std::vector<std::string> Reports::notes() const {
  const std::scoped_lock lock(mutex_);
  return notes_;
}

std::vector<std::string> run_in_background(const std::function<void(Reports&)>& work,
                                           bool shows_progress) {
  using namespace std::chrono_literals;
  std::stop_source stop;
  Reports reports(stop.get_token());
  std::future<void> result = [&] {
    const BlockedSignals blocked;
    return std::async(std::launch::async, [&] { work(reports); });
  }();
  try {
    while (result.wait_for(50ms) != std::future_status::ready) {
      reports.show(shows_progress);
      cpp11::check_user_interrupt();
    }
  } catch (const cpp11::unwind_exception&) {
    // An interrupt, or the error of a time limit. R handles it after the work has ended.
    stop.request_stop();
    result.wait();
    throw;
  }
  reports.show(shows_progress);
  reports.end_progress();
  result.get();
  return reports.notes();
}

}  // namespace silvafit::r
