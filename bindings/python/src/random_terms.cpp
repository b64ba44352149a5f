// SPDX-License-Identifier: MIT
#include "random_terms.hpp"

#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/fit/random_effects.hpp"

namespace silvafit::python {
namespace {

namespace py = pybind11;
using Eigen::Index;
using Labels = std::vector<std::vector<std::string>>;  ///< a list for each column

/// (G x q) standard errors of the effects, or None.
py::object errors_of(const fit::EffectUncertainty& uncertainty, Index effects) {
  if (!uncertainty.is_known()) return py::none();
  Eigen::MatrixXd errors(uncertainty.covariances.cols(), effects);
  for (Index group = 0; group < errors.rows(); ++group) {
    errors.row(group) =
        uncertainty.covariance(group, effects).diagonal().cwiseMax(0.0).cwiseSqrt().transpose();
  }
  return py::cast(errors);
}

/// The labels `outer/inner` as two lists, without the escapes of the coarser ones.
Labels labels_of_nested(const fit::FittedModel& fit) {
  std::map<std::string, std::string, std::less<>> outer;
  for (const std::string& label : fit.outer.labels) outer[fit::outer_part(label)] = label;
  Labels labels(2);
  for (const std::string& label : fit.group_labels) {
    const fit::NestedParts parts = fit::nested_parts(label);
    const auto known = outer.find(parts.outer);
    labels[0].push_back(known == outer.end() ? std::string(parts.outer) : known->second);
    labels[1].emplace_back(parts.inner);
  }
  return labels;
}

py::dict term(const fit::RandomEffects& effects,
              const std::vector<std::string>& columns,
              const Labels& labels,
              const Eigen::MatrixXd& covariance,
              const Eigen::MatrixXd& modes,
              const fit::EffectUncertainty& uncertainty) {
  py::dict result;
  result["columns"] = columns;
  result["names"] = effects.coefficients;
  result["form"] = fit::covariance_text(effects.covariance);
  result["covariance"] = covariance;
  result["labels"] = labels;
  result["effects"] = Eigen::MatrixXd(modes.transpose());
  result["se"] = errors_of(uncertainty, covariance.rows());
  return result;
}

}  // namespace

py::list random_terms(const fit::FittedModel& fit) {
  py::list terms;
  const fit::ModelSpecification& specification = fit.specification;
  if (!fit.has_random_effects() || !specification.random) return terms;
  std::vector<std::string> columns;
  if (specification.outer_random) {
    columns.push_back(specification.outer_random->group);
    terms.append(term(*specification.outer_random,
                      columns,
                      {fit.outer.labels},
                      fit.outer.covariance,
                      fit.outer.effects,
                      fit.outer_uncertainty));
  }
  columns.push_back(specification.random->group);
  terms.append(term(*specification.random,
                    columns,
                    specification.outer_random ? labels_of_nested(fit) : Labels{fit.group_labels},
                    fit.random_covariance,
                    fit.random_effects,
                    fit.uncertainty));
  return terms;
}

std::string random_text(const fit::FittedModel& fit) {
  std::string text;
  for (const auto* const effects : {&fit.specification.outer_random, &fit.specification.random}) {
    if (!*effects) continue;
    text +=
        fmt::format("{}{} | {}", text.empty() ? "" : "; ", (*effects)->text(), (*effects)->group);
  }
  return text;
}

}  // namespace silvafit::python
