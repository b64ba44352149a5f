// SPDX-License-Identifier: MIT
#include "conditional_modes/observation_sums.hpp"

#include <algorithm>
#include <utility>

#include "silvafit/data/row_sums.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;

/// Never shrinks memory: if it grows again, it is filled with zeros.
void enlarge(std::vector<double>& memory, std::size_t count) {
  if (memory.size() < count) memory.resize(count);
}

void append(std::vector<Expression>& target, const std::vector<Expression>& more) {
  target.insert(target.end(), more.begin(), more.end());
}

}  // namespace

ObservationSums::ObservationSums(const NonlinearModel& model,
                                 const VarianceModel& variance,
                                 Curvature curvature,
                                 std::vector<Index> random,
                                 bool with_slopes)
    : GroupSums(std::move(random)),
      model_(model),
      variance_(variance),
      r_(random_count()),
      effect_of_(static_cast<std::size_t>(model.column_count()), -1) {
  for (Index k = 0; k < r_; ++k) effect_of_[static_cast<std::size_t>(this->random()[k])] = k;
  store_indicators();
  // A quantity with a single stratum, its reference, needs a column of zeros in place of
  // indicators.
  if (std::ranges::any_of(variance.quantities(), [](const auto& one) { return one.strata >= 0; })) {
    quantity_rows_.resize(model.observations(), static_cast<Index>(variance.quantities().size()));
  }
  ObservationTerms terms;
  if (with_slopes) {
    terms = observation_terms(model, variance, curvature, this->random());
  } else {
    static_cast<ModeTerms&>(terms) = mode_terms(model, variance, curvature, this->random());
  }
  has_approximation_ = !terms.approximation.empty();
  holds_weights_ = !terms.own_weight.empty();
  others_ = terms.others;

  std::vector<Expression> outputs{terms.density};
  append(outputs, terms.by_random);
  append(outputs, terms.curvature);
  append(outputs, terms.approximation);
  append(outputs, terms.own_weight);
  density_ = task_of(outputs);
  if (!with_slopes) {
    mixed_ = task_of(terms.other_random);
    return;
  }

  outputs = {terms.density};
  append(outputs, terms.density_by_fixed);
  append(outputs, terms.density_by_variance);
  slopes_ = task_of(outputs);

  outputs = terms.penalty_by_random;
  append(outputs, terms.by_other);
  append(outputs, terms.by_variance);
  append(outputs, terms.other_random);
  append(outputs, terms.variance_random);
  total_ = task_of(outputs);
}

void ObservationSums::store_indicators() {
  Index count = 0;
  for (const VarianceModel::Quantity& quantity : variance_.quantities()) {
    indicator_begin_.push_back(count);
    if (quantity.strata >= 0) count += quantity.count;
  }
  indicators_.setZero(model_.observations(), count);
  for (std::size_t k = 0; k < variance_.quantities().size(); ++k) {
    const VarianceModel::Quantity& quantity = variance_.quantities()[k];
    if (quantity.strata < 0) continue;
    const auto& strata = variance_.data().strata[static_cast<std::size_t>(quantity.strata)].of_rows;
    for (Index i = 0; i < indicators_.rows(); ++i) {
      const Index s = strata[static_cast<std::size_t>(i)] - (quantity.has_reference ? 1 : 0);
      if (s >= 0) indicators_(i, indicator_begin_[k] + s) = 1.0;
    }
  }
}

ObservationSums::Task ObservationSums::task_of(const std::vector<Expression>& outputs) {
  return row_program(outputs, [this](const std::string& name) { return source_of(name); });
}

ObservationSums::Source ObservationSums::source_of(const std::string& name) {
  using Kind = Source::Kind;
  const auto& parameters = model_.specification().parameters;
  const std::size_t count = parameters.size();
  for (std::size_t k = 0; k < count; ++k) {
    if (name == parameters[k].name) return parameter_source(name, static_cast<Index>(k), false);
    if (name == term_names::population(parameters[k].name)) {
      return parameter_source(name, static_cast<Index>(k), true);
    }
  }
  const auto& quantities = variance_.quantities();
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    if (name == quantities[k].name) return quantity_source(k);
    for (Index s = 0; s < quantities[k].count; ++s) {
      if (name != term_names::indicator(k, s)) continue;
      return {.kind = Kind::kColumn, .column = indicators_.col(indicator_begin_[k] + s).data()};
    }
  }
  if (name == term_names::held_weight()) return {.kind = Kind::kHeld};
  if (name == term_names::log_sigma()) {
    return {.kind = Kind::kScalar, .index = count + quantities.size()};
  }
  for (Index j = 0; j < model_.column_count(); ++j) {
    if (name == term_names::multiplier(j)) {
      return {.kind = Kind::kColumn, .column = model_.design().multiplier(j)};
    }
  }
  std::size_t weight = 0;
  for (Index j = 0; j < r_; ++j) {
    for (Index i = j; i < r_; ++i, ++weight) {
      if (name == term_names::weight(i, j)) return {.kind = Kind::kWeight, .index = weight};
    }
  }
  const auto variable = std::ranges::find(model_.variables(), name);
  return {.kind = Kind::kColumn,
          .column = model_.variable_values().col(variable - model_.variables().begin()).data()};
}

ObservationSums::Source ObservationSums::parameter_source(const std::string& name,
                                                          Index parameter,
                                                          bool at_population) {
  using Kind = Source::Kind;
  const auto is_random = [this](Index j) { return effect_of_[static_cast<std::size_t>(j)] >= 0; };
  const ParameterDesign& design = model_.design();
  const bool varies =
      design.has_covariates(parameter) ||
      (!at_population && std::ranges::any_of(design.coefficients_of(parameter), is_random));
  if (!varies) return {.kind = Kind::kScalar, .index = static_cast<std::size_t>(parameter)};
  const auto known = std::ranges::find(varying_, name, &VaryingParameter::name);
  const auto index = static_cast<std::size_t>(known - varying_.begin());
  if (known == varying_.end()) varying_.push_back({name, parameter, at_population});
  return {.kind = Kind::kParameter, .index = index};
}

ObservationSums::Source ObservationSums::quantity_source(std::size_t quantity) {
  if (variance_.quantities()[quantity].strata < 0) {
    const std::size_t parameter_count = model_.specification().parameters.size();
    return {.kind = Source::Kind::kScalar, .index = parameter_count + quantity};
  }
  return {.kind = Source::Kind::kColumn,
          .column = quantity_rows_.col(static_cast<Index>(quantity)).data()};
}

void ObservationSums::set_point(const ObservationPoint& point) {
  const std::size_t parameter_count = model_.specification().parameters.size();
  const auto& quantities = variance_.quantities();
  scalars_.assign(parameter_count + quantities.size() + 1, 0.0);
  scalars_.back() = point.log_sigma;
  beta_ = point.beta;
  for (Index j = 0; j < beta_.size(); ++j) {
    // A parameter with several coefficients is not a scalar.
    scalars_[static_cast<std::size_t>(model_.design().parameter_of(j))] = beta_[j];
  }
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    const VarianceModel::Quantity& quantity = quantities[k];
    if (quantity.strata < 0) {
      scalars_[parameter_count + k] = point.variance[quantity.first];
    } else {
      quantity_rows_.col(static_cast<Index>(k)) =
          indicators_.middleCols(indicator_begin_[k], quantity.count) *
          point.variance.segment(quantity.first, quantity.count);
    }
  }
}

void ObservationSums::fill_parameter(const VaryingParameter& varying,
                                     const MatrixXd& effects,
                                     Index group,
                                     Index row,
                                     Index rows,
                                     double* target) const {
  const auto value = [&](Index j) {
    const Index effect = effect_of_[static_cast<std::size_t>(j)];
    const bool is_fixed = varying.at_population || effect < 0;
    return beta_[j] + (is_fixed ? 0.0 : effects(effect, group));
  };
  model_.design().fill(varying.parameter, row, rows, value, target);
}

/// Fills in the inputs that differ by group for some rows from `row` on, and where the groups begin
/// among them.
/// \returns the group of the row after them
Index ObservationSums::fill_rows(
    const GroupValues& values, Index group, Index row, Index rows, Workspace& workspace) const {
  double* const parameters = workspace.inputs.data();
  double* const weights = parameters + varying_.size() * kProgramRows;
  workspace.begins.assign(1, 0);
  for (Index done = 0; done < rows;) {
    const Index stop = std::min(rows, model_.group_begin(group + 1) - row);
    for (std::size_t k = 0; k < varying_.size(); ++k) {
      double* const target = parameters + k * kProgramRows + done;
      fill_parameter(varying_[k], values.effects, group, row + done, stop - done, target);
    }
    for (std::size_t k = 0; k < values.weight_count(); ++k) {
      const double weight = (*values.weights)(static_cast<Index>(k), group - values.first);
      std::fill_n(weights + k * kProgramRows + done, stop - done, weight);
    }
    workspace.begins.push_back(static_cast<std::size_t>(stop));
    done = stop;
    if (row + done == model_.group_begin(group + 1)) ++group;
  }
  return group;
}

void ObservationSums::connect_inputs(const Task& task,
                                     const GroupValues& values,
                                     Index row,
                                     Workspace& workspace) const {
  const double* const parameters = workspace.inputs.data();
  const double* const weights = parameters + varying_.size() * kProgramRows;
  workspace.input_columns.resize(task.sources.size());
  for (std::size_t k = 0; k < task.sources.size(); ++k) {
    const Source& source = task.sources[k];
    const double*& input = workspace.input_columns[k];
    switch (source.kind) {
      case Source::Kind::kScalar:
        input = &scalars_[source.index];
        break;
      case Source::Kind::kColumn:
        input = source.column + row;
        break;
      case Source::Kind::kParameter:
        input = parameters + source.index * kProgramRows;
        break;
      case Source::Kind::kWeight:
        input = weights + source.index * kProgramRows;
        break;
      case Source::Kind::kHeld:
        input = values.held->held.data() + (row - values.held->first_row);
        break;
    }
  }
}

void ObservationSums::run(const Task& task,
                          const GroupValues& values,
                          Index last,
                          MatrixXd& sums,
                          Workspace& workspace) const {
  // Weights come last, and are not summed.
  const auto width = static_cast<Index>(task.outputs) - (values.held != nullptr ? 1 : 0);
  sums.setZero(width, last - values.first);
  enlarge(workspace.inputs, (varying_.size() + values.weight_count()) * kProgramRows);
  enlarge(workspace.outputs, task.outputs * kProgramRows);
  workspace.output_columns.resize(task.outputs);
  for (std::size_t k = 0; k < task.outputs; ++k) {
    workspace.output_columns[k] = workspace.outputs.data() + k * kProgramRows;
  }
  const std::vector<const double*> columns(workspace.output_columns.begin(),
                                           workspace.output_columns.begin() + width);
  const Index end = model_.group_begin(last);
  Index group = values.first;
  for (Index row = model_.group_begin(group); row < end; row += kProgramRows) {
    const Index rows = std::min(kProgramRows, end - row);
    const Index first_group = group;
    group = fill_rows(values, group, row, rows, workspace);
    connect_inputs(task, values, row, workspace);
    task.program.evaluate(workspace.input_columns,
                          static_cast<std::size_t>(rows),
                          workspace.output_columns,
                          workspace.program);
    if (values.held != nullptr) {
      const Eigen::Map<const VectorXd> own(workspace.output_columns.back(), rows);
      values.held->own.segment(row - values.held->first_row, rows) = own;
    }
    const std::size_t segments = workspace.begins.size() - 1;
    enlarge(workspace.sums, segments * task.outputs);
    data::segment_sums(columns, workspace.begins, workspace.sums.data());
    sums.middleCols(first_group - values.first, static_cast<Index>(segments)) +=
        Eigen::Map<const MatrixXd>(workspace.sums.data(), width, static_cast<Index>(segments));
  }
}

void ObservationSums::density(Index first,
                              Index last,
                              const MatrixXd& effects,
                              MatrixXd& sums,
                              Workspace& workspace,
                              HeldWeights* weights) const {
  run(density_, {.effects = effects, .first = first, .held = weights}, last, sums, workspace);
}

void ObservationSums::mixed(
    Index first, Index last, const MatrixXd& effects, MatrixXd& sums, Workspace& workspace) const {
  sums.setZero(0, last - first);
  if (mixed_.outputs == 0) return;
  run(mixed_, {.effects = effects, .first = first}, last, sums, workspace);
}

void ObservationSums::slopes(
    Index first, Index last, const MatrixXd& effects, MatrixXd& sums, Workspace& workspace) const {
  run(slopes_, {.effects = effects, .first = first}, last, sums, workspace);
}

void ObservationSums::total(Index first,
                            Index last,
                            const MatrixXd& effects,
                            const MatrixXd& weights,
                            MatrixXd& sums,
                            Workspace& workspace) const {
  run(total_, {.effects = effects, .weights = &weights, .first = first}, last, sums, workspace);
}

}  // namespace silvafit::fit
