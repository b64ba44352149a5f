// SPDX-License-Identifier: MIT
// The fits of one level of a study, in parallel.
#pragma once

#include <cstddef>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "study/study_work.hpp"

namespace silvafit::study {

/// Runs the fits of one level for all species and responses together, so that all threads are
/// busy.
class LevelFits {
 public:
  /// A fit of a work, in the order in which they were added.
  struct Place {
    std::size_t work = 0;
    std::size_t position = 0;
  };

  /// \param criterion  of the level: candidates are cross-validated where it asks for that
  /// \param group      column of the groups that cross-validation leaves out
  LevelFits(std::string name,
            const std::vector<Work>& works,
            Criterion criterion,
            std::string group);

  void add(std::size_t work, std::vector<Trial> trials);
  /// Adds a trial whose fit is known from an earlier level.
  /// \param compared  the fit to the trees that candidates are compared on
  /// \param final     the fit that result() gives
  void add_known(std::size_t work, Trial trial, fit::FittedModel compared, fit::FitResult final);
  void run(unsigned threads, const ProgressCallback& progress, std::vector<StageTime>& stages);
  /// The fits of one work as candidates, in the order in which they were added.
  std::vector<Candidate> candidates(std::size_t work) const;
  /// One fit of a work to all of its trees, in that order. Fits that are far from the best one are
  /// repeated, as are those to a sample; mixed ones are searched from all starts.
  /// \param threads  of the fit; the result does not depend on them
  fit::FitResult result(const Place& place, unsigned threads = 1) const;
  /// Several of them. Threads, and the processes of a job, share the work.
  std::vector<fit::FitResult> results(const std::vector<Place>& places, unsigned threads) const;

 private:
  /// One fit to be done, and the place of its result.
  struct Task {
    Trial trial;
    std::size_t work = 0;
    std::size_t position = 0;
    std::optional<fit::FitResult> known{};  ///< the final fit, from an earlier level
  };

  /// Tasks in their order: those of a number wait for those of smaller numbers, whose
  /// random effects they may contain.
  std::vector<std::vector<std::size_t>> waves() const;
  void run_task(const Task& task);
  /// Whether a fit with fewer of its random effects has failed or is a boundary (singular) one, so
  /// that more of them are unlikely to be supported.
  bool contains_failure(const Task& task);
  void take(const Task& task, fit::FitResult result);
  std::string bytes_of_task(const Task& task);
  void take_bytes(const Task& task, std::string_view bytes);
  void forget_worst(std::size_t work);
  const Task& task_of(std::size_t work, std::size_t position) const;

  std::string name_;
  const std::vector<Work>& works_;
  Criterion criterion_;
  std::string group_;
  std::vector<Task> tasks_;
  std::vector<std::vector<fit::FitResult>> results_;
  /// Positions of each work's fits that still store the values of their observations.
  std::vector<std::vector<std::size_t>> whole_;
  std::mutex taking_;
  std::vector<std::vector<std::optional<CrossValidated>>> cross_validated_;
};

}  // namespace silvafit::study
