// SPDX-License-Identifier: MIT
// Imputes values that were measured on some trees of an inventory only, mainly heights.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/enum_words.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/study/catalogue.hpp"

namespace silvafit::study {

struct ImputeOptions {
  std::string response = "h";
  /// Column of the plots; empty: `plot` if there is one, else no random effects.
  std::string group{};
  /// Column whose values get models of their own if enough trees are measured, such as species;
  /// empty: one model for all.
  std::string by{};
  std::size_t minimum_trees = 30;  ///< measured trees for a model of its own
  /// Formula, or models of the catalogue of which the one with the lowest AIC is used; with
  /// neither, Naslund's curve for h, and the candidates of the catalogue for other responses.
  std::string formula{};
  std::vector<std::string> models{};
  /// Random effects as in `a + b | plot`, "none" for none; empty: the first two coefficients, or
  /// fewer if that does not converge.
  std::string random{};
  std::string variance{};               ///< empty: power(dbh)
  std::optional<fit::Method> method{};  ///< none: lb, or gnls without random effects
  /// Adds a random residual to each imputed value, and random effects drawn for each plot (and
  /// stand, of nested groupings) without measured trees, so that imputed values vary as measured
  /// ones do. A residual that makes a value impossible, such as a crown base below the ground, is
  /// drawn anew.
  bool add_residual = false;
  /// Coverage of prediction intervals of imputed values, in (0, 1); 0: none.
  double interval = 0.0;
  std::uint64_t seed = 1;
  unsigned threads = 0;
};

enum class ImputeSource {
  kMeasured,
  kImputed,
  kMissing,  ///< neither measured nor imputed
};
constexpr std::array<std::string_view, 3> words_of(ImputeSource /*source*/) {
  return {"measured", "imputed", "missing"};
}
enum class ImputeLevel {
  kNone,        ///< of a measured tree, or one that could not be imputed
  kPlot,        ///< with the random effects of its plot
  kStand,       ///< nested groupings: with those of the coarser group, none measured on the plot
  kPopulation,  ///< with random effects of 0, or drawn ones; or the model has none
};
constexpr std::array<std::string_view, 4> words_of(ImputeLevel /*level*/) {
  return {"", "plot", "stand", "population"};
}

/// The model of some of the trees.
struct ImputeModel {
  std::string label{};  ///< value of the column `by`; empty: of all others
  fit::FittedModel fit;
  std::uint64_t stream = 1;  ///< of random numbers, for residuals
};

/// The models of an imputation; that of all other trees, if any, is the last.
struct ImputeModels {
  std::vector<ImputeModel> models{};
  std::set<std::string> measured_labels{};  ///< values of the column `by` with a measured tree
  std::vector<std::string> notes{};
};

/// N rows of the table.
struct Imputation {
  std::vector<ImputeModel> models{};
  std::vector<double> value{};         ///< (N) measured or imputed; NaN where missing
  std::vector<ImputeSource> source{};  ///< (N)
  std::vector<ImputeLevel> level{};    ///< (N)
  /// (N) why a tree was not imputed, or what is doubtful: "dbh is missing", "dbh is outside the
  /// fitted range"; empty otherwise.
  std::vector<std::string> flag{};
  std::vector<double> lower{};  ///< (N) limits of intervals of imputed values, else NaN; empty
  std::vector<double> upper{};  ///< without intervals
  std::vector<std::string> notes{};

  std::size_t count(ImputeSource which) const;
  std::size_t count(ImputeLevel which) const;
};

/// Fits a model to the trees whose response was measured and predicts that of the others, with the
/// random effects of their plot where it has measured trees. Measured values stay as they are.
///
/// Deterministic for any number of threads.
/// \throws UsageError for options that cannot be combined or unknown columns;
///   InputError if no tree is measured; NumericalError if no model converges
/// Source: Mehtatalo, de-Miguel and Gregoire 2015, Canadian Journal of Forest Research 45, 826-837.
Imputation impute(const data::Table& table,
                  const Catalogue& catalogue,
                  const ImputeOptions& options = {});

/// The models alone, of a table of which rows without a measured response may be left out.
/// \param labels  values of the column `by` of all trees that are to be imputed, in the order of
///                their first rows; empty for missing ones and without such a column
ImputeModels imputation_models(const data::Table& table,
                               const Catalogue& catalogue,
                               const ImputeOptions& options,
                               const std::vector<std::string>& labels);
/// Labels of further rows, after those that are known already.
void add_labels(const data::Table& table,
                const ImputeOptions& options,
                std::vector<std::string>& labels);

/// Predicts with such models; all rows of a group must be in the table.
/// \throws UsageError as impute
Imputation impute_with(const ImputeModels& models,
                       const data::Table& table,
                       const ImputeOptions& options);

}  // namespace silvafit::study
