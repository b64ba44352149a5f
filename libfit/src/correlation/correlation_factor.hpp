// SPDX-License-Identifier: MIT
// The factor L of the correlation R = L L' of one group of rows.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace silvafit::fit {

/// L of n rows, and its derivatives by m parameters. One caller at a time.
class CorrelationFactor {
 public:
  virtual ~CorrelationFactor() = default;
  CorrelationFactor(const CorrelationFactor&) = delete;
  CorrelationFactor& operator=(const CorrelationFactor&) = delete;

  /// Replaces the columns X (n x c) by L^-1 X.
  virtual void whiten(Eigen::Ref<Eigen::MatrixXd> columns) const = 0;
  /// Replaces them by L'^-1 X.
  virtual void whiten_transposed(Eigen::Ref<Eigen::MatrixXd> columns) const = 0;
  /// Replaces them by L X.
  virtual void color(Eigen::Ref<Eigen::MatrixXd> columns) const = 0;
  /// (n x c) D for U = L^-1 X: the derivative of X'R^-1 X by parameter k is U'D + D'U.
  virtual Eigen::MatrixXd slope(Eigen::Index k, const Eigen::MatrixXd& whitened) const = 0;
  /// (n x c) Q X for Q = R^-1 times R, element by element.
  virtual Eigen::MatrixXd times_expected(const Eigen::MatrixXd& columns) const = 0;
  /// tr(X' dQ Y) for the derivative of Q by parameter k.
  virtual double expected_slope(Eigen::Index k,
                                const Eigen::MatrixXd& x,
                                const Eigen::MatrixXd& y) const = 0;

  double log_determinant() const { return log_determinant_; }        ///< log|L|
  const Eigen::VectorXd& log_slopes() const { return log_slopes_; }  ///< (m) of log|L|

 protected:
  CorrelationFactor() = default;
  double log_determinant_ = 0.0;
  Eigen::VectorXd log_slopes_{};
};

/// Of a process whose rows depend on the row before only.
/// \param before  (n) correlation with the row before; the first is not used
/// \param slopes  (n x m) its derivatives
/// \returns null if a correlation is not inside (-1, 1)
std::unique_ptr<CorrelationFactor> markov_factor(Eigen::VectorXd before, Eigen::MatrixXd slopes);

/// By Cholesky's factorization.
/// \param correlation  (n x n)
/// \param slopes       (n x n) its m derivatives
/// \returns null if it is not positive definite
std::unique_ptr<CorrelationFactor> dense_factor(const Eigen::MatrixXd& correlation,
                                                std::vector<Eigen::MatrixXd> slopes);

}  // namespace silvafit::fit
