// SPDX-License-Identifier: MIT
// Compares predictions for plots left out by the mixed model and by least squares.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/study/study.hpp"

namespace silvafit::study {

/// A result and the trees of its models.
struct StudiedTrees {
  const ResponseStudy& result;
  const data::Table& table;
};

/// The number of fits of cross_validate_levels() for a result: 0 without a mixed model.
std::size_t left_out_fits(const ResponseStudy& result);

/// Cross-validates the chosen models of each result on the same folds of its plots. Threads, and
/// the processes of a job, share the models.
/// \param on_fit  called after each fit, from any thread
/// \return for each result; nothing without a mixed model, or if it could not be fitted to any fold
std::vector<std::optional<LeftOutPlots>> cross_validate_levels(
    const std::vector<StudiedTrees>& studies,
    unsigned threads,
    const std::function<void()>& on_fit = {});

/// t of the sums of differences between squared errors: positive where the first errors are larger.
/// Plots are independent, their trees are not.
/// \param first, second  (N) errors
/// \param plot           (N) from 0
double paired_t(const Eigen::VectorXd& first,
                const Eigen::VectorXd& second,
                const std::vector<std::size_t>& plot);

/// "For plots left out ...", where the mixed model is worse; else empty.
std::string doubt_of(const LeftOutPlots& left_out, const std::string& unit);

}  // namespace silvafit::study
