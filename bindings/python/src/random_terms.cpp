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

/// The labels of the columns of a crossed term as lists.
Labels labels_of_columns(const std::vector<std::string>& labels, std::size_t columns) {
  Labels result(columns);
  for (const std::string& label : labels) {
    std::string_view rest = label;
    for (std::size_t k = 0; k < columns; ++k) {
      const bool is_last = k + 1 == columns;
      const std::string_view part = is_last ? rest : rest.substr(0, rest.find('/'));
      result[k].push_back(is_last ? std::string(part) : fit::without_escapes(part));
      rest.remove_prefix(is_last ? rest.size() : part.size() + 1);
    }
  }
  return result;
}

/// The labels `coarser/finer` as two lists, without the escapes of the coarser ones.
Labels labels_of_nested(const fit::EstimatedEffects& coarser, const fit::EstimatedEffects& finer) {
  std::map<std::string, std::string, std::less<>> known_labels;
  for (const std::string& label : coarser.labels) known_labels[fit::outer_part(label)] = label;
  Labels labels(2);
  for (const std::string& label : finer.labels) {
    const fit::NestedParts parts = fit::nested_parts(label);
    const auto known = known_labels.find(parts.outer);
    labels[0].push_back(known == known_labels.end() ? std::string(parts.outer) : known->second);
    labels[1].emplace_back(parts.inner);
  }
  return labels;
}

py::dict term(const fit::RandomEffects& specification,
              const fit::EstimatedEffects& estimated,
              const std::vector<std::string>& columns,
              const Labels& labels) {
  py::dict result;
  result["columns"] = columns;
  result["group"] = specification.group_name();
  result["crossed"] = specification.is_crossed;
  result["names"] = specification.coefficients;
  result["form"] = fit::covariance_text(specification.covariance);
  result["covariance"] = estimated.covariance;
  result["labels"] = labels;
  result["effects"] = Eigen::MatrixXd(estimated.effects.transpose());
  result["se"] = errors_of(estimated.uncertainty, estimated.covariance.rows());
  return result;
}

}  // namespace

py::list random_terms(const fit::FittedModel& fit) {
  py::list terms;
  std::vector<std::string> columns;
  for (std::size_t k = 0; k < fit.random.size(); ++k) {
    const fit::RandomEffects& specification = fit.specification.random[k];
    if (specification.is_crossed) {
      columns = specification.within;
      columns.push_back(specification.group);
      terms.append(term(specification,
                        fit.random[k],
                        columns,
                        labels_of_columns(fit.random[k].labels, columns.size())));
      continue;
    }
    columns.push_back(specification.group);
    terms.append(term(specification,
                      fit.random[k],
                      columns,
                      k == 0 ? Labels{fit.random[k].labels}
                             : labels_of_nested(fit.random[k - 1], fit.random[k])));
  }
  return terms;
}

std::string random_text(const fit::FittedModel& fit) {
  std::string text;
  for (const fit::RandomEffects& term : fit.specification.random) {
    const std::string own = fmt::format("{} | {}", term.text(), term.group_text());
    if (!text.empty()) text += term.is_crossed ? " + " : "; ";
    text += term.is_crossed ? fmt::format("({})", own) : own;
  }
  return text;
}

}  // namespace silvafit::python
