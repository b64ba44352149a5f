// SPDX-License-Identifier: MIT
// A nonlinear mixed model as the linear one that touches it at a point, in one pass over the data.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "lindstrom_bates/linear_mixed_profile.hpp"
#include "model/variance_weights.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Where to linearize; all in the coefficients' own units. The columns of X are those of J M, M
/// with ones on its diagonal, times the units.
struct LinearizationPoint {
  Eigen::VectorXd coefficients{};  ///< (p) fixed effects
  Eigen::MatrixXd effects{};   ///< (p x G) random effects of each group, zeros where there are none
  Eigen::VectorXd variance{};  ///< (m) internal parameters of the variance function
  Eigen::VectorXd units{};     ///< (p) what one unit of each column of X is worth
  /// (p x p) M; empty where it is the identity. A column with random effects is a combination of
  /// such columns alone.
  Eigen::MatrixXd mixing{};
};

/// The model around a point.
struct Linearization {
  /// w = X beta + Z b + e with X = the Jacobian in these units and beta the step from the point;
  /// the random effects are whole.
  LinearMixedModel model{};
  Eigen::VectorXd mean{};            ///< (N) f
  Eigen::ArrayXd weight{};           ///< (N) g^-2; empty for a constant variance
  Eigen::VectorXd squares{};         ///< (G) weighted residual squares
  Eigen::VectorXd squares_before{};  ///< (G) the same with the weights of an earlier point
  Eigen::VectorXd variance{};        ///< (m) at which the weights were taken
  Eigen::VectorXd longest_change{};  ///< (m) for which the series in the parameters is good
};

/// Computes linearizations of one model. Rows go through in blocks that stay in cache, from the
/// mean function to the cross products of each group; nothing as long as the data is kept but the
/// mean and the weights.
class Linearizer {
 public:
  Linearizer(const NonlinearModel& model, const VarianceModel& variance);

  /// \param expand  whether the weights' derivatives by the variance parameters are wanted
  /// \param before  weights of an earlier point, or null
  /// \returns false where something is not finite
  bool linearize(const LinearizationPoint& point,
                 bool expand,
                 const Linearization* before,
                 Linearization& result);

  /// Whether log g is not linear in the variance parameters.
  bool is_curved() const;

 private:
  /// Rows of one group that are processed together: all of them unless there are very many.
  struct Segment {
    Eigen::Index group = 0;
    Eigen::Index begin = 0;  ///< first row
    Eigen::Index end = 0;
    bool is_last = true;  ///< of its group
  };
  struct Parameter {
    bool is_scalar = false;
    std::vector<Eigen::Index> coefficients{};
  };
  /// A derivative of log g by two quantities, whose second derivative may be zero everywhere.
  struct QuantityPair {
    std::size_t first = 0;
    std::size_t second = 0;
    bool is_straight = false;
  };
  /// A term of the series of the weights: its internal parameters' places in the quantities.
  struct Term {
    int pair = -1;              ///< index into quantity_pairs_, -1 for a first derivative
    std::size_t quantity = 0;   ///< of a first derivative
    Eigen::Index stratum = -1;  ///< of the first quantity's rows, -1 for all rows
    Eigen::Index other_stratum = -1;
  };

  void make_segments();
  void make_parameters();
  void make_programs();
  void make_terms();
  const NonlinearModel::Strata* strata_of(std::size_t quantity) const;
  void fill_parameters(const LinearizationPoint& point, std::size_t first, std::size_t last);
  void fill_quantities(const LinearizationPoint& point, Eigen::Index begin, Eigen::Index rows);
  /// The column of df/d coefficient in the block at work.
  const double* slope_column(Eigen::Index coefficient) const;
  void evaluate_block(const LinearizationPoint& point,
                      bool expand,
                      std::size_t first,
                      std::size_t last,
                      Linearization& result);
  void add_segment(const Segment& segment,
                   Eigen::Index block_begin,
                   const LinearizationPoint& point,
                   bool expand,
                   const Linearization* before,
                   Linearization& result);
  void add_terms(const Segment& segment, Eigen::Index offset, Linearization& result);
  bool is_straight(const Term& term) const;
  /// The quantities by which a term is a derivative, the same one twice for a first derivative.
  std::pair<std::size_t, std::size_t> quantities_of(const Term& term) const;
  /// (rows) derivative of log g by a quantity.
  Eigen::Map<const Eigen::VectorXd> log_scale_slope(std::size_t quantity,
                                                    Eigen::Index offset,
                                                    Eigen::Index rows) const;
  /// Fills in what g^-2 changes by in a term.
  /// \returns the sum of that of log g
  /// \param second  output of the second derivative, of terms that are curved
  double fill_term(const Term& term,
                   const Segment& segment,
                   Eigen::Index offset,
                   Eigen::Index second,
                   const Linearization& result);
  /// Takes out the rows of other strata.
  /// \returns the sum of the rows that stay, nothing if there are none
  std::optional<double> mask_term(const Term& term,
                                  const Segment& segment,
                                  Eigen::Index offset,
                                  Eigen::Index second);
  /// Puts the combinations of a block's columns in their place.
  void mix(const Eigen::MatrixXd& mixing, Eigen::Index rows);
  void finish_group(Eigen::Index group, const LinearizationPoint& point, Linearization& result);
  /// How far the series reaches.
  void center(Linearization& result) const;
  void add_products(const double* weight, Eigen::Index rows, double* target);

  const NonlinearModel& model_;
  const VarianceModel& variance_;
  RandomColumns random_;
  std::vector<Eigen::Index> effect_columns_;  ///< of X with random effects at any level
  std::vector<Segment> segments_;
  std::vector<std::size_t> blocks_;  ///< first segment of each block, and the end
  std::vector<Parameter> parameters_;
  std::vector<QuantityPair> quantity_pairs_;
  std::vector<Term> terms_;  ///< of the series, in the order of GroupMoments less term 0
  std::vector<std::pair<Eigen::Index, Eigen::Index>> pairs_;
  std::array<data::Program, 2> programs_;  ///< without and with derivatives of log g

  // Scratch memory of a pass: columns of one block.
  Eigen::MatrixXd parameter_values_;
  Eigen::MatrixXd quantity_values_;
  Eigen::MatrixXd outputs_;   ///< mean, df/dphi; log g, weight; its derivatives
  Eigen::MatrixXd products_;  ///< df/d coefficient where that is not df/dphi
  Eigen::MatrixXd mixed_;     ///< (rows x p) columns of J M, where M is not the identity
  Eigen::VectorXd residual_;
  Eigen::VectorXd term_weight_;
  std::vector<const double*> columns_;
  std::vector<double> group_products_;
  Eigen::VectorXd log_squares_;  ///< by quantity
  data::Program::Workspace workspace_;
};

}  // namespace silvafit::fit
