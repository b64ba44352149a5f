// SPDX-License-Identifier: MIT
// Sums of the observations' terms over the rows of each group.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "conditional_modes/observation_rows.hpp"
#include "conditional_modes/observation_terms.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Sums of the density of the data of each group, from which the modes of random effects follow.
///
/// p coefficients, also those with random effects only, r random ones, o others; triangles are
/// lower ones by columns.
class DensitySums {
 public:
  using Workspace = ObservationRows::Workspace;

  virtual ~DensitySums() = default;
  DensitySums(const DensitySums&) = delete;
  DensitySums& operator=(const DensitySums&) = delete;

  Index random_count() const { return static_cast<Index>(random_.size()); }
  const std::vector<Index>& random() const { return random_; }
  bool has_approximation() const { return has_approximation_; }
  bool holds_weights() const { return holds_weights_; }
  /// Whether the mean may not be smooth in the random effects.
  bool has_kinks() const { return has_kinks_; }
  /// See ObservationTerms::others.
  const std::vector<Index>& others() const { return others_; }
  /// Number of the sums of density().
  Index density_count() const {
    const Index r = random_count();
    return 1 + r + r * (r + 1) / 2 * (has_approximation_ ? 2 : 1) + (holds_weights_ ? 1 : 0);
  }

  /// First row of a group; that after the last group is the number of rows.
  virtual Index row_begin(Index group) const = 0;
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
  explicit DensitySums(std::vector<Index> random) : random_(std::move(random)) {}

  bool has_approximation_ = false;
  bool holds_weights_ = false;
  bool has_kinks_ = false;
  std::vector<Index> others_;

 private:
  std::vector<Index> random_;
};

/// The sums of a model, from which also its likelihood and its gradient follow; with m + 1
/// parameters of the residuals' distribution: those of the variance function and of the
/// correlation, log sigma.
class GroupSums : public DensitySums {
 public:
  Index row_begin(Index group) const override { return model_.group_begin(group); }
  /// Sets the point at which all sums are evaluated from now on.
  virtual void set_point(const ObservationPoint& point) = 0;
  /// Of density (1), density_by_fixed (p), density_by_variance (m + 1).
  virtual void slopes(Index first,
                      Index last,
                      const MatrixXd& effects,
                      MatrixXd& sums,
                      Workspace& workspace) const = 0;
  /// Of penalty_by_random (r), by_other (o), by_variance (m + 1), other_random (o r), and
  /// variance_random ((m + 1) r), for o other coefficients.
  /// \param weights  (triangle x last - first) the matrices M
  virtual void total(Index first,
                     Index last,
                     const MatrixXd& effects,
                     const MatrixXd& weights,
                     MatrixXd& sums,
                     Workspace& workspace) const = 0;

 protected:
  /// \param model  outlives this object
  GroupSums(const NonlinearModel& model, const std::vector<Index>& random);

  const NonlinearModel& model_;
};

/// The sums of a model; those of correlated residuals if its variance model has a correlation.
/// \param with_slopes  whether slopes() and total() are needed, which held weights do not have
std::unique_ptr<GroupSums> make_group_sums(const NonlinearModel& model,
                                           const VarianceModel& variance,
                                           Curvature curvature,
                                           const std::vector<Index>& random,
                                           bool with_slopes = true);

/// The programs of ObservationTerms.
struct TermTasks {
  TermTasks(const ObservationTerms& terms, bool with_slopes, ObservationRows& rows);

  ObservationRows::Task density{};
  ObservationRows::Task mixed{};
  ObservationRows::Task slopes{};
  ObservationRows::Task total{};
};

}  // namespace silvafit::fit
