// SPDX-License-Identifier: MIT
#include "silvafit/fit/residuals.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "model/nested_terms.hpp"
#include "result/group_coefficients.hpp"
#include "result/nested_effects.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Subtracts from each row of a cluster its expectation given the rows before: the rows of L^-1 e,
/// without forming the covariance. The effects given the rows so far are normal with mean m and
/// covariance P; those of a finer group are reset at its start.
class Decorrelation {
 public:
  Decorrelation(const FittedModel& fit, const NonlinearModel& model)
      : model_(model),
        outer_(model.coefficients_of(coarser_term(fit.specification))),
        inner_(model.coefficients_of(finer_term(fit.specification))),
        outer_covariance_(coarser(fit).covariance),
        inner_covariance_(finer(fit).covariance) {}

  /// \param errors    (N) residuals of the linear model, in the model's order
  /// \param slopes    (N x p)
  /// \param variance  (N) of the residuals given the effects
  VectorXd apply(const VectorXd& errors, const MatrixXd& slopes, const VectorXd& variance) {
    VectorXd result(errors.size());
    for (Index cluster = 0; cluster < model_.cluster_count(); ++cluster) {
      begin_cluster();
      for (Index g = model_.cluster_begin(cluster); g < model_.cluster_begin(cluster + 1); ++g) {
        begin_group();
        for (Index i = model_.group_begin(g); i < model_.group_begin(g + 1); ++i) {
          result[i] = next(errors[i], slopes.row(i), variance[i]);
        }
      }
    }
    return result;
  }

 private:
  Index outer_count() const { return static_cast<Index>(outer_.size()); }
  Index inner_count() const { return static_cast<Index>(inner_.size()); }

  void begin_cluster() {
    const Index size = outer_count() + inner_count();
    mean_.setZero(size);
    covariance_.setZero(size, size);
    if (outer_count() > 0) {
      covariance_.topLeftCorner(outer_count(), outer_count()) = outer_covariance_;
    }
  }

  void begin_group() {
    const Index q = inner_count();
    mean_.tail(q).setZero();
    covariance_.rightCols(q).setZero();
    covariance_.bottomRows(q).setZero();
    if (q > 0) covariance_.bottomRightCorner(q, q) = inner_covariance_;
  }

  double next(double error, const Eigen::RowVectorXd& slopes, double variance) {
    VectorXd z(mean_.size());
    z << slopes(outer_).transpose(), slopes(inner_).transpose();
    const VectorXd covariance = covariance_ * z;
    const double total = z.dot(covariance) + variance;
    const double innovation = error - z.dot(mean_);
    mean_ += covariance * (innovation / total);
    covariance_ -= covariance * covariance.transpose() / total;
    return innovation / std::sqrt(total);
  }

  const NonlinearModel& model_;
  std::vector<Index> outer_;
  std::vector<Index> inner_;
  MatrixXd outer_covariance_;
  MatrixXd inner_covariance_;
  VectorXd mean_;
  MatrixXd covariance_;
};

std::vector<std::string> group_labels(const NonlinearModel& model) {
  std::vector<std::string> labels(static_cast<std::size_t>(model.observations()));
  if (model.specification().random.empty()) return labels;
  for (Index g = 0; g < model.group_count(); ++g) {
    for (Index i = model.group_begin(g); i < model.group_begin(g + 1); ++i) {
      labels[static_cast<std::size_t>(i)] = model.group_labels()[static_cast<std::size_t>(g)];
    }
  }
  return labels;
}

/// Sorts results in the order of the table's rows.
class TableOrder {
 public:
  explicit TableOrder(const std::vector<std::size_t>& rows) : order_(rows.size()) {
    std::iota(order_.begin(), order_.end(), Index{0});
    std::ranges::sort(order_, {}, [&](Index i) { return rows[static_cast<std::size_t>(i)]; });
  }
  void apply(VectorXd& values) const { values = values(order_).eval(); }
  template <typename Value>
  void apply(std::vector<Value>& values) const {
    std::vector<Value> sorted;
    for (const Index i : order_) sorted.push_back(values[static_cast<std::size_t>(i)]);
    values = std::move(sorted);
  }

 private:
  std::vector<Index> order_;
};

LevelResiduals level(const VectorXd& observed, VectorXd fitted, const VectorXd& deviation) {
  const VectorXd raw = observed - fitted;
  return {.fitted = std::move(fitted), .raw = raw, .standardized = raw.cwiseQuotient(deviation)};
}

}  // namespace

Residuals residuals(const FittedModel& fit, const data::Table& table) {
  const NonlinearModel model(fit.specification, table);
  const data::Table rows = table.select(model.rows());
  NonlinearModel::Workspace workspace;
  VectorXd population;
  model.evaluate(fit.estimate, population, nullptr, workspace);
  const MatrixXd effects = coefficient_effects(fit, model);
  VectorXd conditional;
  MatrixXd slopes;
  model.evaluate(effects.colwise() + fit.estimate, conditional, &slopes, workspace);
  const VectorXd deviation = fit.residual_sd(conditional, rows);

  Residuals result{.rows = model.rows(), .group = group_labels(model)};
  result.observed = model.response();
  VectorXd errors = result.observed - conditional;
  for (Index g = 0; g < model.group_count(); ++g) {
    const Index begin = model.group_begin(g);
    const Index size = model.group_begin(g + 1) - begin;
    errors.segment(begin, size) += slopes.middleRows(begin, size) * effects.col(g);
  }
  result.marginal = Decorrelation(fit, model).apply(errors, slopes, deviation.cwiseAbs2());
  result.population = level(result.observed, std::move(population), deviation);
  result.conditional = level(result.observed, std::move(conditional), deviation);
  result.normalized = result.conditional.standardized;

  const TableOrder order(model.rows());
  for (LevelResiduals* const one : {&result.population, &result.conditional}) {
    order.apply(one->fitted);
    order.apply(one->raw);
    order.apply(one->standardized);
  }
  order.apply(result.rows);
  order.apply(result.group);
  order.apply(result.observed);
  order.apply(result.normalized);
  order.apply(result.marginal);
  return result;
}

}  // namespace silvafit::fit
