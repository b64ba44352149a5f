// SPDX-License-Identifier: MIT
// Fits, and what is derived from them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <numeric>

#include "fronts/call.hpp"
#include "fronts/result_columns.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/data/list_table.hpp"
#include "silvafit/data/missing_codes.hpp"
#include "silvafit/fit/comparison.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "silvafit/fit/inference_json.hpp"
#include "silvafit/fit/residuals.hpp"
#include "silvafit/fit/setting_list.hpp"
#include "silvafit/fit/simulated_responses.hpp"
#include "silvafit/fit/term_tests.hpp"
#include "silvafit/stand/similar_plots.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/idle_settings.hpp"
#include "silvafit/study/table_checks.hpp"
#include "silvafit/study/tree_table.hpp"

namespace silvafit::study {
namespace {

using data::ListTable;
using data::Table;
using nlohmann::ordered_json;

/// The rows of a fit, where codes of missing values are missing as in files.
Table rows_of(const AnalysisCall& call, data::MissingCodes& codes) {
  Table table = *std::get<std::shared_ptr<const Table>>(call.table());
  data::take_missing_codes(table, codes);
  return table;
}
Table rows_of(const AnalysisCall& call) {
  data::MissingCodes codes;
  return rows_of(call, codes);
}

/// Columns of a matrix with their numbers, from 0, as names.
Table table_of_columns(const Eigen::MatrixXd& values) {
  Table table(static_cast<std::size_t>(values.rows()));
  for (Eigen::Index j = 0; j < values.cols(); ++j) {
    table.set(std::to_string(j), numbers(Eigen::VectorXd(values.col(j))));
  }
  return table;
}

/// The fitted values of all rows in the order of the table.
Table fitted_rows(const fit::FitResult& result) {
  std::vector<Eigen::Index> order(result.rows.size());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::ranges::sort(
      order, {}, [&](Eigen::Index i) { return result.rows[static_cast<std::size_t>(i)]; });
  Table table(order.size());
  const auto add = [&](const char* name, const Eigen::VectorXd& values) {
    // A fit that failed has none.
    const bool is_known = values.size() == static_cast<Eigen::Index>(order.size());
    add_if_known(name,
                 is_known ? Eigen::VectorXd(values(order))
                          : Eigen::VectorXd::Constant(static_cast<Eigen::Index>(order.size()),
                                                      data::kMissing),
                 table);
  };
  add("population", result.fitted_population);
  add("conditional", result.fitted_conditional);
  add("residual_sd", result.residual_sd);
  return table;
}

/// A model as it was asked for.
struct FitRequest {
  fit::ModelTexts texts{};
  std::string model{};  ///< id in the catalogue, instead of a formula
  fit::FitModelOptions options{};
  bool is_traced = false;
  bool knows_units = false;  ///< sizes of trees have the units that the user has declared
};

/// What is wrong with the units of a table of trees, as files are checked; none if that is nothing.
/// The remedies of the message are settings of files.
std::vector<std::string> warnings_on_units(const Table& table) try {
  check_units(table);
  return {};
} catch (const InputError& error) {
  return {error.message().substr(0, error.message().find(';')) +
          ". Sizes of trees are h, hcb and cw in m, dbh in cm"};
}

/// What is wrong with the units of a table of trees, and with labels of a model.
std::vector<std::string> warnings_on(const Table& table,
                                     const fit::ModelSpecification& model,
                                     bool knows_units) {
  std::vector<std::string> warnings;
  if (!knows_units) warnings = warnings_on_units(table);
  for (const std::string& name : model.label_columns()) {
    if (!table.has(name) || table.is_numeric(name)) continue;
    std::string text = stand::describe_similar_labels(table.text(name), name);
    if (!text.empty()) warnings.push_back(std::move(text));
  }
  return warnings;
}

AnalysisResult result_of(FitRequest request,
                         const Table& table,
                         const Catalogue* catalogue,
                         const AnalysisCallbacks& callbacks) {
  fit::FitModelOptions& options = request.options;
  refuse_idle(request.texts, options);
  options.stop = callbacks.stop;
  if (request.is_traced) options.trace = callbacks.line;
  if (catalogue != nullptr) {
    use_base_model(catalogue->find(request.model), table, request.texts, options);
  }
  const fit::ModelSpecification specification = fit::specify_model(request.texts, table);
  // CPU time of the fit itself, which benchmarks compare with that of the whole call.
  const std::clock_t start = std::clock();
  fit::FitResult found = fit::fit_model(specification, table, options);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  found.fit.model = request.model;
  AnalysisResult result{
      .tables = {{"rows", fitted_rows(found)}},
      .rows = found.rows,
      .json = json_text(ordered_json{{"cpu_seconds", seconds}}),
      .warnings = warnings_on(table, found.fit.specification, request.knows_units)};
  std::ranges::sort(result.rows);
  result.fits.emplace_back("", std::move(found.fit));
  return result;
}

std::function<void(std::size_t, std::size_t)> progress_of(const char* stage,
                                                          const AnalysisCallbacks& callbacks) {
  return [stage, progress = callbacks.progress](std::size_t done, std::size_t total) {
    if (progress) progress(stage, done, total);
  };
}

/// The settings of a resampling, with those of its refits in the argument `refit`.
template <class Options>
Options resampling_options(AnalysisCall& call) {
  auto options = call.read_with_threads<Options>();
  if (const auto refit = call.find("refit")) {
    each_setting(options.refit, SettingsReader::of_call(*refit));
  }
  return options;
}

Table table_of_reasons(const std::vector<fit::CountedReason>& reasons, Front front) {
  ListTable table(reasons);
  table.add("reason", [front](const fit::CountedReason& one) {
    return with_setting_names(one.reason, front);
  });
  table.add("replicates", &fit::CountedReason::replicates);
  return std::move(table).table();
}

Table table_of_parameters(const std::vector<fit::BootstrapParameter>& parameters) {
  using One = fit::BootstrapParameter;
  ListTable table(parameters);
  table.add("name", &One::name);
  table.add("estimate", &One::estimate);
  table.add("replicates", &One::replicates);
  table.add("bias", &One::bias);
  table.add("se", &One::standard_error);
  table.add("percentile_lower", [](const One& one) { return one.percentile.low; });
  table.add("percentile_upper", [](const One& one) { return one.percentile.high; });
  table.add("basic_lower", [](const One& one) { return one.basic.low; });
  table.add("basic_upper", [](const One& one) { return one.basic.high; });
  return std::move(table).table();
}

Table table_of_tests(const std::vector<fit::TermTest>& tests) {
  ListTable table(tests);
  table.add("term", &fit::TermTest::term);
  table.add("df", &fit::TermTest::numerator_df);
  table.add("df_denominator", &fit::TermTest::denominator_df);
  table.add("statistic", &fit::TermTest::f);
  table.add("p", &fit::TermTest::p);
  return std::move(table).table();
}

/// Tests of neighbors, with the numbers of rows of the comparison from 0.
Table table_of_pairs(const std::vector<fit::ComparedPair>& pairs, Front front) {
  using Pair = fit::ComparedPair;
  ListTable table(pairs);
  const auto add = [&](const char* name, auto value) {
    table.add(name, [value](const Pair& pair) {
      return pair.test ? static_cast<double>(std::invoke(value, *pair.test)) : data::kMissing;
    });
  };
  table.add("larger", &Pair::larger);
  table.add("smaller", &Pair::smaller);
  add("statistic", &fit::NestedTest::statistic);
  add("df", &fit::NestedTest::degrees_of_freedom);
  add("p", &fit::NestedTest::p);
  table.add("note", [front](const Pair& pair) {
    return with_setting_names(pair.test ? pair.test->note : pair.reason, front);
  });
  return std::move(table).table();
}

AnalysisResult result_of(const std::vector<const fit::FittedModel*>& fits, Front front) {
  const fit::Comparison found = fit::compare(fits);
  const auto place_of = [&fits](const fit::FittedModel* fit) {
    return std::ranges::find(fits, fit) - fits.begin();
  };
  ListTable rows(found.fits);
  rows.add("fit", [&](const fit::ComparedFit& one) { return place_of(one.fit); });
  rows.add("aic_difference", &fit::ComparedFit::aic_difference);
  rows.add("akaike_weight", &fit::ComparedFit::akaike_weight);
  ordered_json failed = ordered_json::array();
  for (const fit::FittedModel* const fit : found.failed) failed.push_back(place_of(fit));
  return {
      .tables = {{"fits", std::move(rows).table()}, {"tests", table_of_pairs(found.pairs, front)}},
      .json = in_words({{"failed", std::move(failed)}, {"reason", found.reason}}, front)};
}

/// A fit from a file gets its data later: these must have its rows and residuals.
void require_own_data(const fit::Residuals& found, const fit::FittedModel& fit) {
  constexpr double kSame = 1e-6;  // columns may have been written with seven digits
  const double population = found.population.raw.cwiseAbs().mean();
  const double conditional = found.conditional.raw.cwiseAbs().mean();
  const auto differs = [](double value, const fit::FitStatistics& known) {
    return std::abs(value - known.mae) > kSame * known.mae;
  };
  const bool has_rows = std::ssize(found.rows) == fit.observations;
  if (has_rows && !differs(population, fit.population) && !differs(conditional, fit.conditional)) {
    return;
  }
  throw InputError(fmt::format(
      "these are not the data of the fit: they have {} complete rows and a mean absolute error of "
      "{:.6g} ({:.6g} with random effects), the fit has {} rows and {:.6g} ({:.6g})",
      found.rows.size(),
      population,
      conditional,
      fit.observations,
      fit.population.mae,
      fit.conditional.mae));
}

AnalysisResult result_of(const fit::Residuals& found,
                         const fit::FittedModel& fit,
                         const Table& table) {
  Table rows(found.rows.size());
  rows.set("observed", numbers(found.observed));
  rows.set("fitted_population", numbers(found.population.fitted));
  rows.set("fitted_conditional", numbers(found.conditional.fitted));
  rows.set("response_population", numbers(found.population.raw));
  rows.set("response_conditional", numbers(found.conditional.raw));
  rows.set("pearson_population", numbers(found.population.standardized));
  rows.set("pearson_conditional", numbers(found.conditional.standardized));
  rows.set("normalized", numbers(found.normalized));
  rows.set("marginal", numbers(found.marginal));
  rows.set("residual_sd",
           numbers(fit.residual_sd(found.conditional.fitted, table.select(found.rows))));
  return {.tables = {{"rows", std::move(rows)}}, .rows = found.rows};
}

}  // namespace

/// Arguments besides the settings: `model`, an id of the catalogue; `columns` of the data that the
/// table does not have; `factors`; `trace`.
AnalysisWork fit_work(AnalysisCall& call) {
  FitRequest request{.texts = call.read<fit::ModelTexts>(),
                     .model = call.text("model"),
                     .options = call.read_with_threads<fit::FitModelOptions>(),
                     .is_traced = call.truth("trace"),
                     .knows_units = call.truth("knows_units")};
  call.read_names("columns", request.texts.columns);
  call.read_names("factors", request.texts.factors);
  const auto catalogue = request.model.empty() ? nullptr : call.catalogue();
  data::MissingCodes codes;
  return [request, catalogue, table = rows_of(call, codes), codes](
             const AnalysisCallbacks& callbacks) {
    AnalysisResult result = result_of(request, table, catalogue.get(), callbacks);
    if (codes.empty()) return result;
    fit::Convergence& convergence = result.fits.front().second.convergence;
    convergence.find({.kind = fit::Finding::Kind::kCodesRead, .names = {codes.text()}});
    convergence.add(fit::Evidence::Kind::kMissingCode, {codes.text()});
    return result;
  };
}

AnalysisWork intervals_work(AnalysisCall& call) {
  return [fit = &call.fit(),
          table = rows_of(call),
          options = call.read_with_threads<fit::IntervalOptions>(),
          front = call.input().front](const AnalysisCallbacks& callbacks) mutable {
    options.stop = callbacks.stop;
    const fit::Intervals found = fit::confidence_intervals(*fit, table, options);
    using One = fit::ParameterInterval;
    ListTable parameters(found.parameters);
    parameters.add("name", &One::name);
    parameters.add("kind", [](const One& one) { return word_of(one.kind); });
    parameters.add("estimate", &One::estimate);
    parameters.add("lower", &One::lower);
    parameters.add("upper", &One::upper);
    parameters.add("note", [front](const One& one) { return with_setting_names(one.note, front); });
    return AnalysisResult{.tables = {{"parameters", std::move(parameters).table()}},
                          .json = json_text(ordered_json{{"likelihood", found.likelihood}})};
  };
}

AnalysisWork bootstrap_work(AnalysisCall& call) {
  return [fit = &call.fit(),
          table = rows_of(call),
          options = resampling_options<fit::BootstrapOptions>(call),
          front = call.input().front](const AnalysisCallbacks& callbacks) mutable {
    options.refit.stop = callbacks.stop;
    options.progress = progress_of("bootstrap", callbacks);
    const fit::Bootstrap found = fit::bootstrap(*fit, table, options);
    const ordered_json counts{{"replicates", found.replicates}, {"converged", found.converged}};
    return AnalysisResult{.tables = {{"parameters", table_of_parameters(found.parameters)},
                                     {"failures", table_of_reasons(found.failures, front)},
                                     {"boundary", table_of_reasons(found.at_boundary, front)},
                                     {"values", table_of_columns(found.values.transpose())}},
                          .json = json_text(counts)};
  };
}

AnalysisWork cross_validate_work(AnalysisCall& call) {
  return [fit = &call.fit(),
          table = rows_of(call),
          options = resampling_options<fit::CrossValidationOptions>(call),
          front = call.input().front](const AnalysisCallbacks& callbacks) mutable {
    options.refit.stop = callbacks.stop;
    options.progress = progress_of("cross-validation", callbacks);
    const fit::CrossValidation found = fit::cross_validate(*fit, table, options);
    Table rows(found.rows.size());
    rows.set("fold", std::vector<double>(found.fold.begin(), found.fold.end()));
    rows.set("observed", numbers(found.observed));
    rows.set("predicted", numbers(found.predicted));
    if (found.measured > 0) rows.set("calibrated", numbers(found.calibrated));
    return AnalysisResult{.tables = {{"rows", std::move(rows)}},
                          .rows = found.rows,
                          .json = in_words(fit::json_of(found), front)};
  };
}

AnalysisWork compare_work(AnalysisCall& call) {
  return [fits = call.input().fits, front = call.input().front](
             const AnalysisCallbacks& /*callbacks*/) { return result_of(fits, front); };
}

/// Arguments: `count` of replicates and `seed`.
AnalysisWork simulate_work(AnalysisCall& call) {
  return [fit = &call.fit(),
          table = rows_of(call),
          count = call.number("count", 1),
          seed = call.number("seed", 1)](const AnalysisCallbacks& /*callbacks*/) {
    const auto drawn = fit::simulate_responses(*fit, table, count, seed);
    return AnalysisResult{.tables = {{"rows", table_of_columns(drawn.values)}}, .rows = drawn.rows};
  };
}

AnalysisWork residuals_work(AnalysisCall& call) {
  return [fit = &call.fit(), table = rows_of(call)](const AnalysisCallbacks& /*callbacks*/) {
    const fit::Residuals found = fit::residuals(*fit, table);
    require_own_data(found, *fit);
    return result_of(found, *fit, table);
  };
}

/// Argument: `marginal`.
AnalysisWork covariance_work(AnalysisCall& call) {
  return [fit = &call.fit(), table = rows_of(call), is_marginal = call.truth("marginal")](
             const AnalysisCallbacks& /*callbacks*/) {
    return AnalysisResult{
        .tables = {
            {"covariance", table_of_columns(fit::response_covariance(*fit, table, is_marginal))}}};
  };
}

/// Arguments: `sequential`; or, tested together, `terms` by their numbers from 0, or `combinations`
/// of the coefficients, a list of rows, and `values` that they are compared with.
AnalysisWork term_tests_work(AnalysisCall& call) {
  std::vector<fit::TermTest> tests;
  if (const auto rows = call.find("combinations")) {
    const std::vector<data::JsonReader> list = rows->items();
    Eigen::MatrixXd combinations(list.size(), call.fit().estimate.size());
    for (std::size_t i = 0; i < list.size(); ++i) {
      combinations.row(static_cast<Eigen::Index>(i)) =
          list[i].vector(combinations.cols()).transpose();
    }
    const auto values = call.find("values");
    tests = {fit::joint_test(call.fit(),
                             combinations,
                             values ? values->vector(combinations.rows()) : Eigen::VectorXd())};
  } else if (const auto terms = call.find("terms")) {
    std::vector<std::size_t> places;
    for (const double place : terms->numbers()) places.push_back(static_cast<std::size_t>(place));
    tests = {fit::joint_test(call.fit(), places)};
  } else {
    tests = fit::term_tests(
        call.fit(),
        call.truth("sequential") ? fit::TermOrder::kSequential : fit::TermOrder::kMarginal);
  }
  return [tests](const AnalysisCallbacks& /*callbacks*/) {
    return AnalysisResult{.tables = {{"terms", table_of_tests(tests)}}};
  };
}

}  // namespace silvafit::study
