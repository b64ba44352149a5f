// SPDX-License-Identifier: MIT
#include "silvafit/fit/term_tests.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <utility>

#include "model/sub_model_terms.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"
#include "text/text_parts.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;

/// A factor of a product as it is written, or its column if it compares only this with levels: one
/// level, or a column of a contrast matrix, which is a sum of them.
std::string without_level(std::string_view variable, const std::vector<std::string>& factors) {
  std::string column;
  for (const std::string& name : data::Expression::parse(variable).variables()) {
    data::TextMatch match;
    const bool is_level = data::is_text_match(name, match) &&
                          std::ranges::find(factors, match.column) != factors.end() &&
                          (column.empty() || match.column == column);
    if (!is_level) return std::string(variable);
    column = match.column;
  }
  return column.empty() ? std::string(variable) : column;
}

/// The term of each coefficient.
std::vector<std::string> terms_of(const ModelSpecification& specification) {
  std::vector<std::string> terms;
  for (const ParameterModel& parameter : specification.parameters) {
    if (parameter.has_intercept) terms.push_back(parameter.name);
    for (const Covariate& covariate : parameter.covariates) {
      std::vector<std::string> variables{parameter.name};
      for (const Part part : split(covariate.label, 0, covariate.label.size(), ':')) {
        variables.push_back(without_level(of(covariate.label, part), specification.factors));
      }
      terms.push_back(product_label(variables));
    }
  }
  return terms;
}

/// The coefficients that have a standard error, with their terms.
struct Tested {
  std::vector<Index> at{};           ///< (K) places of the coefficients
  std::vector<std::size_t> term{};   ///< (K) of each
  std::vector<std::string> names{};  ///< of the terms
};

Tested tested_coefficients(const FittedModel& fit) {
  const std::vector<std::string> terms = terms_of(fit.specification);
  const Eigen::VectorXd errors = fit.standard_errors();
  Tested result;
  for (Index k = 0; k < errors.size(); ++k) {
    if (!(errors[k] > 0.0)) continue;
    const std::string& term = terms[static_cast<std::size_t>(k)];
    const auto known = std::ranges::find(result.names, term);
    result.at.push_back(k);
    result.term.push_back(static_cast<std::size_t>(known - result.names.begin()));
    if (known == result.names.end()) result.names.push_back(term);
  }
  return result;
}

/// The test of combinations of coefficients.
/// \param at  of the coefficients that are the columns
/// \param of  of those whose degrees of freedom count
/// \param values  of the combinations; none: 0
TermTest tested(std::string term,
                const Eigen::MatrixXd& combinations,
                const std::vector<Index>& at,
                const std::vector<Index>& of,
                const FittedModel& fit,
                const Eigen::VectorXd& values = {}) {
  TermTest test{.term = std::move(term), .numerator_df = static_cast<int>(combinations.rows())};
  Eigen::VectorXd value = combinations * fit.estimate(at);
  if (values.size() > 0) value -= values;
  const Eigen::MatrixXd covariance =
      combinations * fit.covariance(at, at) * combinations.transpose();
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  test.f =
      factor.info() == Eigen::Success ? value.dot(factor.solve(value)) / test.numerator_df : kNaN;
  test.denominator_df = kNaN;
  if (fit.degrees_of_freedom.size() == fit.estimate.size()) {
    test.denominator_df = fit.degrees_of_freedom(of).minCoeff();
  }
  const bool is_known = std::isfinite(test.f) && test.denominator_df > 0.0;
  test.p = kNaN;
  if (is_known) {
    const boost::math::fisher_f_distribution<double> f(test.numerator_df, test.denominator_df);
    test.p = boost::math::cdf(boost::math::complement(f, std::max(test.f, 0.0)));
  }
  return test;
}

/// The rows of the tested coefficients that belong to terms.
std::vector<Index> rows_of(const std::vector<std::size_t>& terms, const Tested& all) {
  std::vector<Index> rows;
  for (std::size_t k = 0; k < all.at.size(); ++k) {
    if (std::ranges::find(terms, all.term[k]) != terms.end()) rows.push_back(static_cast<Index>(k));
  }
  return rows;
}

/// \param whole  (K x K) combinations of all tested coefficients, of which those of the terms count
TermTest test_of_terms(std::string name,
                       const std::vector<std::size_t>& terms,
                       const Eigen::MatrixXd& whole,
                       const Tested& all,
                       const FittedModel& fit) {
  const std::vector<Index> rows = rows_of(terms, all);
  std::vector<Index> of;
  for (const Index row : rows) of.push_back(all.at[static_cast<std::size_t>(row)]);
  return tested(std::move(name), whole(rows, Eigen::all), all.at, of, fit);
}

Eigen::MatrixXd unit(const Tested& all) {
  const auto size = static_cast<Index>(all.at.size());
  return Eigen::MatrixXd::Identity(size, size);
}

/// Combinations of each coefficient with those after it that are not correlated with each other:
/// the upper Cholesky factor of the information.
Eigen::MatrixXd uncorrelated(const Tested& all, const FittedModel& fit) {
  const Eigen::MatrixXd information = fit.covariance(all.at, all.at).llt().solve(unit(all));
  return information.llt().matrixU();
}

/// A combination as it is written, "2*a - b = 3".
std::string restriction_text(const Eigen::RowVectorXd& combination,
                             double value,
                             const std::vector<std::string>& names) {
  std::string text;
  for (Index k = 0; k < combination.size(); ++k) {
    const double factor = combination[k];
    if (factor == 0.0) continue;
    text += text.empty() ? (factor < 0.0 ? "-" : "") : (factor < 0.0 ? " - " : " + ");
    if (std::abs(factor) != 1.0) text += data::shortest(std::abs(factor)) + "*";
    text += names[static_cast<std::size_t>(k)];
  }
  return fmt::format("{} = {}", text, value + 0.0);  // no -0
}

/// Refuses combinations that follow from others, or contradict them, in the metric of the standard
/// errors, so that units have no effect.
/// \param values  empty: 0
void require_independent(const Eigen::MatrixXd& combinations,
                         const Eigen::VectorXd& values,
                         const FittedModel& fit) {
  constexpr double kRounding = 1e-9;  // of factors that users compute, such as 1.0/3
  const auto value_of = [&values](Index i) { return values.size() > 0 ? values[i] : 0.0; };
  const Eigen::VectorXd errors = fit.standard_errors();
  Eigen::MatrixXd scaled =
      combinations * errors.array().isFinite().select(errors, 0.0).matrix().asDiagonal();
  const Eigen::VectorXd scale = scaled.rowwise().norm();
  for (Index i = 0; i < scaled.rows(); ++i) {
    if (!(scale[i] > 0.0)) throw UsageError("a combination has no coefficient other than 0");
    scaled.row(i) /= scale[i];
  }
  for (Index i = 1; i < scaled.rows(); ++i) {
    const Eigen::MatrixXd before = scaled.topRows(i).transpose();
    const Eigen::VectorXd weights = before.colPivHouseholderQr().solve(scaled.row(i).transpose());
    if ((before * weights - scaled.row(i).transpose()).norm() > kRounding) continue;
    std::vector<std::string> others;
    double implied = 0.0;
    double size = std::abs(value_of(i)) / scale[i];
    for (Index j = 0; j < i; ++j) {
      if (std::abs(weights[j]) <= kRounding) continue;
      const double part = weights[j] * value_of(j) / scale[j];
      implied += part;
      size += std::abs(part);
      others.push_back(restriction_text(combinations.row(j), value_of(j), fit.coefficient_names));
    }
    const bool follows = std::abs(implied - value_of(i) / scale[i]) <= kRounding * size;
    throw UsageError(
        fmt::format("'{}' {} '{}'; omit one of them",
                    restriction_text(combinations.row(i), value_of(i), fit.coefficient_names),
                    follows ? "follows from" : "contradicts",
                    fmt::join(others, "' and '")));
  }
}

}  // namespace

std::vector<TermTest> term_tests(const FittedModel& fit, TermOrder order) {
  const Tested all = tested_coefficients(fit);
  std::vector<TermTest> tests;
  if (all.at.empty()) return tests;
  const Eigen::MatrixXd whole = order == TermOrder::kMarginal ? unit(all) : uncorrelated(all, fit);
  for (std::size_t term = 0; term < all.names.size(); ++term) {
    tests.push_back(test_of_terms(all.names[term], {term}, whole, all, fit));
  }
  return tests;
}

TermTest joint_test(const FittedModel& fit, const std::vector<std::size_t>& terms) {
  const Tested all = tested_coefficients(fit);
  for (const std::size_t term : terms) {
    if (term >= all.names.size()) throw UsageError(fmt::format("there is no term {}", term));
  }
  return test_of_terms("combined", terms, unit(all), all, fit);
}

TermTest joint_test(const FittedModel& fit,
                    const Eigen::MatrixXd& combinations,
                    const Eigen::VectorXd& values) {
  std::vector<Index> at;
  const Eigen::VectorXd errors = fit.standard_errors();
  for (Index k = 0; k < combinations.cols(); ++k) {
    if (combinations.col(k).isZero(0.0)) continue;
    if (!(errors[k] > 0.0)) {
      throw UsageError(fmt::format("{} has no standard error, so that it cannot be tested",
                                   fit.coefficient_names[static_cast<std::size_t>(k)]));
    }
    at.push_back(k);
  }
  require_independent(combinations, values, fit);
  return tested("combined", combinations(Eigen::all, at), at, at, fit, values);
}

}  // namespace silvafit::fit
