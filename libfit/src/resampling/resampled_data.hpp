// SPDX-License-Identifier: MIT
// The data of a bootstrap's replicates, and the starts of their fits.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "model/correlated_rows.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Options of the refits of a fit: one quick search each, by its method.
FitModelOptions refit_options(const FittedModel& fit, FitModelOptions options);

/// Data, the model of them, and an earlier fit with effects for their groups.
struct Resampled {
  data::Table table{};
  ModelSpecification specification;
  FittedModel start;
  std::string drawn_group{};  ///< column of the outermost groups as drawn; empty: that of the file
};

/// Draws responses from a fit on its own design.
class ParametricDraw {
 public:
  ParametricDraw(const FittedModel& fit, const data::Table& table);

  /// \throws NumericalError if the mean is not finite with the random effects that were drawn
  Resampled draw(Random& random) const;

 private:
  const FittedModel& fit_;
  NonlinearModel model_;
  data::Table table_;                                 ///< the rows of the fit, in the model's order
  std::vector<MatrixXd> roots_;                       ///< (q x q) root of Psi of each term
  std::shared_ptr<const CorrelatedRows> correlated_;  ///< null: independent residuals
  CorrelatedRows::Factors factors_;
};

/// Draws groups of a fit's data with replacement.
class CaseDraw {
 public:
  /// \param group  column of the drawn groups; default: the first term of the random
  ///   effects or, without these, single rows
  /// \throws UsageError if a group of the random effects is in several of these, or there is only
  ///   one; InputError if a row has none
  CaseDraw(const FittedModel& fit, const data::Table& table, const std::string& group);

  Resampled draw(Random& random) const;

 private:
  void add_groups(const NonlinearModel& model);
  void join(const std::string& group);
  void relabel(const std::vector<std::size_t>& drawn, Resampled& result) const;

  const FittedModel& fit_;
  data::Table table_;                              ///< the rows of the fit, in the model's order
  std::vector<std::vector<std::size_t>> members_;  ///< rows of each group of the first term
  std::vector<std::vector<std::size_t>> model_groups_;  ///< of each, among the model's groups
  std::vector<std::vector<std::size_t>> units_;         ///< groups that are drawn together
};

}  // namespace silvafit::fit
