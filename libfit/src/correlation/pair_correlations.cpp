// SPDX-License-Identifier: MIT
#include "correlation/pair_correlations.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/AutoDiff>
#include <utility>
#include <vector>

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = Correlation::Kind;
/// A number with its derivatives by all parameters.
using Number = Eigen::AutoDiffScalar<VectorXd>;

std::vector<Number> variables(const VectorXd& parameters) {
  std::vector<Number> result;
  for (Index k = 0; k < parameters.size(); ++k) {
    result.emplace_back(parameters[k], parameters.size(), k);
  }
  return result;
}

class FirstOrder : public PairCorrelation {
 public:
  FirstOrder(double phi, double by_parameter) : phi_(phi), by_parameter_(by_parameter) {}

  double between(double distance, double, double, double* slopes) const override {
    if (slopes != nullptr) {
      *slopes = distance == 0.0 ? 0.0 : distance * std::pow(phi_, distance - 1.0) * by_parameter_;
    }
    return std::pow(phi_, distance);
  }

 private:
  double phi_;
  double by_parameter_;
};

class ByDistance : public PairCorrelation {
 public:
  ByDistance(Kind kind, double range, double nugget, bool is_free)
      : kind_(kind), range_(range), nugget_(nugget), is_free_(is_free) {}

  double between(double distance, double, double, double* slopes) const override {
    const double h = distance / range_;
    double value = 0.0;
    double by_log_range = 0.0;
    switch (kind_) {
      case Kind::kGaussian:
        value = std::exp(-h * h);
        by_log_range = 2.0 * h * h * value;
        break;
      case Kind::kSpherical:
        if (h < 1.0) {
          value = 1.0 - 1.5 * h + 0.5 * h * h * h;
          by_log_range = 1.5 * h * (1.0 - h * h);
        }
        break;
      case Kind::kRationalQuadratic:
        value = 1.0 / (1.0 + h * h);
        by_log_range = 2.0 * h * h * value * value;
        break;
      case Kind::kLinear:
        if (h < 1.0) {
          value = 1.0 - h;
          by_log_range = h;
        }
        break;
      default:
        value = std::exp(-h);
        by_log_range = h * value;
    }
    const double share = std::isnan(nugget_) ? 1.0 : 1.0 - nugget_;
    if (slopes != nullptr) {
      slopes[0] = is_free_ ? share * by_log_range : 0.0;
      if (!std::isnan(nugget_)) slopes[1] = -nugget_ * share * value;
    }
    return share * value;
  }

 private:
  Kind kind_;
  double range_;
  double nugget_;
  bool is_free_;
};

class CompoundSymmetry : public PairCorrelation {
 public:
  CompoundSymmetry(double rho, double low) : rho_(rho), low_(low) {}

  double between(double, double, double, double* slopes) const override {
    if (slopes != nullptr) *slopes = (rho_ - low_) * (1.0 - rho_) / (1.0 - low_);
    return rho_;
  }

 private:
  double rho_;
  double low_;
};

/// Correlations in a table.
class Tabulated : public PairCorrelation {
 public:
  /// \param times  of a symmetric structure; 0: the table is by distance
  Tabulated(std::vector<Number> table, Index times) : table_(std::move(table)), times_(times) {}

  double between(double distance, double first, double second, double* slopes) const override {
    const double place = times_ == 0 ? distance : first * static_cast<double>(times_) + second;
    const Number& of = table_[static_cast<std::size_t>(std::lround(place))];
    if (slopes != nullptr) {
      Eigen::Map<VectorXd>(slopes, of.derivatives().size()) = of.derivatives();
    }
    return of.value();
  }

 private:
  std::vector<Number> table_;
  Index times_;
};

/// tanh(x/2)
template <typename Scalar>
Scalar correlation_of(const Scalar& x) {
  using std::exp;
  return Scalar(1.0) - Scalar(2.0) / (exp(x) + Scalar(1.0));
}

/// Coefficients of a stationary autoregression from partial autocorrelations.
template <typename Scalar>
std::vector<Scalar> from_partials(const std::vector<Scalar>& partials) {
  std::vector<Scalar> result;
  for (const Scalar& last : partials) {
    const std::vector<Scalar> before = result;
    for (std::size_t j = 0; j < before.size(); ++j) {
      result[j] = before[j] - last * before[before.size() - 1 - j];
    }
    result.push_back(last);
  }
  return result;
}

std::vector<double> partials_of(std::vector<double> coefficients) {
  std::vector<double> result(coefficients.size());
  while (!coefficients.empty()) {
    const double last = coefficients.back();
    result[coefficients.size() - 1] = last;
    coefficients.pop_back();
    const std::vector<double> before = coefficients;
    for (std::size_t j = 0; j < before.size(); ++j) {
      coefficients[j] = (before[j] + last * before[before.size() - 1 - j]) / (1.0 - last * last);
    }
  }
  return result;
}

/// phi, then theta; an invertible moving average has the coefficients of an autoregression with
/// the other sign.
template <typename Scalar>
std::pair<std::vector<Scalar>, std::vector<Scalar>> coefficients_of(
    const Correlation& correlation, const std::vector<Scalar>& parameters) {
  std::vector<Scalar> first;
  std::vector<Scalar> second;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const bool is_first = static_cast<int>(k) < correlation.autoregressive;
    const Scalar partial = correlation_of(parameters[k]);
    is_first ? first.push_back(partial) : second.push_back(Scalar(-partial));
  }
  first = from_partials(first);
  second = from_partials(second);
  for (Scalar& of : second) of = -of;
  return {first, second};
}

/// gamma(0..longest)/gamma(0). The first p + 1 autocovariances solve gamma(k) - sum phi_i gamma(|k
/// - i|) = sum theta_j psi_(j - k), the others follow by the recursion.
std::vector<Number> autocorrelations(const Correlation& correlation,
                                     const VectorXd& parameters,
                                     std::size_t longest) {
  const auto [phi, theta] = coefficients_of(correlation, variables(parameters));
  const std::size_t p = phi.size();
  const std::size_t q = theta.size();
  const Number zero(0.0, VectorXd::Zero(parameters.size()));
  const auto theta_at = [&, &ma = theta](std::size_t j) {
    return j == 0 ? Number(1.0, VectorXd::Zero(parameters.size())) : ma[j - 1];
  };
  std::vector<Number> psi;
  for (std::size_t k = 0; k <= q; ++k) {
    Number sum = theta_at(k);
    for (std::size_t i = 1; i <= std::min(p, k); ++i) sum += phi[i - 1] * psi[k - i];
    psi.push_back(sum);
  }
  const auto right = [&](std::size_t k) {
    Number sum = zero;
    for (std::size_t j = k; j <= q; ++j) sum += theta_at(j) * psi[j - k];
    return sum;
  };
  const auto size = static_cast<Index>(p) + 1;
  // The derivative of the solution x of A x = b is A^-1 (db - dA x).
  MatrixXd system = MatrixXd::Identity(size, size);
  std::vector<MatrixXd> system_slopes(static_cast<std::size_t>(parameters.size()),
                                      MatrixXd::Zero(size, size));
  VectorXd sides(size);
  MatrixXd side_slopes(size, parameters.size());
  for (Index k = 0; k < size; ++k) {
    const Number side = right(static_cast<std::size_t>(k));
    sides[k] = side.value();
    side_slopes.row(k) = side.derivatives();
    for (std::size_t i = 1; i <= p; ++i) {
      const Index column = std::abs(k - static_cast<Index>(i));
      system(k, column) -= phi[i - 1].value();
      for (std::size_t m = 0; m < system_slopes.size(); ++m) {
        system_slopes[m](k, column) -= phi[i - 1].derivatives()[static_cast<Index>(m)];
      }
    }
  }
  const Eigen::PartialPivLU<MatrixXd> solver(system);
  const VectorXd first = solver.solve(sides);
  for (std::size_t m = 0; m < system_slopes.size(); ++m) {
    side_slopes.col(static_cast<Index>(m)) -= system_slopes[m] * first;
  }
  const MatrixXd slopes = solver.solve(side_slopes);
  std::vector<Number> gamma;
  for (std::size_t k = 0; k <= std::max(longest, p); ++k) {
    const auto at = static_cast<Index>(k);
    if (k <= p) {
      gamma.emplace_back(first[at], VectorXd(slopes.row(at)));
      continue;
    }
    Number sum = right(k);
    for (std::size_t i = 1; i <= p; ++i) sum += phi[i - 1] * gamma[k - i];
    gamma.push_back(sum);
  }
  const Number variance = gamma[0];
  for (Number& of : gamma) of = Number(of / variance);
  return gamma;
}

/// (times x times) L whose rows have length one, by angles.
template <typename Scalar>
std::vector<std::vector<Scalar>> rows_by_angles(Index times,
                                                const std::vector<Scalar>& parameters) {
  using std::cos;
  using std::exp;
  using std::sin;
  std::vector<std::vector<Scalar>> rows;
  std::size_t next = 0;
  for (Index i = 0; i < times; ++i) {
    std::vector<Scalar> row;
    Scalar rest = Scalar(1.0 + 0.0 * (parameters.empty() ? Scalar(0.0) : parameters[0]));
    for (Index j = 0; j < i; ++j) {
      const Scalar angle =
          Scalar(std::numbers::pi) / (Scalar(1.0) + exp(Scalar(-parameters[next++])));
      row.push_back(Scalar(rest * cos(angle)));
      rest = Scalar(rest * sin(angle));
    }
    row.push_back(rest);
    rows.push_back(std::move(row));
  }
  return rows;
}

/// (times x times) L L' by rows.
template <typename Scalar>
std::vector<Scalar> products_of(const std::vector<std::vector<Scalar>>& rows) {
  std::vector<Scalar> result;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t j = 0; j < rows.size(); ++j) {
      Scalar sum = Scalar(rows[i][0] * rows[j][0]);
      for (std::size_t k = 1; k <= std::min(i, j); ++k) sum += rows[i][k] * rows[j][k];
      result.push_back(sum);
    }
  }
  return result;
}

std::vector<double> numbers(const VectorXd& of) { return {of.begin(), of.end()}; }

}  // namespace

std::unique_ptr<PairCorrelation> first_order(double phi, double by_parameter) {
  return std::make_unique<FirstOrder>(phi, by_parameter);
}

std::unique_ptr<PairCorrelation> by_distance(Kind kind, double range, double nugget, bool is_free) {
  return std::make_unique<ByDistance>(kind, range, nugget, is_free);
}

std::unique_ptr<PairCorrelation> compound_symmetry(double rho, double low) {
  return std::make_unique<CompoundSymmetry>(rho, low);
}

std::unique_ptr<PairCorrelation> moving_average(const Correlation& correlation,
                                                const VectorXd& parameters,
                                                Index longest) {
  return std::make_unique<Tabulated>(
      autocorrelations(correlation, parameters, static_cast<std::size_t>(longest)), 0);
}

std::unique_ptr<PairCorrelation> symmetric(Index times, const VectorXd& parameters) {
  return std::make_unique<Tabulated>(products_of(rows_by_angles(times, variables(parameters))),
                                     times);
}

VectorXd arma_coefficients(const Correlation& correlation, const VectorXd& parameters) {
  auto [result, theta] = coefficients_of(correlation, numbers(parameters));
  result.insert(result.end(), theta.begin(), theta.end());
  return Eigen::Map<VectorXd>(result.data(), std::ssize(result));
}

VectorXd arma_parameters(const Correlation& correlation, const VectorXd& coefficients) {
  const Index p = correlation.autoregressive;
  std::vector<double> partials = partials_of(numbers(coefficients.head(p)));
  for (const double of : partials_of(numbers(-coefficients.tail(coefficients.size() - p)))) {
    partials.push_back(-of);
  }
  VectorXd result(coefficients.size());
  for (Index k = 0; k < result.size(); ++k) {
    result[k] = 2.0 * std::atanh(partials[static_cast<std::size_t>(k)]);
  }
  return result;
}

VectorXd symmetric_correlations(Index times, const VectorXd& parameters) {
  const std::vector<double> all = products_of(rows_by_angles(times, numbers(parameters)));
  VectorXd result(parameters.size());
  Index next = 0;
  for (Index i = 0; i < times; ++i) {
    for (Index j = i + 1; j < times; ++j) {
      result[next++] = all[static_cast<std::size_t>(i * times + j)];
    }
  }
  return result;
}

VectorXd symmetric_parameters(Index times, const VectorXd& correlations) {
  MatrixXd matrix = MatrixXd::Identity(times, times);
  Index next = 0;
  for (Index i = 0; i < times; ++i) {
    for (Index j = i + 1; j < times; ++j) matrix(i, j) = matrix(j, i) = correlations[next++];
  }
  const MatrixXd lower = matrix.llt().matrixL();
  VectorXd result(correlations.size());
  next = 0;
  for (Index i = 1; i < times; ++i) {
    double rest = 1.0;
    for (Index j = 0; j < i; ++j) {
      const double angle = std::acos(std::clamp(lower(i, j) / rest, -1.0, 1.0));
      rest *= std::sin(angle);
      result[next++] = std::log(angle / (std::numbers::pi - angle));
    }
  }
  return result;
}

}  // namespace silvafit::fit
