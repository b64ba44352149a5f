// SPDX-License-Identifier: MIT
// The data of the report page in the format of docs/report-data.md.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "report/report_json.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/base/json_values.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "silvafit/study/report_page.hpp"
#include "study/outliers.hpp"
#include "study/study_curves.hpp"
#include "study/study_tables.hpp"

namespace silvafit::study {
namespace {

using nlohmann::ordered_json;

// More points cannot be distinguished on the page; every k-th tree is shown then.
constexpr std::size_t kMostPoints = 4000;

void add_criteria(ordered_json& row, const Candidate& candidate) {
  const fit::FittedModel& fit = candidate.fit;
  row["converged"] = fit.convergence.converged();
  row["verdict"] = fit.convergence.verdict();
  row["k"] = fit.parameter_count;
  row["log_likelihood"] = number_or_null(fit.log_likelihood);
  row["aic"] = number_or_null(fit.aic());
  row["bic"] = number_or_null(fit.bic());
  const auto& validated = candidate.cross_validated;
  row["cv_rmse"] = validated ? number_or_null(validated->rmse) : ordered_json(nullptr);
  row["cv_failed_folds"] = validated ? ordered_json(validated->failed) : ordered_json(nullptr);
  row["rank"] = candidate.rank > 0 ? ordered_json(candidate.rank) : ordered_json(nullptr);
  row["chosen"] = candidate.chosen;
  row["objection"] =
      candidate.objection.empty() ? ordered_json(nullptr) : ordered_json(candidate.objection);
}

void add_test(ordered_json& row, const Candidate& candidate) {
  const auto& test = candidate.test;
  row["likelihood_ratio"] = test ? number_or_null(test->statistic) : ordered_json(nullptr);
  row["df"] = test ? ordered_json(test->degrees_of_freedom) : ordered_json(nullptr);
  row["p"] = test ? number_or_null(test->p) : ordered_json(nullptr);
}

void add_accuracy(ordered_json& row, const fit::FitStatistics& values) {
  row["r2"] = number_or_null(values.r2);
  row["mean_error"] = number_or_null(values.mean_error);
  row["rmse"] = number_or_null(values.rmse);
  row["mae"] = number_or_null(values.mae);
}

ordered_json base_rows(const ResponseStudy& result, const Catalogue& catalogue) {
  ordered_json rows = ordered_json::array();
  for (const Candidate& candidate : result.base) {
    const std::string& id = candidate.fit.model;
    ordered_json row{{"id", id.empty() ? "own" : id},
                     {"name", id.empty() ? "" : catalogue.find(id).name},
                     {"formula", candidate.fit.specification.formula.text}};
    add_criteria(row, candidate);
    add_accuracy(row, candidate.fit.population);
    rows.push_back(std::move(row));
  }
  return rows;
}

ordered_json covariate_rows(const ResponseStudy& result) {
  ordered_json rows = ordered_json::array();
  for (const Candidate& candidate : result.covariates) {
    ordered_json row{{"parameters", candidate.terms}};
    add_accuracy(row, candidate.fit.population);
    add_test(row, candidate);
    add_criteria(row, candidate);
    rows.push_back(std::move(row));
  }
  return rows;
}

ordered_json random_rows(const ResponseStudy& result) {
  ordered_json rows = ordered_json::array();
  for (const Candidate& candidate : result.random) {
    ordered_json row{{"effects", candidate.terms},
                     {"covariance", word_of(candidate.fit.specification.random.back().covariance)}};
    add_test(row, candidate);
    add_criteria(row, candidate);
    rows.push_back(std::move(row));
  }
  return rows;
}

ordered_json variance_rows(const ResponseStudy& result) {
  ordered_json rows = ordered_json::array();
  for (const Candidate& candidate : result.variance) {
    const fit::VarianceEstimate& variance = candidate.fit.variance;
    const fit::VarianceFunction function = variance.function();
    const int count = function.parameter_count();
    ordered_json row{
        {"function", function.text()},
        {"of", count > 0 ? ordered_json("fitted") : ordered_json(nullptr)},
        {"delta", count > 0 ? number_or_null(variance.delta()) : ordered_json(nullptr)},
        {"constant", count > 1 ? number_or_null(variance.constant()) : ordered_json(nullptr)}};
    add_test(row, candidate);
    add_criteria(row, candidate);
    rows.push_back(std::move(row));
  }
  return rows;
}

ordered_json fit_or_null(const std::optional<fit::FitResult>& result) {
  return result ? fit_object(result->fit) : ordered_json(nullptr);
}

ordered_json gain(const ResponseStudy& result) {
  if (!result.ols || !result.nlme) return {{"population", nullptr}, {"conditional", nullptr}};
  const double ols = result.ols->fit.population.r2;
  return {{"population", number_or_null(100.0 * (result.nlme->fit.population.r2 - ols))},
          {"conditional", number_or_null(100.0 * (result.nlme->fit.conditional.r2 - ols))}};
}

/// Values of a fit by the position of the tree among the rows of the result; NaN without a fit.
std::vector<double> by_tree(const ResponseStudy& result,
                            const std::optional<fit::FitResult>& fit,
                            const Eigen::VectorXd fit::FitResult::*member) {
  std::vector<double> values(result.rows.size(), data::kMissing);
  if (!fit) return values;
  const Eigen::VectorXd& source = (*fit).*member;
  for (std::size_t i = 0; i < fit->rows.size(); ++i) {
    values[fit->rows[i]] = source[static_cast<Eigen::Index>(i)];
  }
  return values;
}

/// Columns of the trees on the page.
class Observations {
 public:
  Observations(const ResponseStudy& result, const data::Table& table)
      : result_(result), table_(table) {
    const std::size_t step = 1 + (result.rows.size() - 1) / kMostPoints;
    for (std::size_t i = 0; i < result.rows.size(); i += step) shown_.push_back(i);
  }

  ordered_json json() const {
    ordered_json object{{"plot", texts("plot")}, {"tree", texts("tree")}, {"dbh", column("dbh")}};
    if (result_.response == "hcb") object["h"] = column("h");
    object["covariates"] = ordered_json::object();
    for (const std::string& name : covariates_of(result_)) {
      object["covariates"][name] = column(name);
    }
    object["observed"] = column(result_.response);
    const auto ols = by_tree(result_, result_.ols, &fit::FitResult::fitted_population);
    const auto population = by_tree(result_, result_.nlme, &fit::FitResult::fitted_population);
    const auto conditional = by_tree(result_, result_.nlme, &fit::FitResult::fitted_conditional);
    object["ols"] = chosen(ols);
    object["population"] = chosen(population);
    object["conditional"] = chosen(conditional);
    object["residual_ols"] =
        residuals(ols, by_tree(result_, result_.ols, &fit::FitResult::residual_sd));
    object["residual_nlme"] =
        residuals(conditional, by_tree(result_, result_.nlme, &fit::FitResult::residual_sd));
    return object;
  }

 private:
  ordered_json texts(const std::string& name) const {
    const data::TextColumn labels = table_.labels(name);
    ordered_json array = ordered_json::array();
    for (const std::size_t i : shown_) array.push_back(std::string(labels[result_.rows[i]]));
    return array;
  }

  std::vector<double> values(const std::string& name) const {
    std::vector<double> result(result_.rows.size());
    for (std::size_t i = 0; i < result.size(); ++i)
      result[i] = table_.numbers(name)[result_.rows[i]];
    return result;
  }

  ordered_json column(const std::string& name) const { return chosen(values(name)); }

  ordered_json chosen(const std::vector<double>& values) const {
    ordered_json array = ordered_json::array();
    for (const std::size_t i : shown_) array.push_back(number_or_null(values[i]));
    return array;
  }

  ordered_json residuals(const std::vector<double>& fitted, const std::vector<double>& sd) const {
    std::vector<double> scaled = values(result_.response);
    for (std::size_t i = 0; i < scaled.size(); ++i) scaled[i] = (scaled[i] - fitted[i]) / sd[i];
    return chosen(scaled);
  }

  const ResponseStudy& result_;
  const data::Table& table_;
  std::vector<std::size_t> shown_;
};

ordered_json band_object(const CurveBand& band) {
  return {{"low", numbers_or_null(band.low)}, {"high", numbers_or_null(band.high)}};
}

ordered_json curves_object(const Curves& curves) {
  ordered_json object{{"held_at", ordered_json::object()}, {"dbh", numbers_or_null(curves.dbh_cm)}};
  for (const auto& [name, value] : curves.held_at) object["held_at"][name] = number_or_null(value);
  if (!curves.h_m.empty()) object["h"] = numbers_or_null(curves.h_m);
  object["ols"] = numbers_or_null(curves.ols);
  object["population"] = numbers_or_null(curves.population);
  object["ols_band"] = band_object(curves.ols_band);
  object["population_band"] = band_object(curves.population_band);
  object["plots"] = ordered_json::object();
  for (const auto& [plot, values] : curves.plots) object["plots"][plot] = numbers_or_null(values);
  object["by_class"] = ordered_json::array();
  for (const ClassCurves& each : curves.by_class) {
    ordered_json entry{{"covariate", each.covariate},
                       {"classes", numbers_or_null(each.classes)},
                       {"trees", each.trees},
                       {"covariates", ordered_json::array()},
                       {"population", ordered_json::array()}};
    for (const auto& values : each.covariates)
      entry["covariates"].push_back(numbers_or_null(values));
    for (const auto& values : each.population)
      entry["population"].push_back(numbers_or_null(values));
    object["by_class"].push_back(std::move(entry));
  }
  return object;
}

ordered_json outlying_array(const ResponseStudy& result) {
  ordered_json plots = ordered_json::array();
  if (!result.nlme) return plots;
  for (const PlotDistance& plot : outlying_plots(result.nlme->fit)) {
    plots.push_back({{"plot", plot.plot},
                     {"distance", number_or_null(plot.distance)},
                     {"p", number_or_null(plot.p)}});
  }
  return plots;
}

ordered_json variogram_array(const ResponseStudy& result) {
  ordered_json classes = ordered_json::array();
  for (const VariogramClass& each : result.variogram) {
    classes.push_back({{"distance", number_or_null(each.distance_m)},
                       {"semivariance", number_or_null(each.semivariance)},
                       {"pairs", each.pairs}});
  }
  return classes;
}

ordered_json result_object(const ResponseStudy& result,
                           const StudyRecord& record,
                           const Catalogue& catalogue) {
  ordered_json object{{"species", result.species},
                      {"response", result.response},
                      {"unit", unit_of(result.response)},
                      {"n", result.rows.size()},
                      {"plots", result.plots},
                      {"converged", result.converged()},
                      {"verdict", result.verdict()},
                      {"sound", result.is_sound()},
                      {"doubts", result.doubts},
                      {"left_out", left_out_object(result)},
                      {"outlying", outlying_array(result)},
                      {"variogram", variogram_array(result)},
                      {"notes", result.remarks()},
                      {"base", base_rows(result, catalogue)},
                      {"covariates", covariate_rows(result)},
                      {"random", random_rows(result)},
                      {"variance", variance_rows(result)},
                      {"fits",
                       {{"ols", fit_or_null(result.ols)},
                        {"covariates", fit_or_null(result.with_covariates)},
                        {"nlme", fit_or_null(result.nlme)}}},
                      {"gain", gain(result)},
                      {"observations", Observations(result, record.table).json()}};
  const auto curves = curves_of(result, record);
  object["curves"] = curves ? curves_object(*curves) : ordered_json(nullptr);
  return object;
}

ordered_json species_rows(const StudyRecord& record) {
  const stand::Inventory& inventory = record.inventory.inventory;
  std::map<std::uint32_t, std::pair<std::size_t, std::size_t>> counts;
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    auto& [trees, core] = counts[inventory.species.code(row)];
    ++trees;
    if (record.units && record.units->core[row] != 0) ++core;
  }
  std::set<std::string> studied;
  for (const ResponseStudy& result : record.study.results) studied.insert(result.species);
  ordered_json rows = ordered_json::array();
  for (const auto& [code, count] : counts) {
    const bool named = code != data::TextColumn::kMissingCode;
    const std::string name = named ? inventory.species.levels()[code] : "";
    rows.push_back({{"code", name},
                    {"name", nullptr},
                    {"trees", count.first},
                    {"core", record.units ? ordered_json(count.second) : ordered_json(nullptr)},
                    {"studied", studied.contains(name)}});
  }
  return rows;
}

ordered_json inventory_object(const StudyRecord& record) {
  const stand::Inventory& inventory = record.inventory.inventory;
  return {{"file", std::filesystem::path(inventory.file).filename().string()},
          {"trees", inventory.size() + record.inventory.excluded_tree_count},
          {"plots",
           (record.study.options.period.empty() ? inventory.plot : inventory.measured_plot)
               .levels()
               .size()},
          {"excluded", record.inventory.excluded_tree_count},
          {"species", species_rows(record)}};
}

/// The tables on the whole study, as in its folder.
ordered_json summary_tables(const StudyRecord& record, const Catalogue& catalogue) {
  static const std::set<std::string> summaries{"species",
                                               "gains",
                                               "level_tests",
                                               "rejected",
                                               "plots_left_out",
                                               "coefficients",
                                               "variance_and_fit"};
  ordered_json tables = ordered_json::array();
  for (const FormattedTable& table : study_tables(record, catalogue)) {
    if (!summaries.contains(table.name) || table.rows.empty()) continue;
    tables.push_back(json_of(table));
  }
  return tables;
}

/// "Heights, crown bases and crown widths of 7 species on 24 plots".
std::string title_of(const StudyRecord& record) {
  std::set<std::string> species;
  std::vector<std::string> responses;
  for (const ResponseStudy& result : record.study.results) {
    species.insert(result.species);
    static const std::map<std::string, std::string> names{
        {"h", "heights"}, {"hcb", "crown bases"}, {"cw", "crown widths"}};
    const auto known = names.find(result.response);
    const std::string name = known == names.end() ? result.response : known->second;
    if (std::ranges::find(responses, name) == responses.end()) responses.push_back(name);
  }
  const stand::Inventory& inventory = record.inventory.inventory;
  const bool has_periods = !record.study.options.period.empty();
  const std::size_t plots =
      (has_periods ? inventory.measured_plot : inventory.plot).levels().size();
  std::string text = responses.empty() ? "stand tables" : responses.front();
  for (std::size_t i = 1; i < responses.size(); ++i) {
    text += (i + 1 < responses.size() ? ", " : " and ") + responses[i];
  }
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  if (!species.empty()) text += " of " + counted(species.size(), "species", "species");
  return text + (responses.empty() ? " of " : " on ") + counted(plots, "plot", "plots");
}

}  // namespace

std::string report_data(const StudyRecord& record, const Catalogue& catalogue) {
  ordered_json options = ordered_json::array();
  for (const auto& [name, value] : record.decisions) {
    options.push_back({{"name", name}, {"value", value}});
  }
  std::vector<std::string> notes = record.study.notes;
  notes.insert(notes.end(), record.inventory.notes.begin(), record.inventory.notes.end());
  if (record.sample) {
    notes.insert(notes.end(), record.sample->notes.begin(), record.sample->notes.end());
  }
  if (record.units) {
    notes.insert(notes.end(), record.units->notes.begin(), record.units->notes.end());
  }
  if (record.stand) {
    std::ranges::copy_if(record.stand->notes, std::back_inserter(notes), [&](const auto& note) {
      return std::ranges::find(notes, note) == notes.end();
    });
  }
  ordered_json report{{"schema", "silvafit-report/1"},
                      {"silvafit", record.version},
                      {"title", title_of(record)},
                      {"command", record.command},
                      {"repeat", report_repeat(record)},
                      {"options", std::move(options)},
                      {"inventory", inventory_object(record)},
                      {"notes", notes},
                      {"results", ordered_json::array()}};
  for (const ResponseStudy& result : record.study.results) {
    report["results"].push_back(result_object(result, record, catalogue));
  }
  report["tables"] = summary_tables(record, catalogue);
  if (auto district = district_object(record)) report["stand"] = std::move(*district);
  if (auto map = report_map(record)) report["map"] = std::move(*map);
  return json_text(report);
}

}  // namespace silvafit::study
