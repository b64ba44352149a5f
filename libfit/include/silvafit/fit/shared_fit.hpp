// SPDX-License-Identifier: MIT
// Fit of one model to data that are distributed over the ranks of a job.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_specification.hpp"

namespace silvafit::fit {

/// The data of a rank.
struct SharedData {
  /// Whole groups from all parts of the data, the same on all ranks, with all labels of the text
  /// columns that the model uses.
  data::Table sample{};
  /// The rows of this rank, in whole groups; no value if it has none. The rows of rank r are before
  /// those of rank r + 1.
  std::optional<data::Table> own{};
  /// For each row of `own` the number of its part, ascending. Parts are of whole groups, and the
  /// same on any number of ranks.
  std::vector<std::size_t> parts{};
};

/// Fits a mixed model by a marginal likelihood (foce, focei, laplace, agq) to the groups of all
/// ranks.
///
/// All ranks must call it with the same model and options; all get the same fit. Start values and
/// scales are those of a fit to the sample, which each rank computes. From there, the likelihood of
/// all data is maximized: each rank has the data and the conditional modes of its own groups, and
/// the sums of the parts are added in order, so that the result has the same bytes on any number of
/// ranks and threads. Identifiability of parameters is tested with the sample.
///
/// Memory of a rank: its data, and the estimated random effects of all groups with their
/// uncertainty.
/// \param data  is consumed
/// \throws UsageError for another method, two nested groupings, strata of the variance function, or
///   coefficients that are held or bounded; InputError if a text column has a label that the sample
///   lacks; else as fit_model()
FittedModel fit_shared(const ModelSpecification& specification,
                       SharedData data,
                       const FitModelOptions& options);

}  // namespace silvafit::fit
