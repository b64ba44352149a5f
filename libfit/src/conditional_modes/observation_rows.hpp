// SPDX-License-Identifier: MIT
// Values of expressions at the rows of groups, for coefficients that vary by group.
#pragma once

#include <string>
#include <vector>

#include "model/row_program.hpp"
#include "model/variance_weights.hpp"
#include "silvafit/data/expression.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The point of evaluation: fixed effects, internal parameters of the variance, log sigma.
struct ObservationPoint {
  VectorXd beta{};      ///< (p) extended by those with random effects only
  VectorXd variance{};  ///< (m)
  double log_sigma = 0.0;
};

/// Weights 1/(sigma g)^2 of consecutive rows that are held while the effects change.
struct HeldWeights {
  Index first_row = 0;
  VectorXd held{};  ///< used to evaluate rho
  VectorXd own{};   ///< of the point of the last evaluation
};

/// The expressions of ObservationTerms, whose variables are parameters, columns and the names of
/// term_names, at the rows of groups.
class ObservationRows {
 public:
  /// Scratch memory of one caller.
  struct Workspace {
    data::Program::Workspace program{};
    std::vector<double> inputs{};
    std::vector<double> outputs{};
    std::vector<double> sums{};
    std::vector<std::size_t> begins{};
    std::vector<const double*> input_columns{};
    std::vector<double*> output_columns{};
    MatrixXd states{};    ///< of correlated rows
    MatrixXd adjoints{};  ///< see term_names::adjoint
    MatrixXd of_rows{};   ///< sums without those between rows
  };
  /// What differs by group, for groups from the first on.
  struct GroupValues {
    const MatrixXd& effects;            ///< (r x G)
    const MatrixXd* weights = nullptr;  ///< one column a group, or null
    Index first = 0;
    HeldWeights* held = nullptr;         ///< or null
    const MatrixXd* adjoints = nullptr;  ///< (rows of the groups x adjoints), or null
    std::size_t weight_count() const {
      return weights == nullptr ? 0 : static_cast<std::size_t>(weights->rows());
    }
  };
  /// Where the values of a program's input come from.
  struct Source {
    enum class Kind { kScalar, kColumn, kParameter, kWeight, kHeld, kAdjoint };
    Kind kind = Kind::kScalar;
    std::size_t index = 0;           ///< of the scalar, the parameter, the weight or the adjoint
    const double* column = nullptr;  ///< (N) of a column

    bool is_scalar() const { return kind == Kind::kScalar; }
  };
  using Task = RowProgram<Source>;

  /// \param random  coefficients with random effects in any grouping, ascending
  ObservationRows(const NonlinearModel& model,
                  const VarianceModel& variance,
                  const std::vector<Index>& random);
  ObservationRows(const ObservationRows&) = delete;
  ObservationRows& operator=(const ObservationRows&) = delete;

  /// Sets the point at which all values are computed from now on.
  void set_point(const ObservationPoint& point);
  Task task_of(const std::vector<data::Expression>& outputs);
  /// Sums over the rows of each group in [values.first, last), one column a group. With held
  /// weights the last output is not summed, but stored as the rows' own weights.
  void sum(const Task& task,
           const GroupValues& values,
           Index last,
           MatrixXd& sums,
           Workspace& workspace) const;
  /// The values at each row of these groups, one column an output.
  void fill(const Task& task,
            const GroupValues& values,
            Index last,
            MatrixXd& rows,
            Workspace& workspace) const;

 private:
  /// A parameter of the model that varies by row.
  struct VaryingParameter {
    std::string name{};  ///< of the input
    Index parameter = 0;
    bool at_population = false;  ///< without random effects
  };

  Source source_of(const std::string& name);
  Source parameter_source(const std::string& name, Index parameter, bool at_population);
  Source quantity_source(std::size_t quantity);
  void store_indicators();
  void reserve(const Task& task, const GroupValues& values, Workspace& workspace) const;
  Index evaluate(const Task& task,
                 const GroupValues& values,
                 Index group,
                 Index row,
                 Index rows,
                 Workspace& workspace) const;
  Index fill_rows(
      const GroupValues& values, Index group, Index row, Index rows, Workspace& workspace) const;
  void connect_inputs(const Task& task,
                      const GroupValues& values,
                      Index row,
                      Workspace& workspace) const;
  void fill_parameter(const VaryingParameter& varying,
                      const MatrixXd& effects,
                      Index group,
                      Index row,
                      Index rows,
                      double* target) const;

  const NonlinearModel& model_;
  const VarianceModel& variance_;
  std::size_t r_ = 0;
  std::vector<Index> effect_of_;  ///< (p) number of b of a coefficient, -1 for none
  std::vector<VaryingParameter> varying_;
  MatrixXd indicators_;  ///< (N x strata of all quantities)
  std::vector<Index> indicator_begin_;
  // Values at the current point.
  std::vector<double> scalars_;  ///< parameters, quantities, log sigma
  VectorXd beta_;                ///< (p)
  MatrixXd quantity_rows_;       ///< (N x quantities) if some have strata
};

}  // namespace silvafit::fit
