// SPDX-License-Identifier: MIT
// The study: for each species and response, base models, structural covariates, mixed effects.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/enum_words.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/likelihood_ratio.hpp"
#include "silvafit/study/callbacks.hpp"
#include "silvafit/study/catalogue.hpp"

namespace silvafit::study {

/// The criterion by which the models of a level are ranked; lower is better.
enum class Criterion {
  kAic,
  kAicc,
  kBic,
  /// Root mean square error of predictions for groups left out, in 10 folds: with b = 0, of mixed
  /// models calibrated with 5 trees of each group. A model with folds that failed ranks behind
  /// those without.
  kCrossValidation,
};

constexpr std::array<std::string_view, 4> words_of(Criterion /*criterion*/) {
  return {"aic", "aicc", "bic", "cv"};
}

/// The criterion of each level.
struct LevelCriteria {
  Criterion base = Criterion::kAic;
  Criterion covariates = Criterion::kBic;
  Criterion random = Criterion::kBic;
  Criterion variance = Criterion::kAic;
};

/// The column of the trees' numbers, whose repeated measurements have an effect in common.
inline constexpr const char* kTree = "tree";

struct StudyOptions {
  std::vector<std::string> species{};  ///< empty: all with enough trees
  std::vector<std::string> responses{"h", "hcb", "cw"};
  /// Candidates by response: ids of the catalogue, or formulas. For a response that is not named
  /// here, all models of the catalogue.
  std::map<std::string, std::vector<std::string>> candidates{};
  std::vector<std::string> covariates{"W", "M", "C", "U"};  ///< as far as the table has them
  std::size_t covariate_parameters = 1;  ///< parameters that may have covariates at once, 1 or 2
  std::string group = "plot";            ///< column of the random effects
  /// Column of the times of repeated measurements, whose values are groups within those of `group`.
  /// Empty: none.
  std::string period{};
  std::vector<std::string> variance_functions{
      "none", "exponential", "power", "constant-plus-power"};
  LevelCriteria criteria{};
  /// Whether covariates and variance functions need a significant likelihood-ratio test.
  bool needs_tests = true;
  double significance = 0.05;  ///< of likelihood-ratio tests
  /// Level 1: of models within this distance of the best criterion, the one with the fewest
  /// parameters. Cross-validated errors are equally good within a standard error of the best.
  double equally_good = 2.0;
  /// Level 3 also chooses the fewest parameters among those equally good, instead of the best.
  bool parsimonious = false;
  std::size_t minimum_trees = 100;         ///< of a species with the response measured
  std::size_t maximum_random_effects = 3;  ///< coefficients that vary by plot at once
  /// Of more trees of a species, candidates are compared on about so many that represent all: every
  /// plot has its share, from its thinnest to its thickest trees. The chosen models are fitted to
  /// all trees. 0: candidates are always compared on all.
  std::size_t compared_trees = 10000;
  unsigned threads = 0;  ///< 0: as many as there are cores
};

/// Accuracy of a candidate's predictions for plots that were left out of its fit.
struct CrossValidated {
  double rmse = 0.0;            ///< NaN where no fold converged
  double standard_error = 0.0;  ///< of the rmse, from its spread between folds; NaN for one fold
  std::size_t folds = 0;
  std::size_t failed = 0;    ///< folds without a fit, whose trees do not count in the error
  std::size_t measured = 0;  ///< trees of each plot that calibrate the others; 0: b = 0
};

/// One candidate of a level.
struct Candidate {
  std::vector<std::string> terms{};  ///< level 2: sub-models; level 3: random coefficients
  fit::FittedModel fit;
  std::optional<fit::NestedTest> test{};  ///< against the simpler model of the level
  std::optional<CrossValidated> cross_validated{};
  int rank = 0;  ///< from 1 by the level's criterion; 0 if it did not converge
  bool chosen = false;
  /// Whether its curves and its likelihood were examined, which is done from the best rank down to
  /// the chosen one, and the reason for rejecting it, as a sentence; empty: none.
  bool is_examined = false;
  std::string objection{};
};

/// Accuracy of the chosen models for plots that were left out of their fits, by cross-validation:
/// random effects are zero, since no tree of such a plot is measured.
struct LeftOutPlots {
  std::size_t folds = 0;
  std::size_t trees = 0;  ///< predicted by all models: a fold whose fit failed has none
  std::size_t trees_without = 0;
  /// Root mean square errors; NaN without such a model.
  double rmse_ols = 0.0;
  double rmse_covariates = 0.0;
  double rmse_nlme = 0.0;
  /// 1 - SSE / SST of the same trees, SST around their mean; NaN without such a model.
  double r2_ols = 0.0;
  double r2_covariates = 0.0;
  double r2_nlme = 0.0;
  /// t of the differences of squared errors between the mixed model and the better one of least
  /// squares, with the plots as replicates; positive where the mixed model is worse.
  double t = 0.0;
  /// Whether its error is larger by more than 1 % and by more than the noise between plots, or by
  /// more than 5 % whatever the noise.
  bool is_worse = false;
};

/// Pairs of trees of a plot in a class of distance, and half the mean squared difference of their
/// standardized residuals.
struct VariogramClass {
  double distance_m = 0.0;  ///< the mean of the pairs
  double semivariance = 0.0;
  std::size_t pairs = 0;
};

/// The results for one species and response.
struct ResponseStudy {
  std::string species{};
  std::string response{};
  std::vector<std::size_t> rows{};  ///< rows of the table that all of its fits use
  std::string group = "plot";       ///< column of the random effects
  std::string period{};             ///< that of the times within its groups; empty: none
  std::size_t plots = 0;            ///< values of `group`
  std::vector<std::string> notes{};
  std::vector<Candidate> base{};                    ///< level 1
  std::vector<Candidate> covariates{};              ///< level 2, empty if left out
  std::vector<Candidate> random{};                  ///< level 3, empty if left out
  std::vector<Candidate> variance{};                ///< level 3, empty if left out
  std::optional<fit::FitResult> ols{};              ///< chosen at level 1
  std::optional<fit::FitResult> with_covariates{};  ///< chosen at level 2, or that of level 1
  std::optional<fit::FitResult> nlme{};             ///< chosen at level 3
  std::optional<LeftOutPlots> left_out{};           ///< where there is a mixed model
  std::vector<VariogramClass> variogram{};  ///< of the final model, where trees have positions
  /// Reasons why the chosen models are doubtful although they converged, as sentences.
  std::vector<std::string> doubts{};

  /// Whether the final model converged and there are no doubts about the chosen models.
  bool is_sound() const { return converged() && doubts.empty(); }
  /// Whether the last level ended in a reliable model, and the sentence on it.
  bool converged() const;
  std::string verdict() const;
  /// Whether there are groups of several trees, so that random effects can be estimated.
  bool has_groups() const;
  /// The sub-models that level 2 chose, or the random coefficients of level 3; empty if none.
  std::string chosen_terms(std::vector<Candidate> ResponseStudy::*level) const;
  /// A sentence on the first rejected candidate of each level whose best candidates were rejected.
  std::vector<std::string> rejected() const;
  /// The notes, and the sentences of rejected().
  std::vector<std::string> remarks() const;
};

struct StageTime {
  std::string name{};
  double seconds = 0.0;
  std::size_t fits = 0;
};

struct Study {
  StudyOptions options{};
  std::vector<std::string> notes{};
  std::vector<ResponseStudy> results{};
  std::vector<StageTime> stages{};

  std::size_t fit_count() const;
};

/// Runs the three levels for every species and response with enough trees.
///
/// Level 1: every candidate by least squares; of those within 2 AIC of the best, the one with the
/// fewest parameters. Level 2: every subset of the covariates on each parameter in turn, or on
/// pairs of them; lowest BIC, where its likelihood-ratio test against level 1 is significant at
/// 5 %; the chosen one also without intercept. Level 3: random effects of the group on every subset
/// of the coefficients (at most maximum_random_effects), lowest BIC of those that are not
/// boundary (singular) fits; with periods then also random effects of the periods within the
/// groups, on every subset of the coefficients, beside the chosen ones of the groups; then the
/// variance functions, lowest AIC where the test against a constant variance is significant at 5 %.
/// Candidates with implausible curves, and mixed models that are less likely than a nested model,
/// are rejected (docs/study.md). The options change criteria and thresholds. All fits of a
/// species and response use the same trees. Deterministic for any number of threads. A fit that
/// fails is listed with its reason.
///
/// \param table  an inventory with our column names, optionally W, M, U, C and `core` (only rows
///   with 1 count); a response that it does not have is left out with a note
/// \throws UsageError if an asked-for species is not there, a response has no candidate, or an
///   option is out of range; FormulaError if a candidate's formula cannot be read
Study run_study(const data::Table& table,
                const Catalogue& catalogue,
                const StudyOptions& options,
                const ProgressCallback& progress = {});

/// The name of a candidate at its level: the id of a base model, sub-models, random coefficients,
/// or the variance function.
std::string name_of(const Candidate& candidate, std::vector<Candidate> ResponseStudy::*level);

/// Unit of a response: "m".
std::string unit_of(const std::string& response);

}  // namespace silvafit::study
