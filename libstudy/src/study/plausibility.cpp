// SPDX-License-Identifier: MIT
#include "study/plausibility.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <span>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "silvafit/base/median.hpp"
#include "silvafit/fit/prediction.hpp"
#include "silvafit/fit/random_effects.hpp"
#include "silvafit/study/study.hpp"

namespace silvafit::study {
namespace {

/// Points of a curve: half a centimeter apart where the largest tree measures 50 cm.
constexpr std::size_t kPoints = 120;
/// Curves are judged up to this multiple of the largest DBH.
constexpr double kBeyond = 1.2;
/// Fitted values must not exceed the measured maximum by more than this factor.
constexpr double kExplodes = 2.0;
/// Upper limits above this multiple of the largest measured value are not determined by the data.
constexpr double kFarLimit = 10.0;
/// Heights are measured to the decimeter: a smaller decrease of the curve is ignored.
constexpr double kFlat = 1e-3;
/// Number of plots whose curves are evaluated together, which limits the memory.
constexpr std::size_t kTogether = 256;

/// Numeric columns that the mean of a fit reads.
std::vector<std::string> numeric_predictors(const fit::FittedModel& fit) {
  std::vector<std::string> names;
  for (const std::string& name : fit.specification.predictors()) {
    data::TextMatch match;
    if (!data::is_text_match(name, match)) names.push_back(name);
  }
  return names;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

/// Whether all plots have the same curve.
bool is_one_curve(const fit::FittedModel& fit) {
  if (fit.has_random_effects()) return false;
  return std::ranges::all_of(fit.specification.predictors(),
                             [](const std::string& name) { return name == "dbh" || name == "h"; });
}

double median_of(std::span<const double> column, const std::vector<std::size_t>& rows) {
  std::vector<double> values;
  values.reserve(rows.size());
  for (const std::size_t row : rows) values.push_back(column[row]);
  return median(std::move(values));
}

/// The tree with the median DBH, or the first tree if no DBH is known.
std::size_t typical_row(const data::Table& trees, std::vector<std::size_t> rows) {
  if (!trees.has("dbh")) return rows.front();
  const std::span<const double> dbh = trees.numbers("dbh");
  const auto middle = rows.begin() + static_cast<std::ptrdiff_t>(rows.size() / 2);
  std::ranges::nth_element(rows, middle, [dbh](std::size_t a, std::size_t b) {
    return std::pair(dbh[a], a) < std::pair(dbh[b], b);
  });
  return *middle;
}

/// Heights by Naslund's curve fitted to the trees; their mean if the curve cannot be fitted.
std::vector<double> heights_at(const std::vector<double>& dbh_cm, const data::Table& trees) {
  constexpr double kBreast = 1.3;
  const std::span<const double> dbh = trees.numbers("dbh");
  const std::span<const double> h = trees.numbers("h");
  double n = 0.0;
  double sum_d = 0.0;
  double sum_y = 0.0;
  double sum_dd = 0.0;
  double sum_dy = 0.0;
  double sum_h = 0.0;
  for (std::size_t row = 0; row < trees.rows(); ++row) {
    if (!(h[row] > kBreast) || !std::isfinite(dbh[row])) continue;
    const double y = dbh[row] / std::sqrt(h[row] - kBreast);
    n += 1.0;
    sum_d += dbh[row];
    sum_y += y;
    sum_dd += dbh[row] * dbh[row];
    sum_dy += dbh[row] * y;
    sum_h += h[row];
  }
  const double slope = (n * sum_dy - sum_d * sum_y) / (n * sum_dd - sum_d * sum_d);
  const double intercept = (sum_y - slope * sum_d) / n;
  std::vector<double> heights(dbh_cm.size(), n > 0.0 ? sum_h / n : kBreast);
  if (!(slope > 0.0) || !(intercept > 0.0)) return heights;
  for (std::size_t i = 0; i < dbh_cm.size(); ++i) {
    heights[i] = kBreast + std::pow(dbh_cm[i] / (intercept + slope * dbh_cm[i]), 2);
  }
  return heights;
}

/// Values of the parameters of one tree's curve: coefficients times covariates.
std::map<std::string, double> parameters_of(const fit::FittedModel& fit,
                                            const Eigen::VectorXd& coefficients,
                                            const data::Table& typical,
                                            std::size_t row) {
  std::map<std::string, double> values;
  Eigen::Index next = 0;
  for (const fit::ParameterModel& parameter : fit.specification.parameters) {
    double value = parameter.has_intercept ? coefficients[next++] : 0.0;
    for (const fit::Covariate& covariate : parameter.covariates) {
      const std::vector<std::string> names = covariate.value.variables();
      std::vector<double> numbers;
      for (const std::string& name : names) {
        data::TextMatch match;
        numbers.push_back(
            data::is_text_match(name, match)
                ? static_cast<double>(typical.labels(match.column)[row] == match.value)
                : typical.numbers(name)[row]);
      }
      value += coefficients[next++] * covariate.value.value(names, numbers);
    }
    values[parameter.name] = value;
  }
  return values;
}

/// Adds the random effects of one grouping to the coefficients of rows with these labels.
void add_effects(const fit::FittedModel& fit,
                 const fit::EstimatedEffects& term,
                 const std::vector<std::string>& labels,
                 Eigen::MatrixXd& coefficients) {
  std::unordered_map<std::string_view, Eigen::Index> numbers;
  for (const std::string& label : term.labels) {
    numbers.emplace(label, static_cast<Eigen::Index>(numbers.size()));
  }
  for (std::size_t row = 0; row < labels.size(); ++row) {
    const auto known = numbers.find(labels[row]);
    if (known == numbers.end()) continue;
    for (std::size_t k = 0; k < term.names.size(); ++k) {
      const auto place = std::ranges::find(fit.coefficient_names, term.names[k]);
      coefficients(place - fit.coefficient_names.begin(), static_cast<Eigen::Index>(row)) +=
          term.effects(static_cast<Eigen::Index>(k), known->second);
    }
  }
}

/// "a = 12.3, b = -0.04".
std::string list_of(const std::map<std::string, double>& parameters) {
  std::vector<std::string> texts;
  for (const auto& [name, value] : parameters) {
    texts.push_back(fmt::format("{} = {:.4g}", name, value));
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

}  // namespace

Plausibility::Plausibility(std::string response,
                           const data::Table& trees,
                           std::string group,
                           std::string period)
    : response_(std::move(response)),
      trees_(&trees),
      group_(std::move(group)),
      period_(std::move(period)) {
  add_strata();
  if (trees.rows() == 0) return;
  const std::span<const double> values = trees.numbers(response_);
  largest_ = *std::ranges::max_element(values);
  if (!trees.has("dbh")) return;
  const auto [least, most] = std::ranges::minmax(trees.numbers("dbh"));
  least_dbh_cm_ = least;
  top_dbh_cm_ = kBeyond * most;
  // The first point represents the limit at DBH 0, where many formulas divide by DBH.
  dbh_cm_.push_back(1e-3 * top_dbh_cm_);
  for (std::size_t i = 1; i < kPoints; ++i) {
    dbh_cm_.push_back(top_dbh_cm_ * static_cast<double>(i) / static_cast<double>(kPoints - 1));
  }
  if (trees.has("h") && trees.is_numeric("h")) h_m_ = heights_at(dbh_cm_, trees);
}

/// The population, each group and, with periods, each period of a group.
void Plausibility::add_strata() {
  const data::TextColumn groups = trees_->labels(group_);
  const data::TextColumn periods = period_.empty() ? data::TextColumn() : trees_->labels(period_);
  strata_.resize(1 + groups.levels().size());
  strata_[0].name = "the population";
  for (std::size_t k = 0; k < groups.levels().size(); ++k) {
    strata_[k + 1].group = groups.levels()[k];
    strata_[k + 1].name = fmt::format("{} {}", group_, groups.levels()[k]);
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> number_of_period;
  for (std::size_t row = 0; row < trees_->rows(); ++row) {
    strata_[0].rows.push_back(row);
    if (groups.is_missing(row)) continue;
    const std::size_t group = groups.code(row) + 1;
    strata_[group].rows.push_back(row);
    if (period_.empty() || periods.is_missing(row)) continue;
    const auto [found, is_new] =
        number_of_period.try_emplace({groups.code(row), periods.code(row)}, strata_.size());
    if (is_new) {
      Stratum own{.name = fmt::format("{}, {} {}", strata_[group].name, period_, periods[row]),
                  .group = strata_[group].group,
                  .period = std::string(periods[row])};
      strata_.push_back(std::move(own));
    }
    strata_[found->second].rows.push_back(row);
  }
  std::erase_if(strata_, [](const Stratum& stratum) { return stratum.rows.empty(); });
  for (Stratum& stratum : strata_) stratum.row = typical_row(*trees_, stratum.rows);
}

bool Plausibility::is_tree_measure() const { return !unit_of(response_).empty(); }

std::string Plausibility::objection(const fit::FittedModel& fit, const BaseModel* entry) const {
  if (strata_.empty()) return "";
  const data::Table typical = typical_trees(fit);
  if (entry != nullptr) {
    if (auto text = objection_to_parameters(fit, *entry, typical); !text.empty()) return text;
  }
  if (contains(numeric_predictors(fit), "dbh")) {
    if (auto text = objection_to_curves(fit, typical); !text.empty()) return text;
  }
  return objection_to_values(fit);
}

data::Table Plausibility::typical_trees(const fit::FittedModel& fit) const {
  const std::size_t count = is_one_curve(fit) ? 1 : strata_.size();
  std::vector<std::size_t> rows;
  for (std::size_t k = 0; k < count; ++k) rows.push_back(strata_[k].row);
  data::Table table = trees_->select(rows);
  for (const std::string& name : numeric_predictors(fit)) {
    std::vector<double> medians;
    for (std::size_t k = 0; k < count; ++k) {
      medians.push_back(median_of(trees_->numbers(name), strata_[k].rows));
    }
    table.set(name, std::move(medians));
  }
  // The population belongs to no group, and a group as a whole to no period.
  const auto set_labels = [&](const std::string& name, std::string Stratum::*label) {
    data::TextColumn labels;
    for (std::size_t k = 0; k < count; ++k) {
      const std::string& own = strata_[k].*label;
      own.empty() ? labels.append_missing() : labels.append(own);
    }
    table.set(name, std::move(labels));
  };
  set_labels(group_, &Stratum::group);
  if (!period_.empty()) {
    set_labels(period_, &Stratum::period);
    set_labels(kTree, &Stratum::tree);
  }
  return table;
}

Eigen::MatrixXd Plausibility::coefficients_of_strata(const fit::FittedModel& fit,
                                                     std::size_t count) const {
  Eigen::MatrixXd coefficients = fit.estimate.replicate(1, static_cast<Eigen::Index>(count));
  if (!fit.has_random_effects()) return coefficients;
  std::vector<std::string> groups;
  std::vector<std::string> periods;
  for (std::size_t k = 0; k < count; ++k) {
    const Stratum& stratum = strata_[k];
    groups.push_back(stratum.group);
    periods.push_back(stratum.period.empty() ? std::string()
                                             : fit::nested_label(stratum.group, stratum.period));
  }
  for (std::size_t t = 0; t < fit.random.size(); ++t) {
    const std::string& group = fit.specification.random[t].group;
    if (group != group_ && group != period_) continue;  // curves are those of typical trees
    add_effects(fit, fit.random[t], group == group_ ? groups : periods, coefficients);
  }
  return coefficients;
}

std::string Plausibility::objection_to_parameters(const fit::FittedModel& fit,
                                                  const BaseModel& entry,
                                                  const data::Table& typical) const {
  const Eigen::MatrixXd coefficients = coefficients_of_strata(fit, typical.rows());
  for (std::size_t k = 0; k < typical.rows(); ++k) {
    const auto parameters =
        parameters_of(fit, coefficients.col(static_cast<Eigen::Index>(k)), typical, k);
    std::string violated_condition = entry.violated_condition(parameters, top_dbh_cm_);
    if (violated_condition.empty()) violated_condition = flaw_of_limit(entry, parameters);
    if (violated_condition.empty()) continue;
    return fmt::format(
        "For {}, {} ({}).", strata_[k].name, violated_condition, list_of(parameters));
  }
  return "";
}

std::string Plausibility::flaw_of_limit(const BaseModel& entry,
                                        const std::map<std::string, double>& parameters) const {
  if (!entry.at_infinity) return "";
  std::vector<std::string> names = entry.at_infinity->variables();
  // Limits that depend on the height, as those of crown bases, are below it.
  if (contains(names, "h")) return "";
  std::vector<double> values;
  for (const std::string& name : names) values.push_back(parameters.at(name));
  const double limit = entry.at_infinity->value(names, values);
  if (limit <= kFarLimit * largest_) return "";
  return fmt::format("the asymptote, {:.3g} {}, is far above the largest measured value, {}",
                     limit,
                     unit_of(response_),
                     text_of(largest_));
}

data::Table Plausibility::grid(const data::Table& typical,
                               std::size_t begin,
                               std::size_t end) const {
  std::vector<std::size_t> rows;
  std::vector<double> dbh;
  std::vector<double> h;
  for (std::size_t k = begin; k < end; ++k) {
    rows.insert(rows.end(), dbh_cm_.size(), k);
    dbh.insert(dbh.end(), dbh_cm_.begin(), dbh_cm_.end());
    h.insert(h.end(), h_m_.begin(), h_m_.end());
  }
  data::Table table = typical.select(rows);
  table.set("dbh", std::move(dbh));
  if (!h_m_.empty()) table.set("h", std::move(h));
  return table;
}

std::string Plausibility::objection_to_curves(const fit::FittedModel& fit,
                                              const data::Table& typical) const {
  std::string first;
  std::size_t flawed = 0;
  for (std::size_t begin = 0; begin < typical.rows(); begin += kTogether) {
    const std::size_t end = std::min(begin + kTogether, typical.rows());
    const Eigen::VectorXd values =
        fit::predict(fit, grid(typical, begin, end), fit::Level::kConditional).value;
    for (std::size_t k = begin; k < end; ++k) {
      const std::string flaw = flaw_of_curve(values.data() + (k - begin) * dbh_cm_.size());
      if (flaw.empty()) continue;
      if (flawed++ == 0) first = fmt::format("The curve of {} {}", strata_[k].name, flaw);
    }
  }
  if (flawed < 2) return flawed == 0 ? first : first + ".";
  return fmt::format("{}; {} of {} curves have such a fault.", first, flawed, typical.rows());
}

std::string Plausibility::flaw_of_curve(const double* values) const {
  std::size_t peak = 0;
  for (std::size_t i = 0; i < dbh_cm_.size(); ++i) {
    if (std::string flaw = flaw_of_point(i, values[i]); !flaw.empty()) return flaw;
    if (values[i] > values[peak]) peak = i;
    if (response_ != "h" || values[i] >= values[peak] - kFlat) continue;
    // The message is about the last point, where the decrease is largest.
    const std::size_t last = dbh_cm_.size() - 1;
    const std::size_t low = values[last] < values[i] ? last : i;
    return fmt::format("falls from {} at a DBH of {:.1f} cm to {} at {:.1f} cm",
                       text_of(values[peak]),
                       dbh_cm_[peak],
                       text_of(values[low]),
                       dbh_cm_[low]);
  }
  return "";
}

std::string Plausibility::flaw_of_point(std::size_t i, double value) const {
  const std::string place = fmt::format("at a DBH of {:.1f} cm", dbh_cm_[i]);
  if (!std::isfinite(value)) return "is not finite " + place;
  if (!is_tree_measure()) return "";
  // Curves may start at zero, but measured trees are larger.
  if (value < 0.0 || (value == 0.0 && dbh_cm_[i] >= least_dbh_cm_)) {
    return fmt::format("is {} {}", text_of(value), place);
  }
  if (response_ == "hcb" && !h_m_.empty() && value > h_m_[i] + kFlat) {
    return fmt::format(
        "lies above the height {} ({} of {})", place, text_of(value), text_of(h_m_[i]));
  }
  if (value > kExplodes * largest_) {
    return fmt::format("reaches {} {}; the largest value measured is {}",
                       text_of(value),
                       place,
                       text_of(largest_));
  }
  return "";
}

/// "12.3 m".
std::string Plausibility::text_of(double value) const {
  return is_tree_measure() ? fmt::format("{:.2f} {}", value, unit_of(response_))
                           : fmt::format("{:.4g}", value);
}

std::string Plausibility::objection_to_values(const fit::FittedModel& fit) const {
  for (const fit::Level level : {fit::Level::kPopulation, fit::Level::kConditional}) {
    if (level == fit::Level::kConditional && !fit.has_random_effects()) break;
    const Eigen::VectorXd values = fit::predict(fit, *trees_, level).value;
    for (Eigen::Index row = 0; row < values.size(); ++row) {
      const auto at = static_cast<std::size_t>(row);
      if (is_possible(at, values[row])) continue;
      return fmt::format("The fitted value of a tree with {} {} is {}; the measured value is {}.",
                         group_,
                         trees_->labels(group_)[at],
                         text_of(values[row]),
                         text_of(trees_->numbers(response_)[at]));
    }
  }
  return "";
}

bool Plausibility::is_possible(std::size_t row, double value) const {
  if (!std::isfinite(value)) return false;
  if (!is_tree_measure()) return true;
  const bool is_below_top =
      response_ != "hcb" || !trees_->has("h") || value <= trees_->numbers("h")[row] + kFlat;
  return is_below_top && value > 0.0 && value <= kExplodes * largest_;
}

}  // namespace silvafit::study
