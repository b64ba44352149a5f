// SPDX-License-Identifier: MIT
#include "conditional_modes/observation_rows.hpp"

#include <algorithm>

#include "conditional_modes/observation_terms.hpp"
#include "silvafit/data/row_sums.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;

/// Never shrinks memory: if it grows again, it is filled with zeros.
void enlarge(std::vector<double>& memory, std::size_t count) {
  if (memory.size() < count) memory.resize(count);
}

}  // namespace

ObservationRows::ObservationRows(const NonlinearModel& model,
                                 const VarianceModel& variance,
                                 const std::vector<Index>& random)
    : model_(model),
      variance_(variance),
      r_(random.size()),
      effect_of_(static_cast<std::size_t>(model.column_count()), -1) {
  for (std::size_t k = 0; k < r_; ++k) {
    effect_of_[static_cast<std::size_t>(random[k])] = static_cast<Index>(k);
  }
  store_indicators();
  // A quantity with a single stratum, its reference, needs a column of zeros in place of
  // indicators.
  if (std::ranges::any_of(variance.quantities(), [](const auto& one) { return one.strata >= 0; })) {
    quantity_rows_.resize(model.observations(), static_cast<Index>(variance.quantities().size()));
  }
}

void ObservationRows::store_indicators() {
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

ObservationRows::Task ObservationRows::task_of(const std::vector<Expression>& outputs) {
  return row_program(outputs, [this](const std::string& name) { return source_of(name); });
}

ObservationRows::Source ObservationRows::source_of(const std::string& name) {
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
  const auto r = static_cast<Index>(r_);
  for (Index j = 0; j < r; ++j) {
    for (Index i = j; i < r; ++i, ++weight) {
      if (name == term_names::weight(i, j)) return {.kind = Kind::kWeight, .index = weight};
    }
  }
  for (std::size_t k = 0; k < 2 + 2 * r_; ++k) {
    if (name == term_names::adjoint(k)) return {.kind = Kind::kAdjoint, .index = k};
  }
  const auto variable = std::ranges::find(model_.variables(), name);
  return {.kind = Kind::kColumn,
          .column = model_.variable_values().col(variable - model_.variables().begin()).data()};
}

ObservationRows::Source ObservationRows::parameter_source(const std::string& name,
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

ObservationRows::Source ObservationRows::quantity_source(std::size_t quantity) {
  if (variance_.quantities()[quantity].strata < 0) {
    const std::size_t parameter_count = model_.specification().parameters.size();
    return {.kind = Source::Kind::kScalar, .index = parameter_count + quantity};
  }
  return {.kind = Source::Kind::kColumn,
          .column = quantity_rows_.col(static_cast<Index>(quantity)).data()};
}

void ObservationRows::set_point(const ObservationPoint& point) {
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

void ObservationRows::fill_parameter(const VaryingParameter& varying,
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
Index ObservationRows::fill_rows(
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

void ObservationRows::connect_inputs(const Task& task,
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
      case Source::Kind::kAdjoint:
        input = values.adjoints->col(static_cast<Index>(source.index)).data() +
                (row - model_.group_begin(values.first));
        break;
    }
  }
}

void ObservationRows::reserve(const Task& task,
                              const GroupValues& values,
                              Workspace& workspace) const {
  enlarge(workspace.inputs, (varying_.size() + values.weight_count()) * kProgramRows);
  workspace.output_columns.resize(task.outputs);
}

/// The values of some rows from `row` of a group on, into the output columns.
/// \returns the group of the row after them
Index ObservationRows::evaluate(const Task& task,
                                const GroupValues& values,
                                Index group,
                                Index row,
                                Index rows,
                                Workspace& workspace) const {
  const Index next = fill_rows(values, group, row, rows, workspace);
  connect_inputs(task, values, row, workspace);
  task.program.evaluate(workspace.input_columns,
                        static_cast<std::size_t>(rows),
                        workspace.output_columns,
                        workspace.program);
  return next;
}

void ObservationRows::sum(const Task& task,
                          const GroupValues& values,
                          Index last,
                          MatrixXd& sums,
                          Workspace& workspace) const {
  // Weights come last, and are not summed.
  const auto width = static_cast<Index>(task.outputs) - (values.held != nullptr ? 1 : 0);
  sums.setZero(width, last - values.first);
  reserve(task, values, workspace);
  enlarge(workspace.outputs, task.outputs * kProgramRows);
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
    group = evaluate(task, values, group, row, rows, workspace);
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

void ObservationRows::fill(const Task& task,
                           const GroupValues& values,
                           Index last,
                           MatrixXd& rows,
                           Workspace& workspace) const {
  const Index begin = model_.group_begin(values.first);
  const Index end = model_.group_begin(last);
  rows.resize(end - begin, static_cast<Index>(task.outputs));
  reserve(task, values, workspace);
  Index group = values.first;
  for (Index row = begin; row < end; row += kProgramRows) {
    for (std::size_t k = 0; k < task.outputs; ++k) {
      workspace.output_columns[k] = rows.col(static_cast<Index>(k)).data() + (row - begin);
    }
    group = evaluate(task, values, group, row, std::min(kProgramRows, end - row), workspace);
  }
}

}  // namespace silvafit::fit
