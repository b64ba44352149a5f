// SPDX-License-Identifier: MIT
#include "silvafit/fit/term_tests.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <utility>

#include "model/sub_model_terms.hpp"
#include "silvafit/base/constants.hpp"
#include "text/text_parts.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;

/// A factor of a product as it is written, or its column if it is the comparison with a level.
std::string without_level(std::string_view variable, const std::vector<std::string>& factors) {
  const std::vector<std::string> names = data::Expression::parse(variable).variables();
  data::TextMatch match;
  const bool is_level = names.size() == 1 && data::is_text_match(names[0], match) &&
                        std::ranges::find(factors, match.column) != factors.end();
  return is_level ? match.column : std::string(variable);
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

TermTest tested(std::string term, const std::vector<Index>& at, const FittedModel& fit) {
  TermTest test{.term = std::move(term), .numerator_df = static_cast<int>(at.size())};
  const Eigen::VectorXd estimate = fit.estimate(at);
  const Eigen::MatrixXd covariance = fit.covariance(at, at);
  test.f = estimate.dot(covariance.llt().solve(estimate)) / test.numerator_df;
  test.denominator_df = fit.degrees_of_freedom.size() == fit.estimate.size()
                            ? fit.degrees_of_freedom(at).minCoeff()
                            : kNaN;
  const bool is_known = std::isfinite(test.f) && test.denominator_df > 0.0;
  test.p = kNaN;
  if (is_known) {
    const boost::math::fisher_f_distribution<double> f(test.numerator_df, test.denominator_df);
    test.p = boost::math::cdf(boost::math::complement(f, std::max(test.f, 0.0)));
  }
  return test;
}

}  // namespace

std::vector<TermTest> term_tests(const FittedModel& fit) {
  const std::vector<std::string> terms = terms_of(fit.specification);
  const Eigen::VectorXd errors = fit.standard_errors();
  std::vector<std::pair<std::string, std::vector<Index>>> found;
  for (Index k = 0; k < errors.size(); ++k) {
    if (!(errors[k] > 0.0)) continue;
    const std::string& term = terms[static_cast<std::size_t>(k)];
    auto entry = std::ranges::find(found, term, [](const auto& one) { return one.first; });
    if (entry == found.end()) entry = found.insert(entry, {term, {}});
    entry->second.push_back(k);
  }
  std::vector<TermTest> tests;
  for (auto& [term, at] : found) tests.push_back(tested(std::move(term), at, fit));
  return tests;
}

}  // namespace silvafit::fit
