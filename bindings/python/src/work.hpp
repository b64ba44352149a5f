// SPDX-License-Identifier: MIT
// Long work on a separate thread, so that other Python threads run and Ctrl-C stops it.
#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "silvafit/study/callbacks.hpp"

namespace silvafit::python {

namespace py = pybind11;

/// Messages of a piece of work while it runs. They are written by any thread and given to Python by
/// the thread that called.
class Work {
 public:
  std::stop_token stop() const { return stop_.get_token(); }
  void request_stop() { stop_.request_stop(); }

  void note(const std::string& text);
  void line(const std::string& text);
  /// \throws Stopped if the caller has requested it
  void progress(const std::string& stage, std::size_t done, std::size_t total);

  study::Callbacks callbacks();

  /// Calls listener(kind, text, done, total) with new messages: "note", "line" and "progress". The
  /// GIL is held.
  void tell(const py::object& listener);

 private:
  struct Message {
    const char* kind;
    std::string text;
  };
  struct Stage {
    std::string name;
    std::size_t done;
    std::size_t total;
  };

  std::stop_source stop_{};
  std::mutex mutex_{};
  std::vector<Message> messages_{};
  std::optional<Stage> stage_{};  ///< the latest one that was not passed on
};

/// Runs a function on a thread without the GIL; this thread checks for Ctrl-C and informs the
/// listener.
/// \param listener  a callable, or None
/// \throws exceptions of the function, the listener or a signal handler
void run_work(Work& work, const py::object& listener, const std::function<void()>& function);

/// The same with a result.
template <class Function>
auto run(const py::object& listener, const Function& function) {
  Work work;
  std::optional<std::invoke_result_t<const Function&, Work&>> result;
  run_work(work, listener, [&] { result.emplace(function(work)); });
  return *std::move(result);
}

}  // namespace silvafit::python
