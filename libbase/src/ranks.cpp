// SPDX-License-Identifier: MIT
#include "silvafit/base/ranks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "loop_depth.hpp"
#include "rank_module.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/module_function.hpp"
#include "silvafit/base/parallel.hpp"

namespace silvafit {
namespace {

class OneRank : public Ranks {
 public:
  std::size_t rank() const override { return 0; }
  std::size_t size() const override { return 1; }
  std::vector<std::string> gather(std::string_view own) override { return {std::string(own)}; }
  bool all_come_here() override { return true; }
  [[noreturn]] void end_job(int status) override { std::_Exit(status); }
};

/// How many processes Open MPI, or MPICH and Slurm, say that the job has.
int processes_of_job() {
  for (const char* const name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}) {
    if (const char* const value = std::getenv(name)) return std::max(1, std::atoi(value));
  }
  return 1;
}

Ranks& ranks_of_job() {
  // MPI's own plug-ins look for its symbols among those of the process.
  const auto module = module_function("silvafit_mpi", kRankModuleFunction, true);
  if (!module) {
    throw UsageError(
        "mpirun has started several processes, but this silvafit was built without MPI; build it "
        "with make mpi (build-mpi/bin/silvafit), or start one process");
  }
  if (module->address == nullptr) {
    throw UsageError(
        fmt::format("MPI cannot be loaded ({}); install openmpi-bin", module->problem));
  }
  return *reinterpret_cast<Ranks* (*)()>(module->address)();
}

}  // namespace

Ranks& Ranks::of_process() {
  static OneRank alone;
  static Ranks& ranks = processes_of_job() > 1 ? ranks_of_job() : alone;
  return ranks;
}

std::vector<std::string> farm(std::size_t count,
                              unsigned threads,
                              const std::function<std::string(std::size_t)>& task) {
  std::vector<std::string> results(count);
  if (is_in_loop() || Ranks::of_process().size() == 1) {
    parallel_for(count, threads, [&](std::size_t i) { results[i] = task(i); });
    return results;
  }
  Ranks& ranks = Ranks::of_process();
  const std::size_t stride = ranks.size();
  const std::size_t own = (count + stride - 1 - ranks.rank()) / stride;
  parallel_for(own, threads, [&](std::size_t k) {
    const std::size_t i = ranks.rank() + k * stride;
    results[i] = task(i);
  });
  std::string bytes;
  for (std::size_t i = ranks.rank(); i < count; i += stride) append_text(results[i], bytes);
  const std::vector<std::string> all = ranks.gather(bytes);
  for (std::size_t rank = 0; rank < stride; ++rank) {
    std::string_view rest = all[rank];
    for (std::size_t i = rank; i < count; i += stride) results[i] = take_text(rest);
  }
  return results;
}

namespace {

void append_size(std::uint64_t size, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&size), sizeof size);
}

std::string_view take_bytes(std::size_t count, std::string_view& bytes) {
  if (bytes.size() < count) throw Error("the result of a task is cut off", {});
  const std::string_view taken = bytes.substr(0, count);
  bytes.remove_prefix(count);
  return taken;
}

std::uint64_t take_size(std::string_view& bytes) {
  std::uint64_t size = 0;
  std::memcpy(&size, take_bytes(sizeof size, bytes).data(), sizeof size);
  return size;
}

}  // namespace

void append_numbers(const double* values, std::size_t count, std::string& bytes) {
  append_size(count, bytes);
  if (count > 0) bytes.append(reinterpret_cast<const char*>(values), count * sizeof *values);
}

std::vector<double> take_numbers(std::string_view& bytes) {
  std::vector<double> values(take_size(bytes));
  const std::string_view taken = take_bytes(values.size() * sizeof(double), bytes);
  if (!values.empty()) std::memcpy(values.data(), taken.data(), taken.size());
  return values;
}

void append_text(std::string_view text, std::string& bytes) {
  append_size(text.size(), bytes);
  bytes += text;
}

std::string take_text(std::string_view& bytes) {
  const std::uint64_t size = take_size(bytes);
  return std::string(take_bytes(size, bytes));
}

}  // namespace silvafit
