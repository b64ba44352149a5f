// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "correlation/correlation_structure.hpp"
#include "model/group_labels.hpp"
#include "model/small_matrix.hpp"
#include "result/intervals_json.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/json_reader.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {
namespace {

using data::JsonReader;

/// The meaning of a text of the file; errors in the text get the place of its key.
template <class Parse>
auto read_with(const JsonReader& json, Parse parse) {
  const std::string text = json.text();
  try {
    return parse(text);
  } catch (const UsageError& error) {
    json.fail(error.message());
  }
}

void check_schema(const JsonReader& json) {
  const std::string schema = json.text();
  if (schema == "silvafit-fit/2") return;
  if (schema.starts_with("silvafit-fit/")) {
    json.fail(fmt::format(
        "{} was written by another version of silvafit; this version ({}) reads silvafit-fit/2; "
        "fit the model again",
        schema,
        SILVAFIT_VERSION));
  }
  json.fail(fmt::format("must be \"silvafit-fit/2\", not \"{}\"", schema));
}

/// Refuses what is no covariance matrix: it must be symmetric, without negative variances and with
/// correlations that are possible together. What is not identifiable is missing in whole rows and
/// columns.
void require_covariance(const MatrixXd& matrix, const JsonReader& json) {
  // Of numbers written with all digits, for matrices of rounding errors up to their square root.
  const double rounding = std::sqrt(std::numeric_limits<double>::epsilon());
  const VectorXd deviations = matrix.diagonal().cwiseMax(0.0).cwiseSqrt();
  MatrixXd correlations = MatrixXd::Identity(matrix.rows(), matrix.cols());
  for (Index j = 0; j < matrix.cols(); ++j) {
    if (matrix(j, j) < 0.0) json.fail("has a negative variance");
    for (Index i = 0; i < j; ++i) {
      const double scale = deviations[i] * deviations[j];
      const bool is_known = !std::isnan(matrix(i, i)) && !std::isnan(matrix(j, j));
      const bool is_missing = std::isnan(matrix(i, j)) && std::isnan(matrix(j, i));
      const bool is_symmetric = std::abs(matrix(i, j) - matrix(j, i)) <= rounding * scale;
      if (is_known ? !is_symmetric : !is_missing) {
        json.fail(
            fmt::format("must be a symmetric matrix; row {} and column {} differ", i + 1, j + 1));
      }
      // A covariance without variances becomes a correlation that is too large.
      const double known_scale = std::max(scale, std::numeric_limits<double>::min());
      if (is_known) correlations(i, j) = correlations(j, i) = matrix(i, j) / known_scale;
    }
  }
  if (matrix.size() == 0) return;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> of(correlations, Eigen::EigenvaluesOnly);
  if (of.info() != Eigen::Success || of.eigenvalues()[0] < -rounding) {
    json.fail("is no covariance matrix, because its correlations contradict each other");
  }
}

/// Names of the formula that have a sub-model or an estimate are its parameters; the others are
/// columns.
ModelSpecification read_specification(const JsonReader& json) {
  ModelSpecification specification{
      .formula = read_with(json.at("formula"),
                           [](const std::string& text) { return data::parse_formula(text); })};
  const JsonReader sub_models = json.at("parameters");
  const JsonReader fixed = json.at("fixed");
  for (const std::string& name : specification.formula.right.variables()) {
    if (sub_models.has(name)) {
      specification.parameters.push_back(read_with(
          sub_models.at(name),
          [&name](const std::string& text) { return parse_stored_parameter_model(name, text); }));
    } else if (fixed.has(name)) {
      specification.parameters.push_back({.name = name});
    }
  }
  return specification;
}

void read_fixed(const JsonReader& json, FittedModel& fit) {
  fit.coefficient_names = fit.specification.coefficient_names();
  const JsonReader fixed = json.at("fixed");
  if (fixed.members().size() != fit.coefficient_names.size()) {
    fixed.fail(fmt::format("must name the coefficients of the formula: {}",
                           fmt::join(fit.coefficient_names, ", ")));
  }
  const auto p = static_cast<Index>(fit.coefficient_names.size());
  fit.estimate.resize(p);
  fit.degrees_of_freedom.resize(p);
  for (Index j = 0; j < p; ++j) {
    const JsonReader coefficient = fixed.at(fit.coefficient_names[static_cast<std::size_t>(j)]);
    fit.estimate[j] = coefficient.at("estimate").number_or_missing();
    fit.degrees_of_freedom[j] = coefficient.at("df").number_or_missing();
  }
  fit.covariance = json.at("fixed_covariance").square_matrix(p);
  require_covariance(fit.covariance, json.at("fixed_covariance"));
  if (const auto between = json.find("coefficients_between")) {
    for (const JsonReader& count : between->items()) {
      fit.coefficients_between.push_back(count.count_or_zero());
    }
  }
}

/// Matrices of each group, column by column.
MatrixXd read_matrices(const JsonReader& json,
                       const std::vector<std::string>& labels,
                       Index height,
                       Index width) {
  const LabelNumbers numbers = numbered(labels);
  const auto groups = json.members();
  if (groups.size() != labels.size()) {
    json.fail(fmt::format("must list the {} groups that have an EBLUP", labels.size()));
  }
  MatrixXd result(height * width, static_cast<Index>(labels.size()));
  for (const auto& [label, group] : groups) {
    const auto number = numbers.find(label);
    if (number == numbers.end()) group.fail("has no EBLUP");
    const auto lines = group.items();
    if (static_cast<Index>(lines.size()) != height) {
      group.fail(fmt::format("must have {} rows", height));
    }
    MatrixXd matrix(height, width);
    for (Index i = 0; i < height; ++i) {
      matrix.row(i) = lines[static_cast<std::size_t>(i)].vector(width);
    }
    result.col(number->second) = matrix.reshaped();
  }
  return result;
}

/// The uncertainty of random effects; empty for older files.
EffectUncertainty read_uncertainty(const JsonReader& json,
                                   const EstimatedEffects& term,
                                   Index coefficients) {
  EffectUncertainty result;
  if (!json.has("eblup_covariance")) return result;
  const auto size = static_cast<Index>(term.names.size());
  const JsonReader covariances = json.at("eblup_covariance");
  result.covariances = read_matrices(covariances, term.labels, size, size);
  for (Index group = 0; group < result.covariances.cols(); ++group) {
    require_covariance(result.covariances.col(group).reshaped(size, size), covariances);
  }
  result.sensitivities = read_matrices(json.at("eblup_by_fixed"), term.labels, size, coefficients);
  return result;
}

RandomEffects read_term(const JsonReader& json, const std::vector<std::string>& known) {
  RandomEffects term{.coefficients = json.at("effects").texts(), .group = json.at("group").text()};
  if (const auto within = json.find("within")) {
    term.is_crossed = true;
    term.within = within->texts();
  }
  term.covariance = json.at("form").word<Covariance>();
  if (term.covariance == Covariance::kBlock) {
    for (const JsonReader& size : json.at("blocks").items()) {
      term.blocks.push_back(size.count_or_zero());
    }
  }
  for (const JsonReader& effect : json.at("effects").items()) {
    if (std::ranges::find(known, effect.text()) == known.end()) {
      effect.fail(fmt::format("unknown coefficient '{}'", effect.text()));
    }
  }
  const std::vector<int> blocks = term.block_sizes();
  if (std::accumulate(blocks.begin(), blocks.end(), std::size_t{0}) != term.coefficients.size()) {
    json.at("blocks").fail("must sum to the number of random effects");
  }
  return term;
}

EstimatedEffects read_effects(const JsonReader& json, const RandomEffects& specification) {
  EstimatedEffects term{.names = specification.coefficients};
  const auto size = static_cast<Index>(term.names.size());
  term.covariance = json.at("covariance").square_matrix(size);
  require_covariance(term.covariance, json.at("covariance"));
  const auto groups = json.at("eblup").members();
  term.effects.resize(size, static_cast<Index>(groups.size()));
  for (std::size_t g = 0; g < groups.size(); ++g) {
    term.labels.push_back(groups[g].first);
    for (std::size_t k = 0; k < term.names.size(); ++k) {
      term.effects(static_cast<Index>(k), static_cast<Index>(g)) =
          groups[g].second.at(term.names[k]).number_or_missing();
    }
  }
  return term;
}

/// The cells of the groups of several terms.
EffectCells read_cells(const JsonReader& json, const FittedModel& fit) {
  EffectCells result;
  const std::vector<JsonReader> groups = json.at("groups").items();
  const std::vector<JsonReader> curvatures = json.at("curvature").items();
  if (groups.size() != fit.random.size()) json.at("groups").fail("must have a list for each term");
  std::set<std::string> coefficients;
  for (std::size_t t = 0; t < groups.size(); ++t) {
    coefficients.insert(fit.random[t].names.begin(), fit.random[t].names.end());
    const LabelNumbers numbers = numbered(fit.random[t].labels);
    std::vector<Index>& of_term = result.groups.emplace_back();
    for (const JsonReader& label : groups[t].items()) {
      const auto number = numbers.find(label.text());
      if (number == numbers.end()) label.fail("has no EBLUP");
      of_term.push_back(number->second);
    }
    if (of_term.size() != curvatures.size()) {
      groups[t].fail(fmt::format("must have {} labels, one for each cell", curvatures.size()));
    }
  }
  const Index r = std::ssize(coefficients);
  result.curvatures.resize(r * (r + 1) / 2, std::ssize(curvatures));
  for (std::size_t k = 0; k < curvatures.size(); ++k) {
    result.curvatures.col(static_cast<Index>(k)) = curvatures[k].vector(result.curvatures.rows());
  }
  return result;
}

/// \param cells  of several terms; none in older files
void read_random(const JsonReader& json, const std::optional<JsonReader>& cells, FittedModel& fit) {
  Index effects = 0;
  for (const JsonReader& item : json.items()) {
    const RandomEffects& specification =
        fit.specification.random.emplace_back(read_term(item, fit.coefficient_names));
    effects += static_cast<Index>(specification.coefficients.size());
    if (effects > kMostRandomEffects) {
      json.fail(fmt::format("has more than {} random effects per group", kMostRandomEffects));
    }
    EstimatedEffects& term = fit.random.emplace_back(read_effects(item, specification));
    term.uncertainty = read_uncertainty(item, term, fit.estimate.size());
  }
  // Labels of stored groups are those within the coarser ones.
  std::vector<RandomEffects>& random = fit.specification.random;
  if (are_crossed(random)) {
    if (!std::ranges::all_of(random, &RandomEffects::is_crossed)) {
      json.fail("must have the key 'within' in all terms or in none");
    }
  } else if (random.size() > 2) {
    json.fail("has more than two terms, which need the key 'within'");
  } else if (random.size() == 2) {
    random.back().within = {random.front().group};
  }
  if (cells) fit.cells = read_cells(*cells, fit);
}

/// One value, or one per stratum.
VectorXd read_by_stratum(const JsonReader& json, VarianceFactorEstimate& factor) {
  if (factor.factor.stratum.empty()) return VectorXd::Constant(1, json.number_or_missing());
  const auto members = json.members();
  VectorXd values(static_cast<Index>(members.size()));
  factor.strata.clear();
  for (std::size_t s = 0; s < members.size(); ++s) {
    factor.strata.push_back(members[s].first);
    values[static_cast<Index>(s)] = members[s].second.number_or_missing();
  }
  return values;
}

VarianceFactorEstimate read_variance_factor(const JsonReader& json) {
  const VarianceFunction function = read_with(json.at("function"), [](const std::string& text) {
    // The column of strata has a key of its own.
    return parse_variance_function(text == "stratum" ? "stratum(strata)" : text);
  });
  if (function.factors.size() != 1) json.at("function").fail("must be a single variance function");
  VarianceFactorEstimate result{.factor = function.factors.front(), .strata = {""}};
  VarianceFactor& factor = result.factor;
  if (json.has("strata")) factor.stratum = json.at("strata").text();
  if (!kind_of(factor).has_delta()) {
    result.ratio = read_by_stratum(json.at("ratio"), result);
    return result;
  }
  if (const std::string of = json.at("of").text(); of != "fitted") factor.column = of;
  result.delta = read_by_stratum(json.at("delta"), result);
  if (kind_of(factor).has_constant()) {
    // An infinite constant, that of a variance which has become constant, is written as null.
    result.constant = read_by_stratum(json.at("constant"), result);
    for (Index s = 0; s < std::min(result.constant.size(), result.delta.size()); ++s) {
      const bool is_infinite = std::isnan(result.constant[s]) && std::isfinite(result.delta[s]);
      if (is_infinite) result.constant[s] = kInfinity;
    }
  }
  for (const std::string& held :
       json.has("held") ? json.at("held").texts() : std::vector<std::string>{}) {
    (held == "delta" ? factor.delta : factor.constant) =
        held == "delta" ? result.delta[0] : result.constant[0];
  }
  return result;
}

VarianceEstimate read_variance(const JsonReader& json) {
  VarianceEstimate result;
  if (json.has("factors")) {
    for (const JsonReader& factor : json.at("factors").items()) {
      result.factors.push_back(read_variance_factor(factor));
    }
  } else if (json.at("function").text() != "none") {
    result.factors.push_back(read_variance_factor(json));
  }
  return result;
}

/// Whether rows can have these correlations. Unknown values, of fits that failed, may be.
bool is_possible(const CorrelationEstimate& estimate) {
  const CorrelationStructure structure(estimate);
  const VectorXd parameters = structure.unconstrained(estimate.values);
  const Correlation::Kind kind = estimate.correlation.kind;
  const Index open = kind == Correlation::Kind::kAr1 ? 1 : estimate.correlation.autoregressive;
  for (Index k = 0; k < parameters.size(); ++k) {
    if (std::isnan(estimate.values[k])) continue;
    const auto [low, high] = structure.limits(k);
    if (!(estimate.values[k] >= low && estimate.values[k] <= high)) return false;
    // At the other ends residuals are independent, or a matrix may still be regular.
    const bool is_one = kind != Correlation::Kind::kArma && k == 0 && parameters[k] > 0.0;
    if (std::isnan(parameters[k])) return false;
    if (std::isinf(parameters[k]) && (k < open || is_one)) return false;
  }
  return estimate.unit > 0.0;
}

void read_correlation(const JsonReader& json, FittedModel& fit) {
  fit.specification.correlation = read_with(json.at("structure"), parse_correlation);
  const auto members = json.at("parameters").members();
  if (members.empty()) return;
  CorrelationEstimate& estimate = fit.variance.correlation.emplace();
  estimate.correlation = *fit.specification.correlation;
  estimate.values.resize(std::ssize(members));
  for (std::size_t k = 0; k < members.size(); ++k) {
    estimate.names.push_back(members[k].first);
    estimate.values[static_cast<Index>(k)] = members[k].second.number_or_missing();
  }
  if (json.has("times")) {
    for (const JsonReader& time : json.at("times").items()) {
      estimate.times.push_back(time.number_or_missing());
    }
  }
  estimate.unit = json.at("unit").number_or_missing();
  estimate.largest = json.at("largest_group").count_or_zero();
  if (CorrelationStructure(estimate).names() != estimate.names) {
    json.at("parameters").fail("are not those of " + estimate.correlation.text());
  }
  if (!is_possible(estimate)) {
    json.at("parameters").fail("are outside the range of " + estimate.correlation.text());
  }
}

FitStatistics read_statistics(const JsonReader& json) {
  return {.r2 = json.at("r2").number_or_missing(),
          .mean_error = json.at("mean_error").number_or_missing(),
          .rmse = json.at("rmse").number_or_missing(),
          .mae = json.at("mae").number_or_missing()};
}

/// "a = 60, its upper bound" or "sd(b) = 0", as in files of earlier versions.
Evidence boundary_of_text(const std::string& text) {
  for (const auto kind : {Evidence::Kind::kLowerBound, Evidence::Kind::kUpperBound}) {
    const std::string_view end =
        kind == Evidence::Kind::kLowerBound ? ", its lower bound" : ", its upper bound";
    if (!text.ends_with(end)) continue;
    const std::size_t equals = text.find(" = ");
    if (equals == std::string::npos) continue;
    const std::string value = text.substr(equals + 3, text.size() - end.size() - equals - 3);
    Evidence result{.kind = kind, .term = text.substr(0, equals)};
    if (data::parse_number(value, result.value)) return result;
  }
  return {.term = text};
}

ConvergenceStatus read_status(const JsonReader& json) {
  const bool has_converged = json.at("converged").boolean();
  const auto text = json.find("status");
  if (text) {
    // Other words may be those of later versions.
    const auto status =
        find_word<ConvergenceStatus>(text->text()).value_or(ConvergenceStatus::kUnknown);
    if (Convergence{.status = status}.converged() == has_converged) return status;
  }
  return has_converged ? ConvergenceStatus::kConverged : ConvergenceStatus::kUnknown;
}

Convergence read_convergence(const JsonReader& json) {
  const JsonReader evidence = json.at("evidence");
  Convergence result{.status = read_status(json),
                     .findings = {{.names = {json.at("verdict").any_text()}}},
                     .newton_decrement = evidence.at("gradient").number_or_missing(),
                     .iterations = evidence.at("iterations").count_or_zero(),
                     .rank = evidence.at("rank").count_or_zero()};
  if (const auto findings = evidence.find("findings")) {
    for (const JsonReader& item : findings->items()) {
      const std::optional<Evidence::Kind> kind = find_word<Evidence::Kind>(item.at("kind").text());
      if (!kind) continue;
      result.evidence.push_back({.kind = *kind,
                                 .term = item.at("term").any_text(),
                                 .value = item.at("value").number_or_missing()});
    }
  } else {
    for (const std::string& text : evidence.at("boundary").texts()) {
      result.evidence.push_back(boundary_of_text(text));
    }
  }
  return result;
}

std::vector<LocalOptimum> read_optima(const JsonReader& json,
                                      const std::vector<std::string>& coefficients) {
  std::vector<LocalOptimum> result;
  for (const JsonReader& item : json.items()) {
    LocalOptimum optimum{
        .origin = item.at("origin").any_text(),
        .estimate = VectorXd(static_cast<Index>(coefficients.size())),
        .log_likelihood = item.at("log_likelihood").number_or_missing(),
        .marginal_log_likelihood = item.at("marginal_log_likelihood").number_or_missing()};
    const JsonReader fixed = item.at("fixed");
    for (std::size_t j = 0; j < coefficients.size(); ++j) {
      optimum.estimate[static_cast<Index>(j)] = fixed.at(coefficients[j]).number_or_missing();
    }
    result.push_back(std::move(optimum));
  }
  return result;
}

std::vector<ColumnRange> read_ranges(const JsonReader& json) {
  std::vector<ColumnRange> ranges;
  for (const auto& [column, limits] : json.members()) {
    const VectorXd values = limits.vector(2);
    ranges.push_back({.column = column, .low = values[0], .high = values[1]});
  }
  return ranges;
}

}  // namespace

FittedModel from_json(const JsonReader& json) {
  check_schema(json.at("schema"));
  FittedModel fit(read_specification(json));
  if (!json.at("model").is_null()) fit.model = json.at("model").any_text();
  fit.method = json.at("method").word<Method>();
  fit.reml = json.at("reml").boolean();
  if (json.has("agq_points")) fit.quadrature_points = json.at("agq_points").count_or_zero();
  fit.observations = json.at("n").count_or_zero();
  fit.excluded = json.at("excluded").count_or_zero();
  if (json.has("response_fingerprint") && !json.at("response_fingerprint").is_null()) {
    fit.response_fingerprint = json.at("response_fingerprint").any_text();
  }
  fit.convergence = read_convergence(json);
  read_fixed(json, fit);
  read_random(json.at("random"), json.find("random_cells"), fit);
  fit.variance = read_variance(json.at("variance"));
  fit.specification.variance = fit.variance.function();
  if (json.has("correlation")) read_correlation(json.at("correlation"), fit);
  fit.sigma = json.at("sigma").number_or_missing();
  fit.log_likelihood = json.at("log_likelihood").number_or_missing();
  if (!json.at("k").is_null()) fit.parameter_count = json.at("k").count_or_zero();
  const JsonReader statistics = json.at("statistics");
  fit.population = read_statistics(statistics.at("population"));
  const JsonReader conditional = statistics.at("conditional");
  fit.conditional = conditional.is_null() ? fit.population : read_statistics(conditional);
  if (json.has("r2_marginal")) fit.r2_marginal = json.at("r2_marginal").number_or_missing();
  if (json.has("r2_conditional"))
    fit.r2_conditional = json.at("r2_conditional").number_or_missing();
  fit.ranges = read_ranges(json.at("ranges"));
  if (json.has("levels")) {
    for (const auto& [column, labels] : json.at("levels").members()) {
      fit.levels.push_back({.column = column, .labels = labels.texts()});
    }
  }
  if (json.has("optima")) fit.optima = read_optima(json.at("optima"), fit.coefficient_names);
  if (json.has("factors")) fit.specification.factors = json.at("factors").texts();
  if (const auto derived = json.find("derived")) {
    for (const auto& [name, value] : derived->members()) {
      fit.specification.derived.push_back(
          {.name = name, .value = read_with(value.at("expression"), [&](const std::string& text) {
                           return parse_derived_expression(text, 0, fit.coefficient_names);
                         })});
    }
  }
  if (json.has("intervals")) fit.intervals = read_intervals(json.at("intervals"));
  fit.seconds = json.at("seconds").number_or_missing();
  return fit;
}

FittedModel from_json(std::string_view text, const std::string& file) {
  return from_json(JsonReader::parse(text, file));
}

}  // namespace silvafit::fit
