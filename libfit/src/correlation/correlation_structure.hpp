// SPDX-License-Identifier: MIT
// A correlation structure with unconstrained parameters, for the rows of any group.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "correlation/correlation_factor.hpp"
#include "silvafit/fit/correlation.hpp"

namespace silvafit::fit {

/// The correlation of two rows at given parameters.
class PairCorrelation {
 public:
  virtual ~PairCorrelation() = default;
  /// \param distance  between the rows; of a symmetric structure the numbers of their times are
  ///   used instead
  /// \param slopes    (m) result, its derivatives by the parameters; null: not needed
  virtual double between(double distance, double first, double second, double* slopes) const = 0;
};

/// What the parameters of a structure refer to.
struct CorrelationScale {
  double unit = 1.0;            ///< a typical smallest distance, one unit of range
  double farthest = 1.0;        ///< the largest distance
  bool is_even = true;          ///< all differences of times are, so that ar1 has no sign
  Eigen::Index largest = 2;     ///< rows of the largest group
  std::vector<double> times{};  ///< of a symmetric structure, ascending
};

class CorrelationStructure {
 public:
  CorrelationStructure(Correlation correlation, CorrelationScale scale);
  /// \param farthest  largest distance that is needed
  explicit CorrelationStructure(const CorrelationEstimate& estimate, double farthest = 1.0);

  const Correlation& correlation() const { return correlation_; }
  const CorrelationScale& scale() const { return scale_; }
  Eigen::Index parameter_count() const { return std::ssize(names_); }
  const std::vector<std::string>& names() const { return names_; }
  /// Points where a search can begin; the first is that of nearly independent rows.
  std::vector<Eigen::VectorXd> starts() const;

  /// Whether the range is so far above all distances that it is without bound: the likelihood is
  /// flat there.
  bool has_unbounded_range(const Eigen::VectorXd& parameters) const;

  /// Parameters away from a range, or a nugget, of 0 or a nugget of 1, where the likelihood has no
  /// slope.
  Eigen::VectorXd lifted(Eigen::VectorXd parameters) const;

  /// Parameters by nlme's definitions from unconstrained ones, and back.
  Eigen::VectorXd natural(const Eigen::VectorXd& parameters) const;
  Eigen::VectorXd unconstrained(const Eigen::VectorXd& natural) const;
  /// Whether each natural parameter is a function of its own unconstrained one.
  bool is_separable() const;
  /// The range of a natural parameter.
  std::pair<double, double> limits(Eigen::Index k) const;
  CorrelationEstimate estimate(const Eigen::VectorXd& parameters) const;

  /// The number of a time of a symmetric structure, -1 if it is none of the data; else the time.
  double place(double time) const;
  /// Whether rows depend on the row before only, so that a factor has linear cost.
  bool is_markov() const;
  std::unique_ptr<PairCorrelation> at(const Eigen::VectorXd& parameters) const;
  /// L of a group.
  /// \param places  (n x d) times or coordinates, as place() has them; of one column in ascending
  ///   order
  /// \param of      at(parameters)
  /// \returns null if it is singular
  std::unique_ptr<CorrelationFactor> factor(const Eigen::MatrixXd& places,
                                            const PairCorrelation& of) const;

 private:
  /// Whether the first parameter is the logarithm of a range, in units.
  bool has_range() const;

  Correlation correlation_;
  CorrelationScale scale_;
  std::vector<std::string> names_;
};

}  // namespace silvafit::fit
