// SPDX-License-Identifier: MIT
// A model with data: complete rows, sorted by group, and the mean with its derivatives.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/base/stop.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/model_specification.hpp"
#include "silvafit/fit/parameter_design.hpp"

namespace silvafit::fit {

struct ModelGroups;

/// The mean function f(phi; data) of a model on the rows of a table, with phi linear in the
/// coefficients.
///
/// N observations, p coefficients, G groups. Rows without response, a column of the formula, a
/// covariate, a stratum or the group are skipped. Rows are sorted by group (groups in the order of
/// their first appearance, rows within a group in file order); without random effects all rows are
/// one group. With two nested terms the groups are those of the second, distinguished within
/// each group of the first and sorted by it; with crossed terms they are cells, rows that are in
/// the same group of every term. Immutable; evaluate() may run on several
/// threads, each with its own Workspace.
///
/// Computations with a model may use several threads; results do not depend on their number.
class NonlinearModel {
 public:
  /// Working memory of one caller.
  struct Workspace {
    data::Program::Workspace program{};
    Eigen::MatrixXd parameters{};   ///< (rows x K) parameter values of a block of rows
    Eigen::MatrixXd derivatives{};  ///< (rows x K) df/dphi
  };

  /// \param threads  number of threads; 0: all cores
  /// \param stop     stops computations with the model; see check_stop()
  /// \throws UsageError if a column is missing, or if a group has more than 12 random effects over
  ///   both groupings; InputError if there is no complete row, or a column of the data has an
  ///   infinite value
  NonlinearModel(ModelSpecification specification,
                 const data::Table& table,
                 unsigned threads = 1,
                 std::stop_token stop = {});

  const ModelSpecification& specification() const { return specification_; }
  unsigned threads() const { return threads_; }
  /// Called before each pass over the data, which all searches consist of.
  /// \throws Stopped if the caller has requested it
  void check_stop() const { silvafit::check_stop(stop_); }
  Eigen::Index observations() const { return response_.size(); }
  Eigen::Index coefficient_count() const { return static_cast<Eigen::Index>(names_.size()); }
  const std::vector<std::string>& coefficient_names() const { return names_; }
  /// Number of coefficients with those that have random effects only, which are the last.
  Eigen::Index column_count() const { return design_.coefficient_count(); }
  /// (column_count()) coefficients, followed by the zero means of those with random effects only.
  Eigen::VectorXd extended(const Eigen::VectorXd& coefficients) const;
  /// Position of a coefficient, also of those with random effects only.
  /// \throws UsageError if there is no coefficient of that name
  Eigen::Index coefficient_index(std::string_view name) const;

  /// Positions of the coefficients that have random effects in a term.
  /// \throws UsageError if one is not a coefficient of the model
  std::vector<Eigen::Index> coefficients_of(const RandomEffects& term) const;
  /// The same of all terms, in their order.
  std::vector<std::vector<Eigen::Index>> random_coefficients() const;

  /// (N) the response, in model order.
  const Eigen::VectorXd& response() const { return response_; }
  /// (N) the table's row of each observation.
  const std::vector<std::size_t>& rows() const { return rows_; }
  std::size_t excluded() const { return excluded_; }
  /// Labels of each column that the mean compares with text, in alphabetical order; for part()
  /// those of the whole model.
  const std::map<std::string, std::set<std::string>>& levels() const { return levels_; }

  Eigen::Index group_count() const { return static_cast<Eigen::Index>(group_labels_.size()); }
  const std::vector<std::string>& group_labels() const { return group_labels_; }
  /// First observation of group g; group_begin(group_count()) is N.
  Eigen::Index group_begin(Eigen::Index group) const { return group_begin_[group]; }

  /// Number of independent clusters: the groups of the first term, or with crossed terms sets of
  /// cells that no group connects to others.
  Eigen::Index cluster_count() const;
  /// First group of a cluster; cluster_begin(cluster_count()) is G.
  Eigen::Index cluster_begin(Eigen::Index cluster) const;

  /// Number of terms of random effects. The groups of each consist of groups of the next, those of
  /// the last are the model's groups; unless they are crossed.
  std::size_t term_count() const { return specification_.random.size(); }
  const ModelGroups& groups() const { return *groups_; }
  /// The groups of crossed terms, or null.
  const ModelGroups* crossed() const;
  Eigen::Index group_count(std::size_t term) const {
    return static_cast<Eigen::Index>(group_labels(term).size());
  }
  const std::vector<std::string>& group_labels(std::size_t term) const;
  /// First of the model's groups in group k of a term, not crossed.
  Eigen::Index first_group(std::size_t term, Eigen::Index k) const {
    return is_last(term) ? k : cluster_begin(k);
  }
  /// The group of a term that one of the model's groups is in.
  Eigen::Index group_of(std::size_t term, Eigen::Index group) const;

  /// (N) a numeric column of the data in model order that the model uses.
  /// \throws UsageError if the model does not use it
  Eigen::VectorXd column(std::string_view name) const;

  /// The strata of a column that the variance function names, or the groups of the correlation.
  struct Strata {
    std::string column{};
    std::vector<std::string> labels{};    ///< (S)
    std::vector<Eigen::Index> of_rows{};  ///< (N) number of each observation's stratum
  };
  /// \throws UsageError if the variance function does not use the column
  const Strata& strata(std::string_view column) const;

  /// The columns of the data that the model reads as numbers, and their values.
  const std::vector<std::string>& variables() const { return variables_; }
  const Eigen::MatrixXd& variable_values() const { return columns_; }  ///< (N x variables)

  /// How the parameters follow from the coefficients.
  const ParameterDesign& design() const { return design_; }

  /// The mean and, unless null, its Jacobian in the coefficients.
  /// \param coefficients  (p) the same for all groups, or (p x G) by group; p or column_count()
  /// \param mean          (N) result
  /// \param jacobian      (N x p) result: df/d coefficient, for the rows of `coefficients`
  void evaluate(const Eigen::Ref<const Eigen::MatrixXd>& coefficients,
                Eigen::VectorXd& mean,
                Eigen::MatrixXd* jacobian,
                Workspace& workspace) const;
  /// The same for a single call.
  Eigen::VectorXd mean_at(const Eigen::Ref<const Eigen::MatrixXd>& coefficients) const;
  struct Curve {
    Eigen::VectorXd mean{};
    Eigen::MatrixXd jacobian{};
  };
  Curve curve_at(const Eigen::Ref<const Eigen::MatrixXd>& coefficients) const;

  /// True if the second derivative of f by the coefficients (i, j) is zero for all data: a
  /// coefficient with (j, j) zero enters linearly, and two such enter jointly linearly if (i, j) is
  /// zero.
  bool is_bilinear(Eigen::Index i, Eigen::Index j) const;
  /// Whether the mean is linear in all coefficients together.
  bool is_linear() const;

  /// Whether abs, min, a comparison or the like depends on the parameter of a coefficient, so that
  /// the mean may not be smooth in it.
  bool has_kink_in(Eigen::Index coefficient) const;
  /// Names of the coefficients for which this holds.
  std::vector<std::string> kinks() const;
  /// Those of them without and with random effects.
  std::vector<std::string> fixed_kinks() const;
  std::vector<std::string> random_kinks() const;

  /// The same model on some of the observations.
  /// \param observations  in ascending order, at least one
  NonlinearModel subset(const std::vector<Eigen::Index>& observations) const;

  /// The model without covariates: each parameter is one coefficient of the same name.
  NonlinearModel pooled() const;

  /// The model without covariates and random effects, with some parameters held at a value.
  /// \param held  values by parameter, not of all of them
  /// \throws UsageError if a name is unknown or a value is not finite
  NonlinearModel with_held(const std::map<std::string, double>& held) const;

  /// The model without covariates with another response and mean, which may use no further columns
  /// or parameters.
  /// \param response  (N)
  NonlinearModel with_equation(data::Expression mean, Eigen::VectorXd response) const;

  /// The model with fewer random effects.
  /// \param terms  of the same groupings, or none: all rows are then one group
  NonlinearModel with_random_effects(std::vector<RandomEffects> terms) const;

  /// The same model without correlation of the residuals.
  NonlinearModel with_independent_residuals() const;

  /// The source of an observation: file and line, if the table has them.
  Place place(Eigen::Index observation) const;

 private:
  bool is_last(std::size_t term) const { return term + 1 == term_count(); }
  void choose_rows(const data::Table& table);
  /// Those of the current rows.
  void take_groups(ModelGroups groups);
  void load_columns(const data::Table& table);
  void load_levels(const data::Table& table);
  void load_strata(const data::Table& table);
  void compile();
  void fill_parameters(const Eigen::Ref<const Eigen::MatrixXd>& coefficients,
                       Eigen::Index begin,
                       Eigen::Index end,
                       Eigen::MatrixXd& parameters) const;
  void evaluate_rows(const Eigen::Ref<const Eigen::MatrixXd>& coefficients,
                     Eigen::Index begin,
                     Eigen::Index rows,
                     Eigen::VectorXd& mean,
                     Eigen::MatrixXd* jacobian,
                     Workspace& workspace) const;

  ModelSpecification specification_;
  unsigned threads_ = 1;
  std::stop_token stop_;
  std::vector<std::string> names_;
  std::string file_;
  std::vector<std::size_t> rows_;
  std::vector<std::uint32_t> lines_;  ///< (N) of the file, 0 if unknown
  std::size_t excluded_ = 0;
  std::map<std::string, std::set<std::string>> levels_;
  std::vector<std::string> group_labels_;
  std::vector<Eigen::Index> group_begin_;
  std::shared_ptr<const ModelGroups> groups_;
  std::vector<Strata> strata_;
  Eigen::VectorXd response_;
  std::vector<std::string> variables_;  ///< data columns of the formula
  Eigen::MatrixXd columns_;             ///< (N x variables)
  ParameterDesign design_;
  data::Program mean_program_;      ///< f
  data::Program gradient_program_;  ///< f, df/dphi_1 .. df/dphi_K
  std::vector<std::vector<bool>> parameter_bilinear_;
  std::vector<bool> parameter_has_kink_;
};

}  // namespace silvafit::fit
