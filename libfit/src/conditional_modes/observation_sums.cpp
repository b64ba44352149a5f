// SPDX-License-Identifier: MIT
#include "conditional_modes/observation_sums.hpp"

#include <algorithm>

#include "conditional_modes/correlated_sums.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;

void append(std::vector<Expression>& target, const std::vector<Expression>& more) {
  target.insert(target.end(), more.begin(), more.end());
}

/// Of independent residuals.
class ObservationSums : public GroupSums {
 public:
  ObservationSums(const NonlinearModel& model,
                  const VarianceModel& variance,
                  const ObservationTerms& terms,
                  const std::vector<Index>& random,
                  bool with_slopes)
      : GroupSums(model, random),
        rows_(model, variance, this->random()),
        tasks_(terms, with_slopes, rows_) {
    has_approximation_ = !terms.approximation.empty();
    holds_weights_ = !terms.own_weight.empty();
    others_ = terms.others;
  }

  void set_point(const ObservationPoint& point) override { rows_.set_point(point); }
  void density(Index first,
               Index last,
               const MatrixXd& effects,
               MatrixXd& sums,
               Workspace& workspace,
               HeldWeights* weights) const override {
    rows_.sum(tasks_.density,
              {.effects = effects, .first = first, .held = weights},
              last,
              sums,
              workspace);
  }
  void mixed(Index first,
             Index last,
             const MatrixXd& effects,
             MatrixXd& sums,
             Workspace& workspace) const override {
    sums.setZero(0, last - first);
    if (tasks_.mixed.outputs == 0) return;
    rows_.sum(tasks_.mixed, {.effects = effects, .first = first}, last, sums, workspace);
  }
  void slopes(Index first,
              Index last,
              const MatrixXd& effects,
              MatrixXd& sums,
              Workspace& workspace) const override {
    rows_.sum(tasks_.slopes, {.effects = effects, .first = first}, last, sums, workspace);
  }
  void total(Index first,
             Index last,
             const MatrixXd& effects,
             const MatrixXd& weights,
             MatrixXd& sums,
             Workspace& workspace) const override {
    rows_.sum(tasks_.total,
              {.effects = effects, .weights = &weights, .first = first},
              last,
              sums,
              workspace);
  }

 private:
  ObservationRows rows_;
  TermTasks tasks_;
};

}  // namespace

GroupSums::GroupSums(const NonlinearModel& model, const std::vector<Index>& random)
    : DensitySums(random), model_(model) {
  has_kinks_ = std::ranges::any_of(random, [&](Index j) { return model.has_kink_in(j); });
}

TermTasks::TermTasks(const ObservationTerms& terms, bool with_slopes, ObservationRows& rows) {
  std::vector<Expression> outputs{terms.density};
  append(outputs, terms.by_random);
  append(outputs, terms.curvature);
  append(outputs, terms.approximation);
  append(outputs, terms.own_weight);
  density = rows.task_of(outputs);
  if (!with_slopes) {
    mixed = rows.task_of(terms.other_random);
    return;
  }

  outputs = {terms.density};
  append(outputs, terms.density_by_fixed);
  append(outputs, terms.density_by_variance);
  slopes = rows.task_of(outputs);

  outputs = terms.penalty_by_random;
  append(outputs, terms.by_other);
  append(outputs, terms.by_variance);
  append(outputs, terms.other_random);
  append(outputs, terms.variance_random);
  total = rows.task_of(outputs);
}

std::unique_ptr<GroupSums> make_group_sums(const NonlinearModel& model,
                                           const VarianceModel& variance,
                                           Curvature curvature,
                                           const std::vector<Index>& random,
                                           bool with_slopes) {
  const ObservationTerms terms = with_slopes ? observation_terms(model, variance, curvature, random)
                                             : mode_terms(model, variance, curvature, random);
  if (variance.correlated() != nullptr) {
    return std::make_unique<CorrelatedSums>(model, variance, curvature, terms, random, with_slopes);
  }
  return std::make_unique<ObservationSums>(model, variance, terms, random, with_slopes);
}

}  // namespace silvafit::fit
