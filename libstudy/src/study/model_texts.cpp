// SPDX-License-Identifier: MIT
#include "silvafit/study/model_texts.hpp"

#include <fmt/format.h>

#include "silvafit/base/error.hpp"
#include "silvafit/study/table_checks.hpp"

namespace silvafit::study {
namespace {

void set_covariance(fit::ModelSpecification& specification,
                    const std::vector<std::string>& covariance) {
  if (covariance.empty()) return;
  std::vector<fit::RandomEffects>& terms = specification.random;
  if (covariance.size() != 1 && covariance.size() != terms.size()) {
    throw UsageError(fmt::format("give one form of the covariance, or one for each of the {} "
                                 "groupings, not {}",
                                 terms.size(),
                                 covariance.size()),
                     {.column = "covariance"});
  }
  for (std::size_t i = 0; i < terms.size(); ++i) {
    terms[i].covariance = fit::parse_covariance(covariance[covariance.size() == 1 ? 0 : i]);
  }
}

void require_column(const data::Table& table, const std::string& name) {
  if (table.has(name)) return;
  throw InputError(data::no_such_column(name, table.names()), {.file = table.file()});
}

/// What the model reads as numbers has to be numbers.
void require_columns(const fit::ModelSpecification& specification, const data::Table& table) {
  std::vector<std::string> columns = specification.predictors();
  columns.push_back(specification.formula.left);
  for (const fit::VarianceFactor& factor : specification.variance.factors) {
    if (!factor.column.empty()) columns.push_back(factor.column);
    if (!factor.stratum.empty()) require_column(table, factor.stratum);
  }
  require_numbers(table, columns);
}

}  // namespace

fit::ModelSpecification specify_model(const ModelTexts& texts, const data::Table& table) {
  fit::ModelSpecification specification =
      fit::specify_model(texts.formula, texts.sub_models, table);
  fit::check_response(specification, table);
  if (!texts.random.empty()) fit::add_random_effects(specification, texts.random, table);
  set_covariance(specification, texts.covariance);
  if (!texts.variance.empty()) {
    specification.variance = fit::parse_variance_function(texts.variance);
  }
  require_columns(specification, table);
  return specification;
}

}  // namespace silvafit::study
