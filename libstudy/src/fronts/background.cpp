// SPDX-License-Identifier: MIT
#include "silvafit/study/background.hpp"

#include <chrono>
#include <exception>
#include <future>
#include <mutex>
#include <utility>

#include "silvafit/base/stop.hpp"

namespace silvafit::study {
namespace {

/// Reports of any thread until they are taken.
class ReportBox {
 public:
  explicit ReportBox(std::stop_token stop) : stop_(std::move(stop)) {}

  AnalysisCallbacks callbacks() {
    AnalysisCallbacks result;
    result.stop = stop_;
    result.note = [this](const std::string& note) {
      const std::scoped_lock lock(mutex_);
      reports_.notes.push_back(note);
    };
    result.line = [this](const std::string& line) {
      const std::scoped_lock lock(mutex_);
      reports_.lines.push_back(line);
    };
    result.progress = [this](const std::string& stage, std::size_t done, std::size_t total) {
      check_stop(stop_);
      const std::scoped_lock lock(mutex_);
      // Threads report in any order.
      if (stage == stage_ && done < done_) return;
      reports_.stage = stage_ = stage;
      reports_.done = done_ = done;
      reports_.total = total;
    };
    return result;
  }
  Reports take() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(reports_, {});
  }

 private:
  std::stop_token stop_;
  std::mutex mutex_{};
  Reports reports_{};
  std::string stage_{};  ///< the latest progress
  std::size_t done_ = 0;
};

}  // namespace

AnalysisResult run_in_background(const AnalysisWork& work,
                                 const std::function<void(const Reports&)>& poll,
                                 const std::function<void(const std::function<void()>&)>& wait) {
  constexpr auto kBetweenPolls = std::chrono::milliseconds(50);
  std::stop_source stop;
  ReportBox box(stop.get_token());
  std::future<AnalysisResult> result =
      std::async(std::launch::async, [&] { return work(box.callbacks()); });
  bool has_ended = false;
  try {
    while (!has_ended) {
      poll(box.take());
      wait([&] { has_ended = result.wait_for(kBetweenPolls) == std::future_status::ready; });
    }
    poll(box.take());
  } catch (...) {
    stop.request_stop();
    wait([&] { result.wait(); });
    throw;
  }
  return result.get();
}

}  // namespace silvafit::study
