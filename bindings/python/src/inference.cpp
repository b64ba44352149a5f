// SPDX-License-Identifier: MIT
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "errors.hpp"
#include "fits.hpp"
#include "setting_keywords.hpp"
#include "silvafit/fit/comparison.hpp"
#include "silvafit/fit/setting_list.hpp"
#include "silvafit/fit/term_tests.hpp"
#include "tables.hpp"
#include "work.hpp"

namespace silvafit::python {
namespace {

/// Kinds of parameters, in the order of the enumeration.
constexpr std::array<const char*, 6> kKinds{"fixed",
                                            "standard deviation",
                                            "correlation",
                                            "variance function",
                                            "sigma",
                                            "residual correlation"};

/// The options of a list with the seed, and the threads of all refits.
template <typename Options>
Options resampling_options(const py::dict& keywords, const py::dict& refit) {
  Arguments arguments(keywords);
  auto options = settings_of<Options>(arguments);
  arguments.take("seed", options.seed);
  arguments.take("threads", options.threads);
  arguments.finish();
  Arguments of_refits(refit);
  options.refit = fit_options(of_refits);
  return options;
}

py::dict intervals(const FitPointer& fit, const TablePointer& table, const py::dict& keywords) {
  Arguments arguments(keywords);
  auto options = settings_of<fit::IntervalOptions>(arguments);
  arguments.take("threads", options.threads);
  arguments.finish();
  const fit::Intervals found = run(py::none(), [&](Work& work) {
    options.stop = work.stop();
    return fit::confidence_intervals(*fit, *table, options);
  });
  py::list parameters;
  for (const fit::ParameterInterval& one : found.parameters) {
    parameters.append(py::make_tuple(one.name,
                                     kKinds.at(static_cast<std::size_t>(one.kind)),
                                     one.estimate,
                                     one.lower,
                                     one.upper,
                                     one.note));
  }
  py::dict result;
  result["likelihood"] = found.likelihood;
  result["parameters"] = parameters;
  return result;
}

py::list reasons_of(const std::vector<fit::CountedReason>& reasons) {
  py::list result;
  for (const fit::CountedReason& one : reasons) {
    result.append(py::make_tuple(in_words_of_python(one.reason), one.replicates));
  }
  return result;
}

py::dict bootstrap_result(const fit::Bootstrap& found) {
  py::list parameters;
  for (const fit::BootstrapParameter& one : found.parameters) {
    parameters.append(py::make_tuple(one.name,
                                     one.estimate,
                                     one.replicates,
                                     one.bias,
                                     one.standard_error,
                                     one.percentile.low,
                                     one.percentile.high,
                                     one.basic.low,
                                     one.basic.high));
  }
  py::dict result;
  result["replicates"] = found.replicates;
  result["converged"] = found.converged;
  result["parameters"] = parameters;
  result["values"] = found.values;
  result["failures"] = reasons_of(found.failures);
  result["boundary"] = reasons_of(found.at_boundary);
  return result;
}

/// \param refit  the keyword arguments of the fit
py::dict bootstrap(const FitPointer& fit,
                   const TablePointer& table,
                   const py::dict& keywords,
                   const py::dict& refit,
                   const py::object& listener) {
  auto options = resampling_options<fit::BootstrapOptions>(keywords, refit);
  return bootstrap_result(run(listener, [&](Work& work) {
    options.refit.stop = work.stop();
    options.progress = work.progress_of("bootstrap");
    return fit::bootstrap(*fit, *table, options);
  }));
}

py::dict cross_validation_result(const fit::CrossValidation& found) {
  py::list failed;
  for (const fit::FailedFold& fold : found.failed) {
    failed.append(py::make_tuple(fold.groups, in_words_of_python(fold.verdict)));
  }
  py::dict result;
  result["rows"] = found.rows;
  result["fold"] = found.fold;
  result["observed"] = found.observed;
  result["predicted"] = found.predicted;
  result["calibrated"] = found.calibrated;
  result["population"] = statistics_of(found.statistics);
  result["calibrated_statistics"] = statistics_of(found.calibrated_statistics);
  result["mean_log_density"] = found.log_density;
  result["measured"] = found.measured;
  result["failed"] = failed;
  return result;
}

py::dict cross_validate(const FitPointer& fit,
                        const TablePointer& table,
                        const py::dict& keywords,
                        const py::dict& refit,
                        const py::object& listener) {
  auto options = resampling_options<fit::CrossValidationOptions>(keywords, refit);
  return cross_validation_result(run(listener, [&](Work& work) {
    options.refit.stop = work.stop();
    options.progress = work.progress_of("cross-validation");
    return fit::cross_validate(*fit, *table, options);
  }));
}

/// (term, degrees of freedom, those of the denominator, F, p) of each term.
py::list term_tests(const fit::FittedModel& fit) {
  py::list rows;
  for (const fit::TermTest& test : fit::term_tests(fit)) {
    rows.append(py::make_tuple(test.term, test.numerator_df, test.denominator_df, test.f, test.p));
  }
  return rows;
}

/// The test of a fit against the one before it, or why there is none.
py::dict test_of(const fit::ComparedPair& pair) {
  py::dict result;
  result["larger"] = pair.larger;
  result["smaller"] = pair.smaller;
  result["reason"] = in_words_of_python(pair.reason);
  if (pair.test) {
    result["statistic"] = pair.test->statistic;
    result["df"] = pair.test->degrees_of_freedom;
    result["p"] = pair.test->p;
    result["note"] = in_words_of_python(pair.test->note);
  }
  return result;
}

/// Fits are named by their places in the list.
py::dict compare(const std::vector<FitPointer>& fits) {
  std::vector<const fit::FittedModel*> pointers;
  for (const FitPointer& fit : fits) pointers.push_back(fit.get());
  const auto place_of = [&](const fit::FittedModel* fit) {
    return std::ranges::find(pointers, fit) - pointers.begin();
  };
  const fit::Comparison found =
      run(py::none(), [&](Work& /*work*/) { return fit::compare(pointers); });
  py::list rows;
  for (const fit::ComparedFit& row : found.fits) {
    rows.append(py::make_tuple(place_of(row.fit), row.aic_difference, row.akaike_weight));
  }
  py::list tests;
  for (const fit::ComparedPair& pair : found.pairs) tests.append(test_of(pair));
  py::list failed;
  for (const fit::FittedModel* const fit : found.failed) failed.append(place_of(fit));
  py::dict result;
  result["fits"] = rows;
  result["tests"] = tests;
  result["reason"] = in_words_of_python(found.reason);
  result["failed"] = failed;
  return result;
}

}  // namespace

void add_inference(py::module_& module) {
  module.def("intervals", &intervals);
  module.def("bootstrap", &bootstrap);
  module.def("cross_validate", &cross_validate);
  module.def("compare", &compare);
  module.def("term_tests", &term_tests);
}

}  // namespace silvafit::python
