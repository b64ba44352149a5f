// SPDX-License-Identifier: MIT
// Models that follow from another one: on some of its observations, without covariates, with held
// parameters, another equation or fewer random effects.
#include <optional>
#include <utility>
#include <vector>

#include "model/held_coefficients.hpp"
#include "model/model_groups.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

NonlinearModel NonlinearModel::subset(const std::vector<Index>& observations) const {
  NonlinearModel part = *this;
  part.rows_.clear();
  part.lines_.clear();
  part.group_begin_.clear();
  for (Strata& strata : part.strata_) strata.of_rows.clear();
  Index group = 0;
  Index cluster = 0;
  Index last_group = -1;
  Index last_cluster = -1;
  std::vector<Index> cells;
  std::vector<Index> first_cell;
  for (const Index i : observations) {
    while (i >= group_begin_[static_cast<std::size_t>(group) + 1]) ++group;
    while (group >= cluster_begin(cluster + 1)) ++cluster;
    if (cluster != last_cluster) {
      first_cell.push_back(std::ssize(cells));
      last_cluster = cluster;
    }
    if (group != last_group) {
      part.group_begin_.push_back(static_cast<Index>(part.rows_.size()));
      cells.push_back(group);
      last_group = group;
    }
    part.rows_.push_back(rows_[static_cast<std::size_t>(i)]);
    part.lines_.push_back(lines_[static_cast<std::size_t>(i)]);
    for (std::size_t k = 0; k < strata_.size(); ++k) {
      part.strata_[k].of_rows.push_back(strata_[k].of_rows[static_cast<std::size_t>(i)]);
    }
  }
  part.group_begin_.push_back(static_cast<Index>(part.rows_.size()));
  first_cell.push_back(std::ssize(cells));
  part.take_groups(groups_->part(cells, std::move(first_cell)));
  part.response_ = response_(observations);
  part.columns_ = columns_(observations, Eigen::all);
  part.design_ = design_.part(observations);
  return part;
}

NonlinearModel NonlinearModel::pooled() const {
  NonlinearModel model = *this;
  std::erase_if(model.specification_.parameters, [&](const ParameterModel& parameter) {
    if (!parameter.coefficient_names().empty()) return false;
    data::Expression& mean = model.specification_.formula.right;
    mean = mean.substitute(parameter.name, data::Expression::constant(0.0));
    return true;
  });
  for (ParameterModel& parameter : model.specification_.parameters) {
    parameter = {.name = parameter.name, .has_intercept = true};
  }
  model.specification_.random.clear();
  model.names_ = model.specification_.coefficient_names();
  model.design_ = ParameterDesign(std::ssize(model.specification_.parameters), observations());
  model.compile();
  return model;
}

NonlinearModel NonlinearModel::with_held(const std::map<std::string, double>& held) const {
  NonlinearModel model = pooled();
  model.specification_ = fit::with_held(model.specification_, held);
  model.design_ = ParameterDesign(std::ssize(model.specification_.parameters), observations());
  model.names_ = model.specification_.coefficient_names();
  model.compile();
  return model;
}

NonlinearModel NonlinearModel::with_equation(data::Expression mean, VectorXd response) const {
  NonlinearModel model = *this;
  model.specification_.formula.right = std::move(mean);
  model.response_ = std::move(response);
  return model.pooled();
}

NonlinearModel NonlinearModel::with_independent_residuals() const {
  NonlinearModel model = *this;
  model.specification_.correlation.reset();
  return model;
}

NonlinearModel NonlinearModel::with_random_effects(std::vector<RandomEffects> terms) const {
  NonlinearModel model = *this;
  model.specification_.random = std::move(terms);
  if (!model.specification_.random.empty()) return model;
  model.group_begin_ = {0, observations()};
  model.take_groups({.first_cell = {0, 1}});
  model.compile();
  return model;
}

}  // namespace silvafit::fit
