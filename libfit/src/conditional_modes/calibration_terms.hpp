// SPDX-License-Identifier: MIT
// Density of a group's observations given its random effects, at the estimates of a fit.
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "model/row_program.hpp"
#include "silvafit/data/expression.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Sums over the rows of each group of the terms that define random effects b: with rho the
/// negative log density of an observation,
///
///     slope      sum B' rho' f_b                        of the objective
///     curvature  sum B' (rho'' f_b f_b' + rho' f_bb) B  its derivative
///     expected   sum B' omega f_b f_b' B                positive semidefinite
///
/// The marginal methods have rho' and rho'' of the density (docs/marginal-likelihood.md); for lb,
/// whose weights are held while the effects are found, rho' = -r tau with tau = 1/(sigma g)^2 taken
/// at the effects, and rho'' is its derivative. For lb the objective is the weighted sum of squares
/// with the weights of another point, by which a search can see that it descends.
class CalibrationTerms {
 public:
  /// Scratch memory of one caller.
  struct Workspace {
    data::Program::Workspace program{};
    std::vector<double> parameters{};
    std::vector<double> outputs{};
    std::vector<double> sums{};
    std::vector<std::size_t> begins{};
    std::vector<const double*> inputs{};
    std::vector<double*> columns{};
  };

  /// \param model   the rows to calibrate from
  /// \param random  (r) coefficients with random effects in any grouping, ascending
  CalibrationTerms(const NonlinearModel& model,
                   const FittedModel& fit,
                   std::vector<Eigen::Index> random);

  Eigen::Index random_count() const { return static_cast<Eigen::Index>(random_.size()); }
  /// Whether weights depend on the effects and are held, as for lb with a variance function of the
  /// fitted value.
  bool holds_weights() const { return holds_weights_; }

  /// Rows of the sums: the objective with held weights, that with own weights, slope (r), then the
  /// lower triangles by columns of curvature and of expected.
  Eigen::Index slope_row() const { return 2; }
  Eigen::Index curvature_row() const { return 2 + random_count(); }
  Eigen::Index expected_row() const { return curvature_row() + triangle(); }
  Eigen::Index triangle() const { return random_count() * (random_count() + 1) / 2; }

  /// \param effects  (r x G) of all groups
  /// \param held     (N) weights tau for the objective; not read unless holds_weights()
  /// \param own      (N) result: the weights of the rows of these groups, if holds_weights()
  /// \param sums     one column a group of [first, last)
  void evaluate(Eigen::Index first,
                Eigen::Index last,
                const Eigen::MatrixXd& effects,
                const Eigen::VectorXd& held,
                Eigen::VectorXd& own,
                Eigen::MatrixXd& sums,
                Workspace& workspace) const;
  /// (r p x last - first) the derivative of the slope by the coefficients, effects held, by
  /// columns.
  void by_coefficients(Eigen::Index first,
                       Eigen::Index last,
                       const Eigen::MatrixXd& effects,
                       Eigen::MatrixXd& sums,
                       Workspace& workspace) const;

 private:
  /// A value of the programs that differs by row.
  struct Source {
    enum class Kind { kColumn, kParameter, kHeld };
    Kind kind = Kind::kColumn;
    Eigen::Index index = 0;          ///< of the parameter
    const double* column = nullptr;  ///< (N)

    static bool is_scalar() { return false; }
  };
  using Task = RowProgram<Source>;
  struct Derivatives;

  Derivatives derivatives_of(const FittedModel& fit) const;
  data::Expression population_mean() const;
  data::Expression multiplier(Eigen::Index coefficient) const;
  const std::string& parameter_name(Eigen::Index coefficient) const;
  data::Expression by(Eigen::Index c) const;
  data::Expression by_both(Eigen::Index c, Eigen::Index e) const;
  /// What evaluate() sums, and the weights behind, if they are held.
  std::vector<data::Expression> search_outputs(const Derivatives& d) const;
  /// What by_coefficients() sums.
  std::vector<data::Expression> fixed_outputs(const Derivatives& d) const;
  void fill_base(const FittedModel& fit);
  void store_strata(const FittedModel& fit);
  data::Expression log_scale(const FittedModel& fit, const data::Expression& fitted) const;
  Task task_of(const std::vector<data::Expression>& outputs) const;
  Source source_of(const std::string& name) const;
  void fill_parameters(Eigen::Index group,
                       Eigen::Index row,
                       Eigen::Index rows,
                       Eigen::Index done,
                       const Eigen::MatrixXd& effects,
                       Workspace& workspace) const;
  void run(const Task& task,
           Eigen::Index first,
           Eigen::Index last,
           const Eigen::MatrixXd& effects,
           const Eigen::VectorXd* held,
           Eigen::VectorXd* own,
           Eigen::MatrixXd& sums,
           Workspace& workspace) const;

  const NonlinearModel& model_;
  std::vector<Eigen::Index> random_;
  bool holds_weights_ = false;
  Eigen::MatrixXd base_;  ///< (N x K) parameters without random effects
  /// Columns of parameters of the variance function that differ by stratum, by name.
  std::vector<std::pair<std::string, Eigen::VectorXd>> strata_columns_;
  Task search_;
  Task fixed_;
};

}  // namespace silvafit::fit
