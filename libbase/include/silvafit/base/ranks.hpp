// SPDX-License-Identifier: MIT
// The processes of a parallel job, and tasks that they share with the threads of each.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit {

/// The processes (ranks) of a job started by mpirun or srun. All ranks read the same input and have
/// the same results; farm() divides the work between them. Without such a job there is one rank.
class Ranks {
 public:
  virtual ~Ranks() = default;
  Ranks() = default;
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  virtual std::size_t rank() const = 0;
  virtual std::size_t size() const = 0;
  /// Sends bytes to all ranks and returns those of all, in the order of the ranks. All ranks must
  /// call it, from the thread that called of_process() first.
  virtual std::vector<std::string> gather(std::string_view own) = 0;
  /// Whether all ranks call this within some seconds: after an error that occurs on all of them.
  virtual bool all_come_here() = 0;
  /// Ends all processes of the job.
  [[noreturn]] virtual void end_job(int status) = 0;

  bool is_first() const { return rank() == 0; }

  /// The ranks of the job of this process. The first call joins the job, if there is one.
  /// \throws UsageError if the process is one of several that mpirun has started, and this silvafit
  ///   was built without MPI
  static Ranks& of_process();
};

/// Runs task(0) .. task(count - 1), each on one rank and there on one of at most `threads` threads,
/// and returns their results in order, on all ranks. Rank r runs tasks r, r + size, ...
///
/// The results are bytes, so that they are equal for any number of ranks. Within a task or a
/// parallel_for(), farm() is parallel_for().
/// \throws the first exception of a task, on its rank; the other ranks wait until that rank ends
/// the
///   job
std::vector<std::string> farm(std::size_t count,
                              unsigned threads,
                              const std::function<std::string(std::size_t)>& task);

/// Appends the bytes of numbers to a text, and removes them from its beginning. For results of
/// tasks; all ranks must have the same byte order.
void append_numbers(const double* values, std::size_t count, std::string& bytes);
std::vector<double> take_numbers(std::string_view& bytes);
void append_text(std::string_view text, std::string& bytes);
std::string take_text(std::string_view& bytes);

}  // namespace silvafit
