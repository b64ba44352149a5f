// SPDX-License-Identifier: MIT
// Sums of the observations' terms over the rows of each group.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "conditional_modes/observation_terms.hpp"
#include "model/row_program.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/fit/matrices.hpp"

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

/// Sums over the rows of each group, from which the modes of random effects follow.
///
/// p coefficients, also those with random effects only, r random ones, o others; triangles are
/// lower ones by columns.
class GroupSums {
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
  };

  virtual ~GroupSums() = default;
  GroupSums(const GroupSums&) = delete;
  GroupSums& operator=(const GroupSums&) = delete;

  Index random_count() const { return static_cast<Index>(random_.size()); }
  const std::vector<Index>& random() const { return random_; }
  bool has_approximation() const { return has_approximation_; }
  bool holds_weights() const { return holds_weights_; }
  /// See ObservationTerms::others.
  const std::vector<Index>& others() const { return others_; }
  /// Number of the sums of density().
  Index density_count() const {
    const Index r = random_count();
    return 1 + r + r * (r + 1) / 2 * (has_approximation_ ? 2 : 1) + (holds_weights_ ? 1 : 0);
  }
  /// Of density (1), by_random (r), curvature (triangle), approximation (triangle, if any), with
  /// held weights then of density with a point's own ones (1), for groups [first, last): one column
  /// a group.
  /// \param effects  (r x G) random effects b of all groups
  /// \param weights  of these groups' rows at least; null unless holds_weights()
  virtual void density(Index first,
                       Index last,
                       const MatrixXd& effects,
                       MatrixXd& sums,
                       Workspace& workspace,
                       HeldWeights* weights = nullptr) const = 0;
  /// Of other_random (o r).
  virtual void mixed(Index first,
                     Index last,
                     const MatrixXd& effects,
                     MatrixXd& sums,
                     Workspace& workspace) const = 0;

 protected:
  explicit GroupSums(std::vector<Index> random) : random_(std::move(random)) {}

  bool has_approximation_ = false;
  bool holds_weights_ = false;
  std::vector<Index> others_;

 private:
  std::vector<Index> random_;
};

/// Which terms of ObservationTerms are summed, and where each is among a group's sums; m + 1
/// parameters of the variance.
class ObservationSums : public GroupSums {
 public:
  /// \param with_slopes  whether slopes() and total() are needed, which held weights do not have
  ObservationSums(const NonlinearModel& model,
                  const VarianceModel& variance,
                  Curvature curvature,
                  std::vector<Index> random,
                  bool with_slopes = true);

  /// Sets the point at which all sums are evaluated from now on.
  void set_point(const ObservationPoint& point);

  void density(Index first,
               Index last,
               const MatrixXd& effects,
               MatrixXd& sums,
               Workspace& workspace,
               HeldWeights* weights = nullptr) const override;
  void mixed(Index first,
             Index last,
             const MatrixXd& effects,
             MatrixXd& sums,
             Workspace& workspace) const override;
  /// Of density (1), density_by_fixed (p), density_by_variance (m + 1).
  void slopes(
      Index first, Index last, const MatrixXd& effects, MatrixXd& sums, Workspace& workspace) const;
  /// Of penalty_by_random (r), by_other (o), by_variance (m + 1), other_random (o r), and
  /// variance_random ((m + 1) r), for o other coefficients.
  /// \param weights  (triangle x last - first) the matrices M
  void total(Index first,
             Index last,
             const MatrixXd& effects,
             const MatrixXd& weights,
             MatrixXd& sums,
             Workspace& workspace) const;

 private:
  /// Where the values of a program's input come from.
  struct Source {
    enum class Kind { kScalar, kColumn, kParameter, kWeight, kHeld };
    Kind kind = Kind::kScalar;
    std::size_t index = 0;           ///< of the scalar, the parameter or the weight
    const double* column = nullptr;  ///< (N) of a column

    bool is_scalar() const { return kind == Kind::kScalar; }
  };
  using Task = RowProgram<Source>;
  /// A parameter of the model that varies by row.
  struct VaryingParameter {
    std::string name{};  ///< of the input
    Index parameter = 0;
    bool at_population = false;  ///< without random effects
  };

  Task task_of(const std::vector<data::Expression>& outputs);
  Source source_of(const std::string& name);
  Source parameter_source(const std::string& name, Index parameter, bool at_population);
  Source quantity_source(std::size_t quantity);
  void store_indicators();
  /// What differs by group.
  struct GroupValues {
    const MatrixXd& effects;            ///< (r x G)
    const MatrixXd* weights = nullptr;  ///< one column a group from the first on, or null
    Index first = 0;
    HeldWeights* held = nullptr;
    std::size_t weight_count() const {
      return weights == nullptr ? 0 : static_cast<std::size_t>(weights->rows());
    }
  };
  void run(const Task& task,
           const GroupValues& values,
           Index last,
           MatrixXd& sums,
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
  Index r_ = 0;
  std::vector<Index> effect_of_;  ///< (p) number of b of a coefficient, -1 for none
  std::vector<VaryingParameter> varying_;
  Task density_;
  Task mixed_;
  Task slopes_;
  Task total_;
  MatrixXd indicators_;  ///< (N x strata of all quantities)
  std::vector<Index> indicator_begin_;
  // Values at the current point.
  std::vector<double> scalars_;  ///< parameters, quantities, log sigma
  VectorXd beta_;                ///< (p)
  MatrixXd quantity_rows_;       ///< (N x quantities) if some have strata
};

}  // namespace silvafit::fit
