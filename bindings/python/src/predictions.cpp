// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "arguments.hpp"
#include "fits.hpp"
#include "silvafit/fit/calibration.hpp"
#include "silvafit/fit/prediction.hpp"
#include "silvafit/fit/residuals.hpp"
#include "silvafit/fit/simulated_responses.hpp"
#include "tables.hpp"
#include "work.hpp"

namespace silvafit::python {
namespace {

template <class Value, std::size_t Count>
using Words = std::array<std::pair<std::string_view, Value>, Count>;

constexpr Words<fit::Level, 4> kLevels{{{"population", fit::Level::kPopulation},
                                        {"conditional", fit::Level::kConditional},
                                        {"calibrated", fit::Level::kCalibrated},
                                        {"marginal", fit::Level::kMarginal}}};
constexpr Words<fit::NewGroups, 4> kNewGroups{{{"population", fit::NewGroups::kPopulation},
                                               {"marginal", fit::NewGroups::kMarginal},
                                               {"missing", fit::NewGroups::kMissing},
                                               {"error", fit::NewGroups::kError}}};
constexpr Words<fit::SeenGroups, 3> kSeenGroups{{{"fitted", fit::SeenGroups::kFitted},
                                                 {"new", fit::SeenGroups::kNew},
                                                 {"combined", fit::SeenGroups::kCombined}}};
constexpr Words<fit::IntervalKind, 2> kIntervals{{{"prediction", fit::IntervalKind::kPrediction},
                                                  {"confidence", fit::IntervalKind::kConfidence}}};

/// \throws UsageError that lists the words
template <class Value, std::size_t Count>
Value meaning(const char* argument, const std::string& word, const Words<Value, Count>& words) {
  std::string all;
  for (const auto& [text, value] : words) {
    if (text == word) return value;
    all += fmt::format("{}'{}'", all.empty() ? "" : ", ", text);
  }
  throw UsageError(fmt::format("unknown value '{}'; available: {}", word, all),
                   {.column = argument});
}

template <class Value, std::size_t Count>
void take_word(Arguments& arguments,
               const char* argument,
               const Words<Value, Count>& words,
               Value& value) {
  std::string word;
  arguments.take(argument, word);
  if (!word.empty()) value = meaning(argument, word, words);
}

struct PredictionRequest {
  fit::Level level = fit::Level::kPopulation;
  fit::PredictionOptions options{};
};

PredictionRequest prediction_request(const py::dict& keywords) {
  Arguments arguments(keywords);
  PredictionRequest request;
  std::string interval;
  double coverage = 0.95;
  take_word(arguments, "level", kLevels, request.level);
  take_word(arguments, "new_groups", kNewGroups, request.options.new_groups);
  take_word(arguments, "seen_groups", kSeenGroups, request.options.seen_groups);
  arguments.take("interval", interval);
  arguments.take("coverage", coverage);
  arguments.take("standard_errors", request.options.standard_errors);
  arguments.take("threads", request.options.threads);
  arguments.finish();
  if (!interval.empty()) {
    request.options.interval_kind = meaning("interval", interval, kIntervals);
    request.options.interval = coverage;
  }
  return request;
}

py::dict predict(const FitPointer& fit,
                 const TablePointer& table,
                 const py::dict& keywords,
                 const py::object& listener) {
  const PredictionRequest request = prediction_request(keywords);
  const fit::Prediction prediction = run(listener, [&](Work& /*work*/) {
    return fit::predict(*fit, *table, request.level, request.options);
  });
  const bool is_confidence = request.options.interval_kind == fit::IntervalKind::kConfidence;
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
  const fit::CalibrationOptions options{
      .seen_groups = meaning("seen_groups", seen_groups, kSeenGroups), .threads = threads};
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
