// SPDX-License-Identifier: MIT
#include "model/name_doubts.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "model/held_coefficients.hpp"
#include "silvafit/base/near_names.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/expression_parts.hpp"

namespace silvafit::fit {
namespace {

using NameList = std::vector<std::string>;
using Values = std::map<std::string, double>;

/// Columns that the model reads.
std::set<std::string> columns_of(const ModelSpecification& specification) {
  std::set<std::string> columns{specification.formula.left};
  const NameList predictors = specification.predictors();
  const NameList labels = specification.label_columns();
  columns.insert(predictors.begin(), predictors.end());
  columns.insert(labels.begin(), labels.end());
  return columns;
}

/// Names that nobody has treated as parameters: by a start value, a bound, a sub-model or a random
/// effect.
NameList unconfirmed(const ModelSpecification& specification, const std::set<std::string>& known) {
  NameList names;
  for (const ParameterModel& parameter : specification.parameters) {
    const bool is_used = has_effects(specification, parameter.name) ||
                         known.contains(parameter.name) || !parameter.covariates.empty();
    if (is_used) continue;
    names.push_back(parameter.name);
  }
  return names;
}

/// Columns that the name may stand for. An abbreviation counts only for a name that stands as a
/// predictor often does, and for a column that the model does not read.
NameList columns_meant(const std::string& name, const ModelSpecification& specification) {
  NameList meant;
  const data::NameUse use = data::use_of(specification.formula.right, name);
  const bool is_like_predictor = use.mentions == 1 && use.is_factor_or_base;
  const std::set<std::string> used = columns_of(specification);
  for (const std::string& column : specification.data_columns) {
    const bool is_short =
        is_like_predictor && !used.contains(column) && is_abbreviation(name, column);
    if (is_slip_of(name, column) || is_short) meant.push_back(column);
  }
  return meant;
}

void add_name(const std::string& name, NameDoubts& doubts) {
  if (std::ranges::find(doubts.names, name) == doubts.names.end()) doubts.names.push_back(name);
}

/// Estimated parameters whose values are the same in all rows.
NameList constant_parameters(const ModelSpecification& specification, const Values& held) {
  NameList names;
  for (const ParameterModel& parameter : specification.parameters) {
    const bool is_held = held.contains(parameter.name);
    if (parameter.covariates.empty() && !is_held) names.push_back(parameter.name);
  }
  return names;
}

void add_inseparable(const ModelSpecification& specification,
                     const NameList& doubtful,
                     const Values& held,
                     NameDoubts& doubts) {
  for (const data::InseparableNames& found : data::inseparable_names(
           specification.formula.right, constant_parameters(specification, held))) {
    const bool is_doubtful = std::ranges::any_of(found.names, [&](const std::string& name) {
      return std::ranges::find(doubtful, name) != doubtful.end();
    });
    if (!is_doubtful) continue;
    for (const std::string& name : found.names) add_name(name, doubts);
    doubts.findings.push_back(
        {.kind = Finding::Kind::kInseparable,
         .names = {
             enumerated(found.names), data::list_of(specification.data_columns), found.text}});
  }
}

}  // namespace

NameDoubts name_doubts(const ModelSpecification& specification,
                       const std::set<std::string>& known,
                       const Values& held) {
  NameDoubts doubts;
  if (specification.data_columns.empty()) return doubts;
  const NameList doubtful = unconfirmed(specification, known);
  for (const std::string& name : doubtful) {
    const NameList meant = columns_meant(name, specification);
    if (meant.empty()) continue;
    add_name(name, doubts);
    doubts.findings.push_back(
        {.kind = Finding::Kind::kNameDoubt, .names = {name, enumerated(meant, "or")}});
  }
  add_inseparable(specification, doubtful, held, doubts);
  return doubts;
}

std::vector<std::string> parameters_taken(const ModelSpecification& specification,
                                          const std::set<std::string>& known,
                                          const std::set<std::string>& said) {
  NameList doubtful = unconfirmed(specification, known);
  std::erase_if(doubtful, [&](const std::string& name) { return said.contains(name); });
  if (specification.data_columns.empty() || doubtful.empty()) return {};
  NameList texts;
  for (const ParameterModel& parameter : specification.parameters) {
    std::string text = parameter.name;
    const bool is_doubtful = std::ranges::find(doubtful, text) != doubtful.end();
    const NameList near = is_doubtful ? names_near(text, specification.data_columns) : NameList{};
    if (!near.empty()) text += fmt::format(" (near the column {})", enumerated(near, "or"));
    texts.push_back(std::move(text));
  }
  return texts;
}

}  // namespace silvafit::fit
