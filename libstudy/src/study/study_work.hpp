// SPDX-License-Identifier: MIT
// The data of one species and response: trees, and the columns that models may use.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/study/study.hpp"
#include "study/plausibility.hpp"
#include "study/study_levels.hpp"

namespace silvafit::study {

/// A species and response in work: its trees and what it may use.
struct Work {
  ResponseStudy result{};
  data::Table table{};   ///< its trees
  data::Table sample{};  ///< those that candidates are compared on; empty: all
  std::vector<BaseCandidate> candidates{};
  std::vector<std::string> covariates{};
  std::size_t measured = 0;  ///< trees with all that the candidates need
  std::size_t core = 0;      ///< those of them that are core; all where the table does not say
  /// Of its trees. It refers to the table, so it is made when the work has found its place.
  std::optional<Plausibility> plausibility{};

  /// The chosen least-squares model as it was compared: its fit to the sample, if there is one.
  std::optional<fit::FittedModel> compared{};

  /// Base models whose mixed models were all rejected, by their numbers, with the reason.
  std::map<std::size_t, std::string> barred{};

  bool is_sampled() const { return sample.rows() > 0; }
  const data::Table& compared_trees() const { return is_sampled() ? sample : table; }
  /// Why the curves of a fit to the trees are implausible, as a sentence; empty if they are not.
  std::string objection_to_curves(const fit::FittedModel& fit) const;
};

/// How many trees there are, for messages: "10", or "10 core trees of 80 measured".
std::string tree_counts(const Work& work);

/// Whether the table has the column, with numbers.
bool has_numbers(const data::Table& table, const std::string& name);

/// The species to study: those that the options name, or all.
/// \throws UsageError if one that is asked for is not there
std::vector<std::string> species_of(const data::Table& table, const StudyOptions& options);

/// Sets up one species and response: what it may use, and the rows that all of its fits share.
/// \throws UsageError if a candidate is neither in the catalogue nor a formula, or is for another
/// response
Work prepared(const data::Table& table,
              const Catalogue& catalogue,
              const StudyOptions& options,
              const std::string& species,
              const std::string& response);

}  // namespace silvafit::study
