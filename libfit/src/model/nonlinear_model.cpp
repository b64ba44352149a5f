// SPDX-License-Identifier: MIT
#include "silvafit/fit/nonlinear_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "model/held_coefficients.hpp"
#include "model/model_groups.hpp"
#include "model/small_matrix.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "silvafit/data/checked_columns.hpp"

namespace silvafit::fit {
namespace {

/// All variables of the data that the model reads, except the group; the response is the first.
std::vector<std::string> data_variables(const ModelSpecification& specification) {
  std::vector<std::string> names{specification.formula.left};
  const auto add = [&names](const std::string& name) {
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  };
  for (const std::string& name : specification.predictors()) add(name);
  for (const VarianceFactor& factor : specification.variance.factors) {
    if (!factor.column.empty()) add(factor.column);
  }
  if (specification.correlation) {
    for (const std::string& name : specification.correlation->columns) add(name);
  }
  return names;
}

/// Whether only the correlation of the residuals reads a column: a row without a time or a position
/// is an error, not a row to leave out (correlated_rows.cpp).
bool is_only_of_correlation(const std::string& name, ModelSpecification specification) {
  specification.correlation.reset();
  const std::vector<std::string> others = data_variables(specification);
  return std::ranges::find(others, name) == others.end();
}

void check_finite(const std::vector<double>& values,
                  const std::string& name,
                  const data::Table& table) {
  const auto found = std::ranges::find_if(values, [](double value) { return std::isinf(value); });
  if (found == values.end()) return;
  const auto row = static_cast<std::size_t>(found - values.begin());
  throw InputError("the value is not finite", data::place_of(table, row, name));
}

/// Checks that squares of values and products of two columns neither overflow nor underflow.
void check_size(const std::vector<double>& values,
                const std::string& name,
                const data::Table& table) {
  constexpr double kLargest = 1e140;
  double largest = 0.0;
  for (const double value : values) {
    if (std::abs(value) > largest) largest = std::abs(value);
  }
  if (largest == 0.0 || (largest <= kLargest && largest >= 1.0 / kLargest)) return;
  throw InputError(
      fmt::format("the largest absolute value is {:.2g}, so that squares {}; use another unit",
                  largest,
                  largest > 1.0 ? "overflow" : "are zero"),
      {.file = table.file(), .column = name});
}

VectorXd gathered(const std::vector<double>& values, const std::vector<std::size_t>& rows) {
  VectorXd result(static_cast<Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) result[static_cast<Index>(i)] = values[rows[i]];
  return result;
}

/// Rows in which a variable of the mean is zero.
std::vector<Index> rows_with_zeros(const data::Expression& mean,
                                   const std::vector<std::string>& variables,
                                   const MatrixXd& columns) {
  const std::vector<std::string> used = mean.variables();
  std::vector<bool> has_zero(static_cast<std::size_t>(columns.rows()), false);
  for (std::size_t k = 0; k < variables.size(); ++k) {
    if (std::ranges::find(used, variables[k]) == used.end()) continue;
    for (Index row = 0; row < columns.rows(); ++row) {
      if (columns(row, static_cast<Index>(k)) == 0.0)
        has_zero[static_cast<std::size_t>(row)] = true;
    }
  }
  std::vector<Index> rows;
  for (std::size_t row = 0; row < has_zero.size(); ++row) {
    if (has_zero[row]) rows.push_back(static_cast<Index>(row));
  }
  return rows;
}

// The change of all parameters, in a direction; a name that no formula can have.
constexpr const char* kChange = "change of all parameters";

/// The mean and its derivatives to the third order, the highest that a likelihood needs: the first
/// by each parameter, the others in the direction of all parameters.
std::vector<data::Expression> with_derivatives(const ModelSpecification& specification) {
  data::Expression moved = specification.formula.right;
  std::vector<data::Expression> result{moved};
  for (const ParameterModel& parameter : specification.parameters) {
    result.push_back(specification.formula.right.derivative(parameter.name));
    moved = moved.substitute(
        parameter.name,
        data::Expression::variable(parameter.name) + data::Expression::variable(kChange));
  }
  data::Expression along = moved.derivative(kChange);
  for (int order = 2; order <= 3; ++order) {
    along = along.derivative(kChange);
    result.push_back(along);
  }
  return result;
}

/// Whether a variable is zero where the mean is finite but one of its derivatives is zero times
/// infinity, as those of (x/a)^b and of log(x) inside exp().
/// \param columns  (N x k) values of the variables of the formula
bool has_edge(const ModelSpecification& specification,
              const std::vector<std::string>& variables,
              const MatrixXd& columns) {
  const std::vector<Index> rows = rows_with_zeros(specification.formula.right, variables, columns);
  if (rows.empty()) return false;
  const MatrixXd values = columns(rows, Eigen::all);
  const std::vector<data::Expression> outputs = with_derivatives(specification);
  std::vector<data::Program::Input> inputs{{.name = kChange, .is_scalar = true}};
  for (const ParameterModel& of : specification.parameters) inputs.push_back({of.name, true});
  for (const std::string& name : variables) inputs.push_back({.name = name});
  const data::Program program(outputs, inputs);
  MatrixXd results(values.rows(), static_cast<Index>(outputs.size()));
  std::vector<double*> targets;
  for (Index k = 0; k < results.cols(); ++k) targets.push_back(results.col(k).data());
  data::Program::Workspace workspace;
  const double change = 0.0;
  // The side from which the limit is approached depends on the signs of the parameters.
  for (const double parameter : {1.0, 0.5, -1.0}) {
    std::vector<const double*> sources{&change};
    sources.resize(1 + specification.parameters.size(), &parameter);
    for (Index k = 0; k < values.cols(); ++k) sources.push_back(values.col(k).data());
    program.evaluate(sources, rows.size(), targets, workspace);
    for (Index row = 0; row < results.rows(); ++row) {
      if (std::isfinite(results(row, 0)) && results.row(row).hasNaN()) return true;
    }
  }
  return false;
}

/// Columns whose values are the strata of the variance function, or the groups of the correlation.
std::vector<std::string> strata_columns(const ModelSpecification& specification) {
  std::vector<std::string> names;
  for (const VarianceFactor& factor : specification.variance.factors) {
    if (factor.stratum.empty() || std::ranges::find(names, factor.stratum) != names.end()) continue;
    names.push_back(factor.stratum);
  }
  if (specification.correlation && !specification.correlation->group.empty() &&
      std::ranges::find(names, specification.correlation->group) == names.end()) {
    names.push_back(specification.correlation->group);
  }
  return names;
}

/// Each stratum has its own variance parameters, and the time of a fit is proportional to the
/// square of their number.
void require_few_strata(const NonlinearModel::Strata& strata, const Place& place) {
  constexpr std::size_t kMostStrata = 100;
  if (strata.labels.size() <= kMostStrata) return;
  throw InputError(
      fmt::format("has {} values in {} rows; the variance function can have at most {} strata. Use "
                  "a coarser column, or a function of the fitted value such as power",
                  strata.labels.size(),
                  strata.of_rows.size(),
                  kMostStrata),
      place);
}

void check_effect_count(const ModelSpecification& specification) {
  std::size_t effects = 0;
  for (const RandomEffects& term : specification.random) effects += term.coefficients.size();
  if (effects <= kMostRandomEffects) return;
  throw UsageError(fmt::format("there are {} random effects per group; at most {} can be fitted",
                               effects,
                               kMostRandomEffects));
}

}  // namespace

NonlinearModel::NonlinearModel(ModelSpecification specification,
                               const data::Table& table,
                               unsigned threads,
                               std::stop_token stop)
    : specification_(std::move(specification)),
      threads_(threads),
      stop_(std::move(stop)),
      names_(specification_.coefficient_names()) {
  check_effect_count(specification_);
  choose_rows(table);
  load_columns(table);
  load_levels(table);
  design_ = ParameterDesign(specification_.parameters, table, rows_);
  load_strata(table);
  if (has_edge(specification_, variables_, columns_)) {
    specification_.formula.right = specification_.formula.right.with_limits();
  }
  compile();
}

void NonlinearModel::choose_rows(const data::Table& table) {
  std::vector<bool> complete(table.rows(), true);
  for (const std::string& name : data_variables(specification_)) {
    const std::vector<double> values = data::variable_values(name, table);
    check_finite(values, name, table);
    check_size(values, name, table);
    if (is_only_of_correlation(name, specification_)) continue;
    for (std::size_t row = 0; row < values.size(); ++row) {
      if (std::isnan(values[row])) complete[row] = false;
    }
  }
  for (const std::string& name : strata_columns(specification_)) {
    const data::TextColumn labels = table.labels(name);
    for (std::size_t row = 0; row < complete.size(); ++row) {
      if (labels.is_missing(row)) complete[row] = false;
    }
  }
  file_ = table.file();
  CellRows cells = cell_rows(specification_, table, complete);
  rows_ = std::move(cells.rows);
  group_begin_ = std::move(cells.cell_begin);
  take_groups(std::move(cells.groups));
  lines_.reserve(rows_.size());
  for (const std::size_t row : rows_) {
    lines_.push_back(static_cast<std::uint32_t>(table.line(row)));
  }
  excluded_ = table.rows() - rows_.size();
  if (rows_.empty()) {
    throw InputError(fmt::format("no row has values in all of the columns {}",
                                 fmt::join(data_variables(specification_), ", ")),
                     {.file = table.file()});
  }
}

void NonlinearModel::take_groups(ModelGroups groups) {
  group_labels_.clear();
  for (Index cell = 0; cell + 1 < std::ssize(group_begin_); ++cell) {
    group_labels_.push_back(groups.cell_label(cell));
  }
  groups_ = std::make_shared<const ModelGroups>(std::move(groups));
}

const ModelGroups* NonlinearModel::crossed() const {
  return groups_->is_crossed ? groups_.get() : nullptr;
}

const std::vector<std::string>& NonlinearModel::group_labels(std::size_t term) const {
  return groups_->labels[term];
}

void NonlinearModel::load_strata(const data::Table& table) {
  for (const std::string& column : strata_columns(specification_)) {
    const data::TextColumn labels = table.labels(column);
    Strata strata{.column = column};
    std::vector<Index> number(labels.levels().size(), -1);
    for (const std::size_t row : rows_) {
      Index& code = number[labels.code(row)];
      if (code < 0) {
        code = static_cast<Index>(strata.labels.size());
        strata.labels.emplace_back(labels[row]);
      }
      strata.of_rows.push_back(code);
    }
    const bool is_variance =
        std::ranges::any_of(specification_.variance.factors,
                            [&](const VarianceFactor& factor) { return factor.stratum == column; });
    if (is_variance) require_few_strata(strata, {.file = file_, .column = column});
    strata_.push_back(std::move(strata));
  }
}

void NonlinearModel::load_columns(const data::Table& table) {
  variables_ = data_variables(specification_);
  const auto n = static_cast<Index>(rows_.size());
  columns_.resize(n, static_cast<Index>(variables_.size()));
  for (std::size_t k = 0; k < variables_.size(); ++k) {
    columns_.col(static_cast<Index>(k)) =
        gathered(data::variable_values(variables_[k], table), rows_);
  }
  response_ = columns_.col(0);
}

void NonlinearModel::load_levels(const data::Table& table) {
  for (const std::string& variable : specification_.predictors()) {
    data::TextMatch match;
    if (!data::is_text_match(variable, match) || levels_.contains(match.column)) continue;
    const data::TextColumn labels = table.labels(match.column);
    std::set<std::string>& levels = levels_[match.column];
    for (const std::size_t row : rows_) levels.emplace(labels[row]);
  }
}

void NonlinearModel::compile() {
  // A parameter has one value per call unless it has covariates or random effects.
  std::vector<data::Program::Input> inputs;
  for (const ParameterModel& parameter : specification_.parameters) {
    const bool varies =
        !parameter.covariates.empty() || !parameter.random_only.empty() || group_count() > 1;
    inputs.push_back({.name = parameter.name, .is_scalar = !varies});
  }
  for (const std::string& name : variables_) inputs.push_back({.name = name});

  std::vector<data::Expression> outputs{specification_.formula.right};
  mean_program_ = data::Program(outputs, inputs);
  for (const ParameterModel& parameter : specification_.parameters) {
    outputs.push_back(specification_.formula.right.derivative(parameter.name));
  }
  gradient_program_ = data::Program(outputs, inputs);

  const std::size_t count = specification_.parameters.size();
  parameter_bilinear_.assign(count, std::vector<bool>(count));
  parameter_has_kink_.assign(count, false);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < count; ++j) {
      parameter_bilinear_[i][j] =
          outputs[1 + i].derivative(specification_.parameters[j].name).is_zero();
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    // If all second derivatives vanish, a kink (abs, max, ifelse, ...) may make the mean nonlinear.
    const bool has_kink =
        specification_.formula.right.has_kink_in(specification_.parameters[i].name);
    parameter_has_kink_[i] = has_kink;
    if (!parameter_bilinear_[i][i] || !has_kink) continue;
    for (std::size_t j = 0; j < count; ++j) {
      parameter_bilinear_[i][j] = parameter_bilinear_[j][i] = false;
    }
  }
}

bool NonlinearModel::has_kink_in(Index coefficient) const {
  return parameter_has_kink_[static_cast<std::size_t>(design_.parameter_of(coefficient))];
}

std::vector<std::string> NonlinearModel::kinks() const {
  std::vector<std::string> result;
  for (Index j = 0; j < coefficient_count(); ++j) {
    if (has_kink_in(j)) result.push_back(names_[static_cast<std::size_t>(j)]);
  }
  return result;
}

std::vector<std::string> NonlinearModel::fixed_kinks() const {
  std::vector<std::string> result = kinks();
  const std::vector<std::string> random = random_kinks();
  std::erase_if(result, [&](const auto& name) { return std::ranges::count(random, name) > 0; });
  return result;
}

std::vector<std::string> NonlinearModel::random_kinks() const {
  std::vector<std::string> result;
  for (const RandomEffects& term : specification_.random) {
    for (const std::string& name : term.coefficients) {
      const bool is_named = std::ranges::find(result, name) != result.end();
      if (has_kink_in(coefficient_index(name)) && !is_named) result.push_back(name);
    }
  }
  return result;
}

Index NonlinearModel::cluster_count() const { return std::ssize(groups_->first_cell) - 1; }

Index NonlinearModel::cluster_begin(Index cluster) const {
  return groups_->first_cell[static_cast<std::size_t>(cluster)];
}

Index NonlinearModel::group_of(std::size_t term, Index group) const {
  return groups_->group_of(term, group);
}

Index NonlinearModel::coefficient_index(std::string_view name) const {
  std::vector<std::string> names = names_;
  std::ranges::move(specification_.random_only_names(), std::back_inserter(names));
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) {
    throw UsageError(no_such_coefficient(specification_, name, names));
  }
  return found - names.begin();
}

VectorXd NonlinearModel::extended(const VectorXd& coefficients) const {
  VectorXd result = VectorXd::Zero(column_count());
  result.head(coefficients.size()) = coefficients;
  return result;
}

std::vector<Index> NonlinearModel::coefficients_of(const RandomEffects& term) const {
  std::vector<Index> positions;
  for (const std::string& name : term.coefficients) positions.push_back(coefficient_index(name));
  return positions;
}

std::vector<std::vector<Index>> NonlinearModel::random_coefficients() const {
  std::vector<std::vector<Index>> result;
  for (const RandomEffects& term : specification_.random) result.push_back(coefficients_of(term));
  return result;
}

VectorXd NonlinearModel::column(std::string_view name) const {
  const auto found = std::ranges::find(variables_, name);
  if (found == variables_.end()) {
    throw UsageError(fmt::format("the model does not use the column '{}'", name));
  }
  return columns_.col(found - variables_.begin());
}

const NonlinearModel::Strata& NonlinearModel::strata(std::string_view column) const {
  const auto found = std::ranges::find(strata_, column, &Strata::column);
  if (found == strata_.end()) {
    throw UsageError(fmt::format("the variance function has no stratum '{}'", column));
  }
  return *found;
}

bool NonlinearModel::is_bilinear(Index i, Index j) const {
  return parameter_bilinear_[static_cast<std::size_t>(design_.parameter_of(i))]
                            [static_cast<std::size_t>(design_.parameter_of(j))];
}

bool NonlinearModel::is_linear() const {
  for (Index i = 0; i < column_count(); ++i) {
    for (Index j = 0; j <= i; ++j) {
      if (!is_bilinear(i, j)) return false;
    }
  }
  return true;
}

Place NonlinearModel::place(Index observation) const {
  Place place{.file = file_};
  const std::size_t line = lines_[static_cast<std::size_t>(observation)];
  if (line > 0) place.line = line;
  return place;
}

void NonlinearModel::fill_parameters(const Eigen::Ref<const MatrixXd>& coefficients,
                                     Index begin,
                                     Index end,
                                     MatrixXd& parameters) const {
  // Of a parameter with one value per call, only the first is read.
  const std::vector<data::Program::Input>& inputs = mean_program_.inputs();
  const bool is_one_set = coefficients.cols() == 1;
  const auto after = std::upper_bound(group_begin_.begin(), group_begin_.end(), begin);
  const Index first = is_one_set ? 0 : after - group_begin_.begin() - 1;
  for (Index set = first, row = begin; row < end; ++set) {
    const Index stop = is_one_set ? end : std::min(end, group_begin_[set + 1]);
    const auto value = [&coefficients, set](Index j) {
      return j < coefficients.rows() ? coefficients(j, set) : 0.0;
    };
    for (Index k = 0; k < parameters.cols(); ++k) {
      const bool varies = !inputs[static_cast<std::size_t>(k)].is_scalar;
      double* const target = parameters.col(k).data() + (row - begin);
      design_.fill(k, row, varies ? stop - row : 1, value, target);
    }
    row = stop;
  }
}

void NonlinearModel::evaluate(const Eigen::Ref<const MatrixXd>& coefficients,
                              VectorXd& mean,
                              MatrixXd* jacobian,
                              Workspace& workspace) const {
  const Index count = coefficients.rows();
  if ((count != coefficient_count() && count != column_count()) ||
      (coefficients.cols() != 1 && coefficients.cols() != group_count())) {
    throw UsageError("coefficients must be given once, or once for each group");
  }
  check_stop();
  // Parameters and derivatives of a row are needed only until its results are computed.
  constexpr Index kBlockRows = 4096;
  const Index n = observations();
  mean.resize(n);
  if (jacobian != nullptr) jacobian->resize(n, count);
  std::vector<Workspace> others(worker_count(threads_) - 1);
  const auto block_count = static_cast<std::size_t>((n + kBlockRows - 1) / kBlockRows);
  parallel_for(block_count, threads_, [&](std::size_t block, std::size_t worker) {
    const Index begin = static_cast<Index>(block) * kBlockRows;
    const Index rows = std::min(kBlockRows, n - begin);
    Workspace& own = worker == 0 ? workspace : others[worker - 1];
    evaluate_rows(coefficients, begin, rows, mean, jacobian, own);
  });
}

VectorXd NonlinearModel::mean_at(const Eigen::Ref<const MatrixXd>& coefficients) const {
  Workspace workspace;
  VectorXd mean;
  evaluate(coefficients, mean, nullptr, workspace);
  return mean;
}

NonlinearModel::Curve NonlinearModel::curve_at(
    const Eigen::Ref<const MatrixXd>& coefficients) const {
  Workspace workspace;
  Curve result;
  evaluate(coefficients, result.mean, &result.jacobian, workspace);
  return result;
}

void NonlinearModel::evaluate_rows(const Eigen::Ref<const MatrixXd>& coefficients,
                                   Index begin,
                                   Index rows,
                                   VectorXd& mean,
                                   MatrixXd* jacobian,
                                   Workspace& workspace) const {
  const auto parameter_count = static_cast<Index>(specification_.parameters.size());
  workspace.parameters.resize(rows, parameter_count);
  workspace.derivatives.resize(rows, parameter_count);
  fill_parameters(coefficients, begin, begin + rows, workspace.parameters);
  std::vector<const double*> inputs;
  for (Index k = 0; k < parameter_count; ++k) inputs.push_back(workspace.parameters.col(k).data());
  for (Index k = 0; k < columns_.cols(); ++k) inputs.push_back(columns_.col(k).data() + begin);
  std::vector<double*> outputs{mean.data() + begin};
  if (jacobian == nullptr) {
    mean_program_.evaluate(inputs, static_cast<std::size_t>(rows), outputs, workspace.program);
    return;
  }
  for (Index k = 0; k < parameter_count; ++k) {
    outputs.push_back(workspace.derivatives.col(k).data());
  }
  // The derivative by an intercept is that by its parameter.
  for (Index j = 0; j < coefficients.rows(); ++j) {
    if (design_.multiplier(j) != nullptr) continue;
    outputs[1 + design_.parameter_of(j)] = jacobian->col(j).data() + begin;
  }
  gradient_program_.evaluate(inputs, static_cast<std::size_t>(rows), outputs, workspace.program);
  for (Index j = 0; j < coefficients.rows(); ++j) {
    if (design_.multiplier(j) == nullptr) continue;
    const double* const by_parameter = outputs[1 + design_.parameter_of(j)];
    design_.differentiate(j, begin, rows, by_parameter, jacobian->col(j).data() + begin);
  }
}

}  // namespace silvafit::fit
