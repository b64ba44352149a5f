// SPDX-License-Identifier: MIT
#include "work.hpp"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <thread>

#include "errors.hpp"
#include "silvafit/base/stop.hpp"

namespace silvafit::python {

void Work::note(const std::string& text) {
  const std::lock_guard lock(mutex_);
  messages_.push_back({"note", in_words_of_python(text)});
}

void Work::line(const std::string& text) {
  const std::lock_guard lock(mutex_);
  messages_.push_back({"line", text});
}

void Work::progress(const std::string& stage, std::size_t done, std::size_t total) {
  check_stop(stop());
  const std::lock_guard lock(mutex_);
  stage_ = {stage, done, total};
}

study::Callbacks Work::callbacks() {
  return {.note = [this](const std::string& text) { note(text); },
          .progress = [this](const std::string& stage,
                             std::size_t done,
                             std::size_t total) { progress(stage, done, total); }};
}

void Work::tell(const py::object& listener) {
  std::vector<Message> messages;
  std::optional<Stage> stage;
  {
    const std::lock_guard lock(mutex_);
    messages.swap(messages_);
    stage.swap(stage_);
  }
  if (listener.is_none()) return;
  for (const Message& message : messages) listener(message.kind, message.text, 0, 0);
  if (stage) listener("progress", stage->name, stage->done, stage->total);
}

void run_work(Work& work, const py::object& listener, const std::function<void()>& function) {
  std::mutex mutex;
  std::condition_variable change;
  bool is_done = false;
  std::exception_ptr failure;
  std::thread thread([&] {
    try {
      function();
    } catch (...) {
      failure = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    is_done = true;
    change.notify_one();
  });
  const auto wait = [&] {
    constexpr auto kBetweenLooks = std::chrono::milliseconds(50);
    const py::gil_scoped_release other_threads_run;
    std::unique_lock lock(mutex);
    return change.wait_for(lock, kBetweenLooks, [&] { return is_done; });
  };
  std::exception_ptr interruption;
  for (bool has_ended = false; !has_ended;) {
    has_ended = wait();
    if (interruption) continue;
    try {
      work.tell(listener);
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    } catch (...) {
      interruption = std::current_exception();
      work.request_stop();
    }
  }
  thread.join();
  if (interruption) std::rethrow_exception(interruption);
  if (failure) std::rethrow_exception(failure);
}

}  // namespace silvafit::python
