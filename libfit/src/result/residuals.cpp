// SPDX-License-Identifier: MIT
#include "silvafit/fit/residuals.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "model/correlated_rows.hpp"
#include "result/group_coefficients.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {
namespace {

/// Subtracts from each row of a cluster its expectation given the rows before: the rows of L^-1 e,
/// without forming the covariance. The effects given the rows so far are normal with mean m and
/// covariance P; those of a term are reset at the start of each of its groups.
class Decorrelation {
 public:
  Decorrelation(const FittedModel& fit, const NonlinearModel& model)
      : model_(model), covariances_(covariances_of(fit)), begins_{0} {
    for (const std::vector<Index>& places : model.random_coefficients()) {
      places_.insert(places_.end(), places.begin(), places.end());
      begins_.push_back(std::ssize(places_));
    }
    mean_.setZero(begins_.back());
    covariance_.setZero(begins_.back(), begins_.back());
  }

  /// \param errors    (N) residuals of the linear model, in the model's order
  /// \param slopes    (N x p)
  /// \param variance  (N) of the residuals given the effects
  VectorXd apply(const VectorXd& errors, const MatrixXd& slopes, const VectorXd& variance) {
    VectorXd result(errors.size());
    std::vector<Index> begun(covariances_.size(), 0);  // groups of each term
    for (Index g = 0; g < model_.group_count(); ++g) {
      for (std::size_t t = 0; t < begun.size(); ++t) {
        if (g != model_.first_group(t, begun[t])) continue;
        begin_group(t);
        ++begun[t];
      }
      for (Index i = model_.group_begin(g); i < model_.group_begin(g + 1); ++i) {
        result[i] = next(errors[i], slopes.row(i), variance[i]);
      }
    }
    return result;
  }

 private:
  void begin_group(std::size_t term) {
    const Index begin = begins_[term];
    const Index q = begins_[term + 1] - begin;
    mean_.segment(begin, q).setZero();
    covariance_.middleCols(begin, q).setZero();
    covariance_.middleRows(begin, q).setZero();
    covariance_.block(begin, begin, q, q) = covariances_[term];
  }

  double next(double error, const Eigen::RowVectorXd& slopes, double variance) {
    const VectorXd z = slopes(places_).transpose();
    const VectorXd covariance = covariance_ * z;
    const double total = z.dot(covariance) + variance;
    const double innovation = error - z.dot(mean_);
    mean_ += covariance * (innovation / total);
    covariance_ -= covariance * covariance.transpose() / total;
    return innovation / std::sqrt(total);
  }

  const NonlinearModel& model_;
  std::vector<MatrixXd> covariances_;  ///< Psi of each term
  std::vector<Index> places_;          ///< coefficients with effects of all terms
  std::vector<Index> begins_;          ///< of each term among these, and the end
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
  void apply(MatrixXd& values) const { values = values(order_, order_).eval(); }
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

/// A fit at its estimates with random effects, on the rows of a table in the model's order.
struct Linearized {
  Linearized(const FittedModel& fit, const data::Table& table) : model(fit.specification, table) {
    effects = coefficient_effects(fit, model);
    NonlinearModel::Curve at = model.curve_at(effects.colwise() + fit.estimate);
    conditional = std::move(at.mean);
    slopes = std::move(at.jacobian);
    deviation = fit.residual_sd(conditional, table.select(model.rows()));
  }

  NonlinearModel model;
  MatrixXd effects{};      ///< (p x G)
  VectorXd conditional{};  ///< (N)
  MatrixXd slopes{};       ///< (N x p)
  VectorXd deviation{};    ///< (N)
};

}  // namespace

Residuals residuals(const FittedModel& fit, const data::Table& table) {
  auto [model, effects, conditional, slopes, deviation] = Linearized(fit, table);
  VectorXd population = model.mean_at(fit.estimate);

  Residuals result{.rows = model.rows(), .group = group_labels(model)};
  result.observed = model.response();
  VectorXd errors = result.observed - conditional;
  for (Index g = 0; g < model.group_count(); ++g) {
    const Index begin = model.group_begin(g);
    const Index size = model.group_begin(g + 1) - begin;
    errors.segment(begin, size) += slopes.middleRows(begin, size) * effects.col(g);
  }
  VectorXd scale = deviation;
  result.population = level(result.observed, std::move(population), deviation);
  result.conditional = level(result.observed, std::move(conditional), deviation);
  result.normalized = result.conditional.standardized;
  if (fit.variance.correlation) {
    // In units of their standard deviation and correlation the residuals are independent.
    MatrixXd columns(errors.size(), slopes.cols() + 2);
    columns << errors, result.conditional.raw, slopes;
    columns = (deviation.cwiseInverse().asDiagonal() * columns).eval();
    whiten(model, fit.variance, columns);
    errors = columns.col(0);
    result.normalized = columns.col(1);
    slopes = columns.rightCols(slopes.cols()).eval();
    scale.setOnes();
  }
  // All rows of crossed groups depend on each other.
  result.marginal = model.crossed() != nullptr
                        ? VectorXd::Constant(errors.size(), kNaN)
                        : Decorrelation(fit, model).apply(errors, slopes, scale.cwiseAbs2());

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

MatrixXd response_covariance(const FittedModel& fit, const data::Table& table, bool is_marginal) {
  const Linearized at(fit, table);
  const NonlinearModel& model = at.model;
  if (model.crossed() != nullptr) {
    throw UsageError("all responses of crossed groups depend on each other");
  }
  const Index count = model.observations();
  MatrixXd root = MatrixXd::Identity(count, count);
  if (const auto& correlation = fit.variance.correlation; correlation && count > 1) {
    const auto correlated = CorrelatedRows::of(model, &*correlation);
    correlated->change(correlated->factors(*correlation),
                       root,
                       [](const CorrelationFactor& factor, MatrixXd& part) { factor.color(part); });
  }
  root = at.deviation.asDiagonal() * root;
  MatrixXd result = root * root.transpose();
  const std::vector<MatrixXd> covariances = covariances_of(fit);
  const std::vector<std::vector<Index>> places = model.random_coefficients();
  for (std::size_t t = 0; is_marginal && t < places.size(); ++t) {
    for (Index k = 0; k < model.group_count(t); ++k) {
      const Index begin = model.group_begin(model.first_group(t, k));
      const bool is_last = k + 1 == model.group_count(t);
      const Index end = is_last ? count : model.group_begin(model.first_group(t, k + 1));
      const MatrixXd z = at.slopes(Eigen::seq(begin, end - 1), places[t]);
      result.block(begin, begin, end - begin, end - begin) += z * covariances[t] * z.transpose();
    }
  }
  TableOrder(model.rows()).apply(result);
  return result;
}

}  // namespace silvafit::fit
