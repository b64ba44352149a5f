// SPDX-License-Identifier: MIT
#include "measurement.hpp"

#include <sys/resource.h>
#include <sys/utsname.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <exception>
#include <fstream>
#include <iostream>
#include <thread>

#include "silvafit/base/error.hpp"

namespace silvafit::bench {

double cpu_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

double median_cpu_seconds(int repeats, const std::function<void()>& work) {
  std::vector<double> times;
  double total = 0.0;
  while (static_cast<int>(times.size()) < repeats || (total < 0.1 && times.size() < 1000)) {
    const double begin = cpu_seconds();
    work();
    times.push_back(cpu_seconds() - begin);
    total += times.back();
  }
  return median(times);
}

namespace {

/// The output of the child: its result as text, or no value if it failed.
std::string read_all(int descriptor) {
  std::string text;
  std::array<char, 4096> buffer{};
  for (ssize_t size = 0; (size = read(descriptor, buffer.data(), buffer.size())) > 0;) {
    text.append(buffer.data(), static_cast<std::size_t>(size));
  }
  return text;
}

[[noreturn]] void run_child(int descriptor, const std::function<nlohmann::json()>& work) {
  int status = 0;
  try {
    const std::string text = work().dump();
    for (std::size_t at = 0; at < text.size();) {
      const ssize_t size = write(descriptor, text.data() + at, text.size() - at);
      if (size <= 0) _exit(1);
      at += static_cast<std::size_t>(size);
    }
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    status = 1;
  }
  _exit(status);
}

}  // namespace

nlohmann::json in_own_process(const std::function<nlohmann::json()>& work) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) throw NumericalError("no pipe could be opened");
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) throw NumericalError("no process could be started");
  if (child == 0) {
    close(ends[0]);
    run_child(ends[1], work);
  }
  close(ends[1]);
  const std::string text = read_all(ends[0]);
  close(ends[0]);
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  if (status != 0) throw NumericalError("a measured run failed; its message stands above");
  nlohmann::json result = nlohmann::json::parse(text);
  result["peak_rss_mb"] = static_cast<double>(usage.ru_maxrss) / 1024.0;
  return result;
}

int exit_status(const std::function<void()>& work) {
  try {
    work();
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}

double growth_exponent(const std::vector<double>& x, const std::vector<double>& y) {
  double sx = 0.0;
  double sy = 0.0;
  double sxx = 0.0;
  double sxy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double u = std::log(x[i]);
    const double v = std::log(y[i]);
    sx += u;
    sy += v;
    sxx += u * u;
    sxy += u * v;
  }
  const auto n = static_cast<double>(x.size());
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

std::string machine() {
  std::string processor = "unknown processor";
  std::ifstream information("/proc/cpuinfo");
  for (std::string line; std::getline(information, line);) {
    if (line.rfind("model name", 0) == 0) {
      processor = line.substr(line.find(':') + 2);
      break;
    }
  }
  utsname system{};
  uname(&system);
  return processor + ", " + std::to_string(std::thread::hardware_concurrency()) + " cores, " +
         system.sysname + " " + system.release;
}

void write_json(const nlohmann::json& json, const std::string& path) {
  const std::string text = json.dump(1) + "\n";
  if (path.empty()) {
    std::cout << text;
    return;
  }
  std::ofstream stream(path);
  stream << text;
  stream.flush();
  if (!stream) throw InputError("cannot be written", {.file = path});
}

}  // namespace silvafit::bench
