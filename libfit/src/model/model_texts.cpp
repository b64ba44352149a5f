// SPDX-License-Identifier: MIT
#include "silvafit/fit/model_texts.hpp"

#include <fmt/format.h>

#include "silvafit/base/error.hpp"
#include "silvafit/data/checked_columns.hpp"

namespace silvafit::fit {
namespace {

void set_covariance(ModelSpecification& specification, const std::vector<std::string>& covariance) {
  if (covariance.empty()) return;
  std::vector<RandomEffects>& terms = specification.random;
  if (covariance.size() != 1 && covariance.size() != terms.size()) {
    throw UsageError(fmt::format("give one form of the covariance, or one for each of the {} "
                                 "groupings, not {}",
                                 terms.size(),
                                 covariance.size()),
                     {.column = "covariance"});
  }
  for (std::size_t i = 0; i < terms.size(); ++i) {
    terms[i].covariance = parse_covariance(covariance[covariance.size() == 1 ? 0 : i]);
  }
}

void require_column(const data::Table& table, const std::string& name) {
  if (table.has(name)) return;
  throw InputError(data::no_such_column(name, table.names()), {.file = table.file()});
}

/// Checks that columns which the model reads as numbers are numbers.
void require_columns(const ModelSpecification& specification, const data::Table& table) {
  std::vector<std::string> columns = specification.predictors();
  columns.push_back(specification.formula.left);
  for (const VarianceFactor& factor : specification.variance.factors) {
    if (!factor.column.empty()) {
      require_column(table, factor.column);
      columns.push_back(factor.column);
    }
    if (!factor.stratum.empty()) require_column(table, factor.stratum);
  }
  data::require_numeric(table, columns);
}

}  // namespace

ModelSpecification specify_model(const ModelTexts& texts, const data::Table& table) {
  ModelSpecification specification = specify_model(texts.formula, texts.sub_models, table);
  check_response(specification, table);
  if (!texts.random.empty()) add_random_effects(specification, texts.random, table);
  set_covariance(specification, texts.covariance);
  if (!texts.variance.empty()) {
    specification.variance = parse_variance_function(texts.variance);
  }
  require_columns(specification, table);
  return specification;
}

}  // namespace silvafit::fit
