// SPDX-License-Identifier: MIT
// Predictions of all responses of a model library for the trees of a table.
#pragma once

#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/prediction.hpp"
#include "silvafit/study/model_library.hpp"

namespace silvafit::study {

struct PredictResponsesOptions {
  fit::Level level = fit::Level::kPopulation;
  fit::NewGroups new_groups = fit::NewGroups::kPopulation;
  /// Which of a study's models: ols, covariates or nlme. Models without a role always count.
  std::string role = "nlme";
};

/// One response of N trees.
struct PredictedResponse {
  std::string response{};       ///< "h"
  std::vector<double> value{};  ///< (N) NaN where there is no prediction
};

struct PredictedResponses {
  std::vector<PredictedResponse> responses{};  ///< in the order of the library
  /// (N) what is to be known of a tree's predictions: "unknown plot", "missing dbh",
  /// "dbh outside fitted range", "h predicted" where a prediction stood in for a measurement,
  /// "no model of hcb for species OF"; several are separated by "; ".
  std::vector<std::string> flags{};
  /// Choices among the models of the library, for people.
  std::vector<std::string> notes{};
};

/// Columns of a table that have to stay text: species, and the groups of the models.
std::vector<std::string> text_columns(const ModelLibrary& library);

/// Predicts each response of the library with the model for the tree's species. Only models that
/// have converged are used; of several for the same species and response, the one of lowest AIC.
/// Where a model needs a response that was not measured, its prediction is used if there is one.
/// \throws InputError if a column that a model needs is not there or holds text, or for groups
///   that the fits have not seen if the options say so; UsageError if the library has no model of
///   the role
PredictedResponses predict_responses(const ModelLibrary& library,
                                     const data::Table& table,
                                     const PredictResponsesOptions& options = {});

}  // namespace silvafit::study
