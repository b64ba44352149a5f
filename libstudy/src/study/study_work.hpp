// SPDX-License-Identifier: MIT
// The data of one species and response: trees, and the columns for its models; and the steps that
// a study takes with them.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/study/study.hpp"
#include "study/plausibility.hpp"
#include "study/study_levels.hpp"

namespace silvafit::study {

/// The data of one species and response while it is studied.
struct Work {
  ResponseStudy result{};
  data::Table table{};   ///< its trees
  data::Table sample{};  ///< the trees on which candidates are compared; empty: all
  std::vector<BaseCandidate> candidates{};
  std::vector<std::string> covariates{};
  std::string lacking{};     ///< those that some trees lack, as words
  std::size_t measured = 0;  ///< trees with all that the candidates need
  std::size_t core = 0;      ///< those of them that are core; all if the table has no such column
  /// Of its trees. It refers to the table, so it is made when the work does not move any more.
  std::optional<Plausibility> plausibility{};

  /// The chosen least-squares model as it was compared: its fit to the sample, if any.
  std::optional<fit::FittedModel> compared{};

  /// Indices of base models whose mixed models were all rejected, with the reason.
  std::map<std::size_t, std::string> barred{};

  bool is_sampled() const { return sample.rows() > 0; }
  /// Whether all rows have a tree and some trees have several rows, at different periods.
  bool has_repeated_trees() const;
  const data::Table& compared_trees() const { return is_sampled() ? sample : table; }
  /// Why the curves of a fit are implausible, as a sentence; empty if they are plausible.
  std::string objection_to_curves(const fit::FittedModel& fit) const;
};

/// Columns that the variance functions of level 3 read.
std::vector<std::string> variance_columns(const StudyOptions& options);

/// The number of trees for messages: "10", or "10 core trees of 80 measured".
std::string tree_counts(const Work& work);

/// Whether the table has the column, with numbers.
bool has_numbers(const data::Table& table, const std::string& name);

/// The species to study: those that the options name, or all.
/// \throws UsageError if one of them is unknown
std::vector<std::string> species_of(const data::Table& table, const StudyOptions& options);

/// Prepares one species and response: columns for models, and the rows of all of its fits.
/// \throws UsageError if a candidate is neither in the catalogue nor a formula, or is for another
/// response
Work prepared(const data::Table& table,
              const Catalogue& catalogue,
              const StudyOptions& options,
              const std::string& species,
              const std::string& response);

/// Adds doubts about a model that explains nothing, or whose residual variance is that of a few
/// trees, or whose covariates of plots are not significant, and notes on outlying trees and plots,
/// and on neighbors whose residuals are alike.
/// \param table         the inventory, of which the result has rows
/// \param significance  of covariates with one value in each plot
void check_final_model(ResponseStudy& result, const data::Table& table, double significance);

/// Runs the three levels and the cross-validation of the chosen models; fills in the results of the
/// works, and the study's stages.
/// \param works  must not move in memory
void run_stages(std::vector<Work>& works, Study& study, const ProgressCallback& progress);

/// About this many rows of a table that represent all, ascending.
///
/// Every group has the same maximum share, but at least 40 rows if it has them; the
/// selected rows are evenly spaced over its rows by dbh, or by their order without that column. If
/// there are still too many, every second, third ... group is used. No random
/// numbers.
std::vector<std::size_t> representative_rows(const data::Table& table,
                                             const std::string& group,
                                             std::size_t wanted);

}  // namespace silvafit::study
