// SPDX-License-Identifier: MIT
#include "fit_options.hpp"

#include <map>
#include <string>
#include <utility>

#include "arguments.hpp"

namespace silvafit::python {

fit::FitModelOptions fit_options(const py::dict& keywords) {
  Arguments arguments(keywords);
  fit::FitModelOptions options;
  std::string method;
  std::map<std::string, std::pair<std::optional<double>, std::optional<double>>> bounds;
  arguments.take("method", method);
  arguments.take("start", options.start);
  arguments.take("starts", options.spread_starts);
  arguments.take("fixed", options.fixed);
  arguments.take("bounds", bounds);
  arguments.take("reml", options.reml);
  arguments.take("agq_points", options.quadrature_points);
  arguments.take("maximum_iterations", options.maximum_iterations);
  arguments.take("threads", options.threads);
  arguments.finish();
  if (!method.empty()) options.method = fit::parse_method(method);
  for (const auto& [name, ends] : bounds) {
    fit::Bounds& range = options.bounds[name];
    range.low = ends.first.value_or(range.low);
    range.high = ends.second.value_or(range.high);
  }
  return options;
}

}  // namespace silvafit::python
