// SPDX-License-Identifier: MIT
#include "conditional_modes/calibration_terms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "silvafit/data/row_sums.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = VarianceFactor::Kind;

// Names of what is no column; none can be one in a formula, since all have a blank.
constexpr const char* kFitted = "fitted value";
constexpr const char* kHeld = "held weight";

std::string population_name(const std::string& parameter) { return "population " + parameter; }
std::string multiplier_name(Index coefficient) { return fmt::format("multiplier {}", coefficient); }
std::string stratum_name(const char* what, std::size_t factor) {
  return fmt::format("{} of factor {}", what, factor);
}

Expression log_of(const Expression& value) {
  // log|v| whose derivative is 1/v on both sides of zero.
  const Expression text = Expression::parse("0.5*log(v*v)");
  return text.substitute("v", value);
}

const VectorXd& values_of(const VarianceFactorEstimate& factor, const char* what) {
  const std::string_view name(what);
  if (name == "delta") return factor.delta;
  return name == "constant" ? factor.constant : factor.ratio;
}

bool has_strata(const VarianceFactorEstimate& factor) { return !factor.factor.stratum.empty(); }

/// Whether the residual variance depends on the fitted value.
bool uses_fitted(const VarianceEstimate& variance) {
  return std::ranges::any_of(variance.factors, [](const VarianceFactorEstimate& factor) {
    return factor.factor.column.empty() && factor.factor.kind != Kind::kStratum;
  });
}

bool is_penalized(const FittedModel& fit) { return fit.method == Method::kLindstromBates; }

}  // namespace

/// Derivatives of the density by the mean, and of the mean by coefficients.
struct CalibrationTerms::Derivatives {
  Expression objective = Expression::constant(0.0);
  Expression own_objective = Expression::constant(0.0);
  Expression weight = Expression::constant(0.0);  ///< tau
  Expression first = Expression::constant(0.0);   ///< rho'
  Expression second = Expression::constant(0.0);  ///< rho''
  Expression omega = Expression::constant(0.0);
  /// What first changes by, for each unit of the population's mean: only where its residual
  /// variance counts.
  Expression first_by_population = Expression::constant(0.0);
};

CalibrationTerms::CalibrationTerms(const NonlinearModel& model,
                                   const FittedModel& fit,
                                   std::vector<Index> random)
    : model_(model), random_(std::move(random)) {
  fill_base(fit);
  store_strata(fit);
  holds_weights_ = is_penalized(fit) && uses_fitted(fit.variance);
  const Derivatives derivatives = derivatives_of(fit);
  search_ = task_of(search_outputs(derivatives));
  fixed_ = task_of(fixed_outputs(derivatives));
}

/// The mean without random effects.
Expression CalibrationTerms::population_mean() const {
  Expression result = model_.specification().formula.right;
  for (const ParameterModel& parameter : model_.specification().parameters) {
    result =
        result.substitute(parameter.name, Expression::variable(population_name(parameter.name)));
  }
  return result;
}

CalibrationTerms::Derivatives CalibrationTerms::derivatives_of(const FittedModel& fit) const {
  const bool is_first_order = fit.method == Method::kFirstOrder;
  const Expression& mean = model_.specification().formula.right;
  const Expression fitted = Expression::variable(kFitted);
  const Expression scale_at = is_first_order ? population_mean() : mean;
  const auto at_fitted = [&](int order) {
    Expression result = log_scale(fit, fitted);
    for (int k = 0; k < order; ++k) result = result.derivative(kFitted);
    return result.substitute(kFitted, scale_at);
  };
  const Expression r = Expression::variable(model_.specification().formula.left) - mean;
  const Expression log_sd = at_fitted(0) + Expression::constant(std::log(fit.sigma));
  const Expression kappa = at_fitted(1);
  const Expression kappa1 = at_fitted(2);

  Derivatives d{.weight = exp(-2.0 * log_sd)};
  const Expression scaled = r * d.weight;
  const Expression squared = r * scaled;
  if (is_penalized(fit)) {
    const Expression held = holds_weights_ ? Expression::variable(kHeld) : d.weight;
    d.objective = 0.5 * (r * r * held);
    d.own_objective = 0.5 * squared;
    d.first = -scaled;
    d.second = d.weight + 2.0 * (kappa * scaled);
    d.omega = d.weight;
    return d;
  }
  d.objective = d.own_objective = log_sd + 0.5 * squared;
  d.first = -scaled;
  d.second = d.omega = d.weight;
  if (is_first_order) {
    d.first_by_population = 2.0 * (kappa * scaled);
    return d;
  }
  const Expression free = Expression::constant(1.0) - squared;
  d.first = kappa * free - scaled;
  d.second = kappa1 * free + d.weight + 4.0 * (kappa * scaled) + 2.0 * (kappa * kappa * squared);
  d.omega = d.weight + 2.0 * (kappa * kappa);
  return d;
}

Expression CalibrationTerms::multiplier(Index coefficient) const {
  if (model_.multiplier_values(coefficient) == nullptr) return Expression::constant(1.0);
  return Expression::variable(multiplier_name(coefficient));
}

/// The parameter that a coefficient is part of.
const std::string& CalibrationTerms::parameter_name(Index coefficient) const {
  const auto k = static_cast<std::size_t>(model_.parameter_of(coefficient));
  return model_.specification().parameters[k].name;
}

/// The derivative of the mean by a coefficient.
Expression CalibrationTerms::by(Index c) const {
  const Expression& mean = model_.specification().formula.right;
  return multiplier(c) * mean.derivative(parameter_name(c));
}

/// The second derivative by two coefficients.
Expression CalibrationTerms::by_both(Index c, Index e) const {
  const Expression& mean = model_.specification().formula.right;
  return multiplier(c) * multiplier(e) *
         mean.derivative(parameter_name(c)).derivative(parameter_name(e));
}

std::vector<Expression> CalibrationTerms::search_outputs(const Derivatives& d) const {
  std::vector<Expression> outputs{d.objective, d.own_objective};
  for (const Index c : random_) outputs.push_back(d.first * by(c));
  for (const bool is_exact : {true, false}) {
    for (std::size_t j = 0; j < random_.size(); ++j) {
      for (std::size_t i = j; i < random_.size(); ++i) {
        const Expression slopes = by(random_[i]) * by(random_[j]);
        outputs.push_back(is_exact ? d.second * slopes + d.first * by_both(random_[i], random_[j])
                                   : d.omega * slopes);
      }
    }
  }
  if (holds_weights_) outputs.push_back(d.weight);
  return outputs;
}

std::vector<Expression> CalibrationTerms::fixed_outputs(const Derivatives& d) const {
  const Expression population = population_mean();
  std::vector<Expression> outputs;
  for (Index j = 0; j < model_.coefficient_count(); ++j) {
    const Expression shift = d.first_by_population * multiplier(j) *
                             population.derivative(population_name(parameter_name(j)));
    for (const Index c : random_) {
      outputs.push_back(d.second * by(j) * by(c) + d.first * by_both(j, c) + shift * by(c));
    }
  }
  return outputs;
}

void CalibrationTerms::fill_base(const FittedModel& fit) {
  const auto& parameters = model_.specification().parameters;
  base_.setZero(model_.observations(), static_cast<Index>(parameters.size()));
  for (Index j = 0; j < model_.coefficient_count(); ++j) {
    base_.col(model_.parameter_of(j)) += fit.estimate[j] * model_.multiplier(j);
  }
}

/// Parameters of the variance function that differ by stratum, as columns.
void CalibrationTerms::store_strata(const FittedModel& fit) {
  for (std::size_t k = 0; k < fit.variance.factors.size(); ++k) {
    const VarianceFactorEstimate& factor = fit.variance.factors[k];
    if (!has_strata(factor)) continue;
    const NonlinearModel::Strata& strata = model_.strata(factor.factor.stratum);
    std::vector<Index> of_label;
    for (const std::string& label : strata.labels) {
      of_label.push_back(std::ranges::find(factor.strata, label) - factor.strata.begin());
    }
    for (const char* what : {"delta", "constant", "ratio"}) {
      const VectorXd& values = values_of(factor, what);
      if (values.size() == 0) continue;
      VectorXd column(model_.observations());
      for (Index i = 0; i < column.size(); ++i) {
        const Index stratum = strata.of_rows[static_cast<std::size_t>(i)];
        column[i] = values[of_label[static_cast<std::size_t>(stratum)]];
      }
      strata_columns_.emplace_back(stratum_name(what, k), std::move(column));
    }
  }
}

/// log g by R nlme's definitions, at the fit's estimates.
Expression CalibrationTerms::log_scale(const FittedModel& fit, const Expression& fitted) const {
  Expression sum = Expression::constant(0.0);
  for (std::size_t k = 0; k < fit.variance.factors.size(); ++k) {
    const VarianceFactorEstimate& factor = fit.variance.factors[k];
    const auto value = [&](const char* what) {
      return has_strata(factor) ? Expression::variable(stratum_name(what, k))
                                : Expression::constant(values_of(factor, what)[0]);
    };
    const auto log_of_exact = [](const Expression& of) {
      return Expression::parse("log(v)").substitute("v", of);
    };
    const Expression v =
        factor.factor.column.empty() ? fitted : Expression::variable(factor.factor.column);
    switch (factor.factor.kind) {
      case Kind::kExponential:
        sum = sum + value("delta") * v;
        break;
      case Kind::kPower:
        sum = sum + value("delta") * log_of(v);
        break;
      case Kind::kConstantPlusPower:
        // An infinite constant stands for a constant variance.
        if (!has_strata(factor) && std::isinf(factor.constant[0])) break;
        sum = sum + log_of_exact(value("constant") + exp(value("delta") * log_of(v)));
        break;
      case Kind::kStratum:
        sum = sum + log_of_exact(value("ratio"));
        break;
    }
  }
  return sum;
}

CalibrationTerms::Task CalibrationTerms::task_of(const std::vector<Expression>& outputs) const {
  return row_program(outputs, [this](const std::string& name) { return source_of(name); });
}

CalibrationTerms::Source CalibrationTerms::source_of(const std::string& name) const {
  using Place = Source::Kind;
  const auto& parameters = model_.specification().parameters;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const auto index = static_cast<Index>(k);
    if (name == parameters[k].name) return {.kind = Place::kParameter, .index = index};
    if (name == population_name(parameters[k].name)) return {.column = base_.col(index).data()};
  }
  for (Index j = 0; j < model_.coefficient_count(); ++j) {
    if (name == multiplier_name(j)) return {.column = model_.multiplier_values(j)};
  }
  for (const auto& [stratum, values] : strata_columns_) {
    if (name == stratum) return {.column = values.data()};
  }
  if (name == kHeld) return {.kind = Place::kHeld};
  if (name == model_.specification().formula.left) return {.column = model_.response().data()};
  const auto variable = std::ranges::find(model_.variables(), name);
  return {.column = model_.variable_values().col(variable - model_.variables().begin()).data()};
}

/// The parameters of some rows of one group, from the place `done` of the block on.
void CalibrationTerms::fill_parameters(Index group,
                                       Index row,
                                       Index rows,
                                       Index done,
                                       const MatrixXd& effects,
                                       Workspace& workspace) const {
  const auto column = [&](Index parameter) {
    return Eigen::Map<VectorXd>(workspace.parameters.data() + parameter * kProgramRows + done,
                                rows);
  };
  for (Index k = 0; k < base_.cols(); ++k) column(k) = base_.col(k).segment(row, rows);
  for (Index c = 0; c < random_count(); ++c) {
    const Index coefficient = random_[static_cast<std::size_t>(c)];
    const double* const multiplier = model_.multiplier_values(coefficient);
    auto target = column(model_.parameter_of(coefficient));
    if (multiplier == nullptr) {
      target.array() += effects(c, group);
    } else {
      target += effects(c, group) * Eigen::Map<const VectorXd>(multiplier + row, rows);
    }
  }
}

void CalibrationTerms::run(const Task& task,
                           Index first,
                           Index last,
                           const MatrixXd& effects,
                           const VectorXd* held,
                           VectorXd* own,
                           MatrixXd& sums,
                           Workspace& workspace) const {
  const auto summed = static_cast<Index>(task.outputs) - (own != nullptr ? 1 : 0);
  sums.setZero(summed, last - first);
  workspace.parameters.resize(static_cast<std::size_t>(base_.cols() * kProgramRows));
  workspace.outputs.resize(task.outputs * kProgramRows);
  workspace.columns.resize(task.outputs);
  for (std::size_t k = 0; k < task.outputs; ++k) {
    workspace.columns[k] = workspace.outputs.data() + k * kProgramRows;
  }
  const std::vector<const double*> columns(workspace.columns.begin(),
                                           workspace.columns.begin() + summed);
  workspace.inputs.resize(task.sources.size());
  const Index end = model_.group_begin(last);
  Index group = first;
  for (Index row = model_.group_begin(first); row < end; row += kProgramRows) {
    const Index rows = std::min(kProgramRows, end - row);
    const Index first_group = group;
    workspace.begins.assign(1, 0);
    for (Index done = 0; done < rows;) {
      const Index stop = std::min(rows, model_.group_begin(group + 1) - row);
      fill_parameters(group, row + done, stop - done, done, effects, workspace);
      workspace.begins.push_back(static_cast<std::size_t>(stop));
      done = stop;
      if (row + done == model_.group_begin(group + 1)) ++group;
    }
    for (std::size_t k = 0; k < task.sources.size(); ++k) {
      const Source& source = task.sources[k];
      const double*& input = workspace.inputs[k];
      if (source.kind == Source::Kind::kParameter) {
        input = workspace.parameters.data() + source.index * kProgramRows;
      } else if (source.kind == Source::Kind::kHeld) {
        input = held->data() + row;
      } else {
        input = source.column + row;
      }
    }
    task.program.evaluate(
        workspace.inputs, static_cast<std::size_t>(rows), workspace.columns, workspace.program);
    if (own != nullptr) {
      own->segment(row, rows) = Eigen::Map<const VectorXd>(workspace.columns.back(), rows);
    }
    const std::size_t segments = workspace.begins.size() - 1;
    workspace.sums.resize(segments * static_cast<std::size_t>(summed));
    data::segment_sums(columns, workspace.begins, workspace.sums.data());
    sums.middleCols(first_group - first, static_cast<Index>(segments)) +=
        Eigen::Map<const MatrixXd>(workspace.sums.data(), summed, static_cast<Index>(segments));
  }
}

void CalibrationTerms::evaluate(Index first,
                                Index last,
                                const MatrixXd& effects,
                                const VectorXd& held,
                                VectorXd& own,
                                MatrixXd& sums,
                                Workspace& workspace) const {
  run(search_, first, last, effects, &held, holds_weights_ ? &own : nullptr, sums, workspace);
}

void CalibrationTerms::by_coefficients(
    Index first, Index last, const MatrixXd& effects, MatrixXd& sums, Workspace& workspace) const {
  run(fixed_, first, last, effects, nullptr, nullptr, sums, workspace);
}

}  // namespace silvafit::fit
