// SPDX-License-Identifier: MIT
// The linearization of a nonlinear mixed model at a point, in one pass over the data.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "likelihood/linear_mixed_profile.hpp"
#include "model/variance_weights.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The point of the linearization, in the coefficients' own units. The columns of X are those of
/// J M, M with ones on its diagonal, times the units.
struct LinearizationPoint {
  VectorXd coefficients{};  ///< (p) fixed effects, extended by those with effects only
  MatrixXd effects{};       ///< (p x G) random effects of each group, else zeros
  VectorXd variance{};      ///< (m) internal parameters of the variance function
  VectorXd units{};         ///< (p) the unit of each column of X
  /// (p x p) M; empty for the identity. A column with random effects is a combination of such
  /// columns only.
  MatrixXd mixing{};
  /// The groups whose sums are needed, those before the last one; the others' are zero.
  Index first_group = 0;
  Index last_group = std::numeric_limits<Index>::max();
};

/// The model around a point.
struct Linearization {
  /// w = X beta + Z b + e with X = the Jacobian in these units, beta the step from the point and b
  /// the random effects themselves.
  LinearMixedModel model{};
  VectorXd mean{};            ///< (N) f
  Eigen::ArrayXd weight{};    ///< (N) g^-2; empty for a constant variance
  VectorXd squares{};         ///< (G) weighted residual squares
  VectorXd squares_before{};  ///< (G) the same with the weights of an earlier point
  VectorXd variance{};        ///< (m) parameters of the weights
  VectorXd longest_change{};  ///< (m) range in which the series is accurate
};

/// Computes linearizations of one model. Rows are processed in blocks that fit into the cache, from
/// the mean function to the cross products of each group. Only the mean and the weights of all rows
/// are stored. Chunks of blocks are processed in parallel and their sums added in order.
class Linearizer {
 public:
  Linearizer(const NonlinearModel& model, const VarianceModel& variance);

  /// \param expand  whether to compute the weights' derivatives by the variance parameters
  /// \param before  weights of an earlier point, or null
  /// \returns false if a result is not finite
  bool linearize(const LinearizationPoint& point,
                 bool expand,
                 const Linearization* before,
                 Linearization& result);

  /// Whether the series of the weights is too inaccurate for a search: log g is not linear in the
  /// variance parameters, or the residuals are correlated, for which there is no series.
  bool is_curved() const;

 private:
  /// Rows of one group that are processed together: all of them unless there are very many.
  struct Segment {
    Index group = 0;
    Index begin = 0;  ///< first row
    Index end = 0;
    bool is_first = true;  ///< of its group
    bool is_last = true;
  };
  /// One linearization; see linearize().
  struct Pass {
    const LinearizationPoint& point;
    bool expand;
    const Linearization* before;
    Linearization& result;
  };
  /// Working memory: columns of one block.
  struct Scratch {
    MatrixXd parameter_values{};
    MatrixXd quantity_values{};
    MatrixXd outputs{};   ///< mean, df/dphi; log g, weight; its derivatives
    MatrixXd products{};  ///< df/d coefficient where that is not df/dphi
    MatrixXd mixed{};     ///< (rows x p) columns of J M, where M is not the identity
    VectorXd residual{};
    VectorXd term_weight{};
    std::vector<const double*> columns{};
    std::vector<double> group_products{};
    data::Program::Workspace workspace{};
  };
  /// Contribution of a chunk of rows to sums over all rows, and to a group that begins in an
  /// earlier chunk.
  struct ChunkSums {
    VectorXd sum_log{};             ///< as GroupMoments::sum_log
    VectorXd log_squares{};         ///< by quantity
    std::vector<double> carried{};  ///< (terms x width x width) of that group, empty without one
    double carried_before = 0.0;    ///< of its squares_before
    std::vector<double> open{};     ///< the same of a group that ends in a later chunk
    MatrixXd totals{};              ///< (width^2 x terms) of groups without all their rows
  };
  /// A second derivative of log g by two quantities, which may be zero everywhere.
  struct QuantityPair {
    std::size_t first = 0;
    std::size_t second = 0;
    bool is_linear = false;
  };
  /// A term of the series of the weights: the indices of its internal parameters in the quantities.
  struct Term {
    int pair = -1;             ///< index into quantity_pairs_, -1 for a first derivative
    std::size_t quantity = 0;  ///< of a first derivative
    Index stratum = -1;        ///< of the first quantity's rows, -1 for all rows
    Index other_stratum = -1;
  };

  void make_segments();
  void make_parameters();
  void make_programs();
  void make_terms();
  const NonlinearModel::Strata* strata_of(std::size_t quantity) const;
  void prepare(Scratch& scratch) const;
  void fill_parameters(const LinearizationPoint& point,
                       std::size_t first,
                       std::size_t last,
                       Scratch& scratch) const;
  void fill_quantities(const LinearizationPoint& point,
                       Index begin,
                       Index rows,
                       Scratch& scratch) const;
  /// The column of df/d coefficient in the current block.
  const double* slope_column(Index coefficient, const Scratch& scratch) const;
  void linearize_chunk(const Pass& pass,
                       std::size_t chunk,
                       Scratch& scratch,
                       ChunkSums& sums) const;
  void evaluate_block(const Pass& pass,
                      std::size_t first,
                      std::size_t last,
                      Scratch& scratch) const;
  /// \param products  (terms x width x width) of the segment's group
  /// \param squares_before  of it
  void add_segment(const Pass& pass,
                   const Segment& segment,
                   Index block_begin,
                   Scratch& scratch,
                   double* products,
                   double& squares_before,
                   ChunkSums& sums) const;
  void add_terms(const Pass& pass,
                 const Segment& segment,
                 Index offset,
                 Scratch& scratch,
                 double* products,
                 ChunkSums& sums) const;
  /// Adds the parts of groups that extend over several chunks.
  void add_carried(const Pass& pass, std::vector<ChunkSums>& chunks) const;
  bool is_linear(const Term& term) const;
  /// The quantities of a term's derivative, the same one twice for a first derivative.
  std::pair<std::size_t, std::size_t> quantities_of(const Term& term) const;
  /// (rows) derivative of log g by a quantity.
  Eigen::Map<const VectorXd> log_scale_slope(std::size_t quantity,
                                             Index offset,
                                             Index rows,
                                             const Scratch& scratch) const;
  /// Computes the change of g^-2 in a term.
  /// \returns the sum of the changes of log g
  /// \param second  output of the second derivative, of terms that are curved
  double fill_term(const Term& term,
                   const Segment& segment,
                   Index offset,
                   Index second,
                   Scratch& scratch,
                   const Linearization& result) const;
  /// Sets the rows of other strata to zero.
  /// \returns the sum of the remaining rows, no value if there are none
  std::optional<double> mask_term(
      const Term& term, const Segment& segment, Index offset, Index second, Scratch& scratch) const;
  /// Replaces the columns of a block by their combinations.
  void mix(const MatrixXd& mixing, Index rows, Scratch& scratch) const;
  /// Correlated residuals, in linearization_correlated.cpp: keeps the rows of a segment, divided by
  /// g, and sums up the products of all groups from these.
  void keep_rows(const Pass& pass,
                 const Segment& segment,
                 Index offset,
                 const Scratch& scratch) const;
  /// Which of the kept factors are those of some parameters; else they take the place `free`.
  std::size_t kept_factors(const VectorXd& parameters, std::size_t free);
  bool add_correlated(const Pass& pass);
  void add_correlated_group(const Pass& pass, Index group, VectorXd& sum_log) const;
  /// (n x m) the derivatives of log g of some rows by the parameters of g.
  MatrixXd scale_slopes(const std::vector<Index>& rows) const;
  /// Converts the products of a whole group to those of the linear model.
  /// \param products  (width x width x terms)
  void finish_group(const Pass& pass, Index group, double* products) const;
  /// The same, and keeps them.
  void close_group(const Pass& pass, Index group, ChunkSums& sums) const;
  /// The range in which the series is accurate.
  void center(const VectorXd& log_squares, Linearization& result) const;
  static void add_products(const double* weight, Index rows, Scratch& scratch, double* target);

  const NonlinearModel& model_;
  const VarianceModel& variance_;
  RandomColumns random_;
  std::vector<Index> effect_columns_;  ///< of X with random effects at any level
  std::vector<Segment> segments_;
  std::vector<std::size_t> blocks_;  ///< first segment of each block, and the end
  std::vector<std::size_t> chunks_;  ///< first block of each chunk, and the end
  std::vector<bool> is_scalar_;      ///< of each parameter
  std::vector<QuantityPair> quantity_pairs_;
  std::vector<Term> terms_;  ///< of the series, in the order of GroupMoments less term 0
  std::vector<std::pair<Index, Index>> pairs_;
  std::array<data::Program, 2> programs_;  ///< without and with derivatives of log g

  std::size_t output_count_ = 0;
  std::vector<Scratch> scratch_;  ///< by worker
  /// L of each block at some correlation parameters: those of a linearization, and of the one
  /// before it.
  struct KeptFactors {
    VectorXd parameters{};
    CorrelatedRows::Factors factors{};
  };
  std::array<KeptFactors, 2> factors_;
  std::size_t factors_now_ = 0;  ///< which of them are those of this linearization
  std::size_t factors_before_ = 0;
  mutable MatrixXd kept_rows_;    ///< (N x (p + 1)) columns and residuals, divided by g
  mutable MatrixXd kept_slopes_;  ///< (N x quantities) derivatives of log g
};

}  // namespace silvafit::fit
