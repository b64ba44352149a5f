// SPDX-License-Identifier: MIT
// Times, memory and medians of benchmark runs.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace silvafit::bench {

/// CPU seconds of this process so far, all threads together.
double cpu_seconds();

double median(std::vector<double> values);

/// Median CPU seconds of calls of `work`. Called at least `repeats` times and, where calls are
/// short, until a tenth of a second is spent.
double median_cpu_seconds(int repeats, const std::function<void()>& work);

/// Runs `work` in a separate process with its own memory and allocator.
/// \returns what it returned, with "peak_rss_mb" added: the process's largest resident size [MB]
/// \throws NumericalError if the process failed
nlohmann::json in_own_process(const std::function<nlohmann::json()>& work);

/// Runs `work` and gives the program's exit status: 1, with the message on stderr, if it throws.
int exit_status(const std::function<void()>& work);

/// Least-squares slope of log(y) on log(x): the exponent of growth.
double growth_exponent(const std::vector<double>& x, const std::vector<double>& y);

/// The names of processor and kernel, from Linux.
std::string machine();

/// Writes the JSON to a file, or to standard output if the name is empty.
/// \throws InputError if it cannot be written
void write_json(const nlohmann::json& json, const std::string& path);

}  // namespace silvafit::bench
