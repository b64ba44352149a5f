// SPDX-License-Identifier: MIT
// Checks whether the curves of a fitted model are plausible for trees.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/study/catalogue.hpp"

namespace silvafit::study {

/// Checks models of one response against the trees that they were fitted to.
///
/// Curves go over DBH from 0 to 1.2 times the largest DBH, one for the population (b = 0) with the
/// other columns at their medians, and one for each plot with its random effects and the medians of
/// its own trees. Heights of trees at a DBH, for models that read h, are those of Naslund's curve,
/// fitted to the heights by its linear form (d / sqrt(h - 1.3) = a + b d).
///
/// All curves and all fitted values must be finite; of h, hcb and cw also not negative and at most
/// twice the largest value that was measured; those of h must not fall with DBH by more than a
/// millimeter; those of hcb must not lie above h. The parameters must satisfy the sensible
/// conditions of the catalogue's entry for the population and for each plot, and its limit for
/// large DBH must not be more than ten times the largest value measured. Models that do not read
/// dbh are judged by their fitted values alone.
class Plausibility {
 public:
  /// \param trees  the rows of the fits, with all columns that these read; must outlive this
  /// \param group   column of the random effects
  /// \param period  that of finer groups within them; empty: none
  Plausibility(std::string response,
               const data::Table& trees,
               std::string group,
               std::string period = {});

  /// The first fault of a fit and its place, as a sentence; empty if there is none.
  /// \param entry  of the catalogue; nullptr for a formula of the user
  std::string objection(const fit::FittedModel& fit, const BaseModel* entry) const;

 private:
  /// The trees of one curve.
  struct Stratum {
    std::string name{};               ///< "the population", "plot 7" or "plot 7, year 2019"
    std::string group{};              ///< its label; empty: the population
    std::string period{};             ///< its label; empty: all periods
    std::string tree{};               ///< empty: no tree's own curve
    std::size_t row = 0;              ///< a typical tree: that of the median DBH
    std::vector<std::size_t> rows{};  ///< its trees
  };

  void add_strata();

  std::string objection_to_values(const fit::FittedModel& fit) const;
  std::string objection_to_parameters(const fit::FittedModel& fit,
                                      const BaseModel& entry,
                                      const data::Table& typical) const;
  /// The fault of a curve's limit for large DBH; empty if there is none.
  std::string flaw_of_limit(const BaseModel& entry,
                            const std::map<std::string, double>& parameters) const;
  std::string objection_to_curves(const fit::FittedModel& fit, const data::Table& typical) const;
  /// The fault of one curve; empty if there is none.
  std::string flaw_of_curve(const double* values) const;
  /// One row for each stratum: medians of the numeric columns that a fit reads.
  data::Table typical_trees(const fit::FittedModel& fit) const;
  /// (p x count) fixed effects with the random effects of the first strata.
  Eigen::MatrixXd coefficients_of_strata(const fit::FittedModel& fit, std::size_t count) const;
  data::Table grid(const data::Table& typical, std::size_t begin, std::size_t end) const;
  /// The fault of a value at a point of a curve; empty if there is none.
  std::string flaw_of_point(std::size_t point, double value) const;
  /// Whether a fitted value is possible for its tree.
  bool is_possible(std::size_t row, double value) const;
  /// Whether the response is h, hcb or cw, for which there are more conditions.
  bool is_tree_measure() const;
  std::string text_of(double value) const;

  std::string response_;
  const data::Table* trees_;
  std::string group_;
  std::string period_;
  std::vector<Stratum> strata_;  ///< the population first
  std::vector<double> dbh_cm_;   ///< of each point of a curve
  std::vector<double> h_m_;      ///< Naslund's height there; empty where there are no heights
  double least_dbh_cm_ = 0.0;
  double top_dbh_cm_ = 0.0;
  double largest_ = 0.0;  ///< measured response
};

}  // namespace silvafit::study
