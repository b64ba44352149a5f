// SPDX-License-Identifier: MIT
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <optional>
#include <string>

#include "fits.hpp"
#include "setting_keywords.hpp"
#include "silvafit/fit/calibration.hpp"
#include "silvafit/fit/prediction.hpp"
#include "silvafit/fit/residuals.hpp"
#include "silvafit/fit/simulated_responses.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "tables.hpp"
#include "work.hpp"

namespace silvafit::python {
namespace {

py::dict predict(const FitPointer& fit,
                 const TablePointer& table,
                 const py::dict& keywords,
                 const py::object& listener) {
  Arguments arguments(keywords);
  auto settings = settings_of<study::PredictionSettings>(arguments);
  arguments.take("threads", settings.threads);
  arguments.finish();
  const fit::Level level = study::level_of(settings.level);
  const fit::PredictionOptions options = study::prediction_options(settings);
  const fit::Prediction prediction =
      run(listener, [&](Work& /*work*/) { return fit::predict(*fit, *table, level, options); });
  const bool is_confidence = options.interval_kind == fit::IntervalKind::kConfidence;
  py::dict result;
  result["value"] = prediction.value;
  result["is_new_group"] = prediction.is_new_group;
  result["lower"] = prediction.lower;
  result["upper"] = prediction.upper;
  result["standard_error"] = is_confidence ? prediction.mean_error : prediction.prediction_error;
  result["calibrated_from"] = prediction.calibrated_from;
  return result;
}

py::dict level_residuals(const fit::LevelResiduals& residuals) {
  py::dict result;
  result["fitted"] = residuals.fitted;
  result["response"] = residuals.raw;
  result["pearson"] = residuals.standardized;
  return result;
}

py::dict residuals(const FitPointer& fit, const TablePointer& table) {
  const fit::Residuals found =
      run(py::none(), [&](Work& /*work*/) { return fit::residuals(*fit, *table); });
  py::dict result;
  result["rows"] = found.rows;
  result["observed"] = found.observed;
  result["population"] = level_residuals(found.population);
  result["conditional"] = level_residuals(found.conditional);
  result["normalized"] = found.normalized;
  result["marginal"] = found.marginal;
  return result;
}

py::tuple simulate(const FitPointer& fit,
                   const TablePointer& table,
                   std::size_t replicates,
                   std::uint64_t seed) {
  const fit::SimulatedResponses drawn = run(py::none(), [&](Work& /*work*/) {
    return fit::simulate_responses(*fit, *table, replicates, seed);
  });
  return py::make_tuple(drawn.rows, drawn.values);
}

/// The random effects of the table's groups: labels, measured trees, effects (groups x effects).
py::dict calibrate(const FitPointer& fit,
                   const TablePointer& table,
                   const std::string& seen_groups,
                   unsigned threads) {
  const fit::CalibrationOptions options{.seen_groups = study::seen_groups_of(seen_groups),
                                        .threads = threads};
  const fit::Calibration found =
      run(py::none(), [&](Work& /*work*/) { return fit::calibrate(*fit, *table, options); });
  py::dict result;
  const fit::CalibratedEffects& term = found.random.back();
  result["labels"] = term.labels;
  result["measured"] = found.measured;
  result["effects"] = Eigen::MatrixXd(term.effects.transpose());
  return result;
}

}  // namespace

void add_predictions(py::module_& module) {
  module.def("predict", &predict);
  module.def("residuals", &residuals);
  module.def("simulate", &simulate);
  module.def("calibrate", &calibrate);
}

}  // namespace silvafit::python
