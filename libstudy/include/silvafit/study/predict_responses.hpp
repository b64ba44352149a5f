// SPDX-License-Identifier: MIT
// Predictions of all responses of a model library for the trees of a table.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/prediction.hpp"
#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/model_library.hpp"
#include "silvafit/study/tree_equations.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::study {

/// Which models of a library predict, and how.
struct PredictionSettings {
  fit::Level level = fit::Level::kPopulation;
  fit::NewGroups new_groups = fit::NewGroups::kPopulation;
  fit::SeenGroups seen_groups = fit::SeenGroups::kFitted;  ///< of calibrated predictions
  double interval = 0.0;                                   ///< coverage; 0: no intervals
  /// None: predictions for limits of intervals, and the mean for standard errors alone, as
  /// predict() of R has them.
  std::optional<fit::IntervalKind> interval_kind{};
  bool standard_errors = false;
  /// Which of a study's models: ols, covariates or nlme; empty: nlme, or the next simpler model if
  /// the table lacks a column. Models without a role always count.
  std::string role{};
  unsigned threads = 0;  ///< 0: as many as there are cores
  // Of predict_table and predict_trees:
  ReadingSettings reading{};
  /// Volume, biomass and carbon of the trees, with predicted heights where none is measured.
  EquationSettings equations{};

  bool wants_errors() const { return interval > 0.0 || standard_errors; }
  fit::IntervalKind kind_of_errors() const {
    using fit::IntervalKind;
    const bool has_limits = interval > 0.0;
    return interval_kind.value_or(has_limits ? IntervalKind::kPrediction
                                             : IntervalKind::kConfidence);
  }
};

/// The settings of a single fit's predictions, besides the level.
fit::PredictionOptions prediction_options(const PredictionSettings& settings);

/// One response of N trees.
struct PredictedResponse {
  std::string response{};       ///< "h"
  std::vector<double> value{};  ///< (N) NaN where there is no prediction
  std::vector<double> lower{};  ///< (N) ends of intervals; empty unless asked for
  std::vector<double> upper{};  ///< (N)
  /// (N) standard error of the quantity of the intervals: a new tree's value or the mean; empty
  /// unless intervals or errors are asked for.
  std::vector<double> standard_error{};
  /// (N) of calibrated predictions: measured trees of the group that were used, kFittedEffects
  /// where the fit's own random effects were, NaN where there is no prediction.
  std::vector<double> trees{};
};
/// In PredictedResponse::trees: the group was in the fit, and its random effects were used.
inline constexpr double kFittedEffects = -1.0;

/// A model that does not predict, since the table lacks columns that it reads.
struct UnusedModel {
  std::string species{};  ///< empty: all
  std::string response{};
  std::string name{};                  ///< its role in a study, or its name in the catalogue
  std::vector<std::string> missing{};  ///< columns
  std::string instead{};               ///< name of the model that predicts; empty: none does
};

struct PredictedResponses {
  std::vector<PredictedResponse> responses{};  ///< in the order of the library
  /// (N) limitations of a tree's predictions: "unknown plot", "missing dbh",
  /// "dbh outside fitted range", "h predicted" if a prediction replaces a measurement,
  /// "hcb interval includes the error of h", "no measured h in plot" if a
  /// calibrated prediction had no measured tree,
  /// "no model of hcb for species OF", "cw by the ols model: no column C"; several are separated by
  /// "; ".
  std::vector<std::string> flags{};
  /// Notes on choices among the models of the library.
  std::vector<std::string> notes{};
  std::vector<UnusedModel> unused{};
  /// How far the last two rules of quadrature differ in marginal means, relative to them.
  double marginal_difference = 0.0;
};

/// A note on marginal means; empty if they are accurate.
std::string note_on_marginal_means(double marginal_difference);

/// Columns of a table that have to stay text: species, and the groups of the models.
std::vector<std::string> text_columns(const ModelLibrary& library);

/// Columns of a table that the models read: those, responses, covariates, and what variance
/// functions read.
std::vector<std::string> columns_read(const ModelLibrary& library);
/// Those of one model, but for the response.
std::vector<std::string> columns_read(const fit::ModelSpecification& specification);

/// Predicts each response of the library with the model for the tree's species. Only models that
/// have converged are used; of several for the same species and response, the one of lowest AIC.
/// A model whose columns are not in the table is skipped, and another one that does not need them
/// is used in its place if there is one (PredictedResponses::unused).
/// Where a model needs a response that was not measured, its prediction is used if there is one,
/// and intervals include its error. Calibration uses the trees whose response and predictors were
/// all measured.
/// \throws InputError if no model has its columns, if one of them holds text, or for groups
///   that the fits have not seen if the options say so; DomainError at the first covariate outside
///   the domain of its model; UsageError if the library has no model of the role
/// \param catalogue  models do not predict outside their domain in it; null: domains are unknown
PredictedResponses predict_responses(const ModelLibrary& library,
                                     const data::Table& table,
                                     const PredictionSettings& settings = {},
                                     const Catalogue* catalogue = nullptr);

}  // namespace silvafit::study
