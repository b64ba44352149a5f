// SPDX-License-Identifier: MIT
#include "mixed_effects/degrees_of_freedom.hpp"

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

// Differences that are smaller relative to the column's largest value are rounding errors.
constexpr double kEqualValues = 1e-10;
// nlme's own tolerance for a column that is constant in all data.
constexpr double kConstant = 1.5e-8;

/// First rows of the groups of one grouping, and the end.
using Cuts = std::vector<Index>;

/// One grouping of several nested ones.
struct Grouping {
  std::size_t groups = 0;
  std::function<bool(const Eigen::Ref<const VectorXd>&)> column_varies_within{};
};

bool is_constant(const Eigen::Ref<const VectorXd>& column) {
  const double first = column[0];
  if (first == 0.0) return (column.array().abs() < kConstant).all();
  return ((column.array() / first - 1.0).abs() < kConstant).all();
}

bool varies_within(const Eigen::Ref<const VectorXd>& column, const Cuts& cuts) {
  const double tolerance = kEqualValues * column.cwiseAbs().maxCoeff();
  for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
    const auto rows = column.segment(cuts[k], cuts[k + 1] - cuts[k]);
    if (rows.maxCoeff() - rows.minCoeff() > tolerance) return true;
  }
  return false;
}

/// Whether a column varies within a group of a crossed term.
bool varies_within(const NonlinearModel& model,
                   std::size_t term,
                   const Eigen::Ref<const VectorXd>& column) {
  const double tolerance = kEqualValues * column.cwiseAbs().maxCoeff();
  const Index groups = model.group_count(term);
  VectorXd least = VectorXd::Constant(groups, kInfinity);
  VectorXd most = -least;
  for (Index cell = 0; cell < model.group_count(); ++cell) {
    const Index group = model.group_of(term, cell);
    for (Index i = model.group_begin(cell); i < model.group_begin(cell + 1); ++i) {
      least[group] = std::min(least[group], column[i]);
      most[group] = std::max(most[group], column[i]);
    }
  }
  return ((most - least).array() > tolerance).any();
}

/// Whether each group of a crossed term is in one group of the term before.
bool are_nested(const NonlinearModel& model) {
  for (std::size_t t = 1; t < model.term_count(); ++t) {
    std::vector<Index> coarser(static_cast<std::size_t>(model.group_count(t)), -1);
    for (Index cell = 0; cell < model.group_count(); ++cell) {
      Index& of = coarser[static_cast<std::size_t>(model.group_of(t, cell))];
      const Index found = model.group_of(t - 1, cell);
      if (of >= 0 && of != found) return false;
      of = found;
    }
  }
  return true;
}

/// The groupings from the coarsest to the finest.
std::vector<Grouping> groupings(const NonlinearModel& model) {
  std::vector<Grouping> result;
  for (std::size_t t = 0; t < model.term_count() && model.crossed() != nullptr; ++t) {
    result.push_back({static_cast<std::size_t>(model.group_count(t)),
                      [&model, t](const auto& column) { return varies_within(model, t, column); }});
  }
  if (model.specification().random.empty() || !result.empty()) return result;
  const auto add = [&result](Cuts cuts) {
    result.push_back(
        {cuts.size() - 1, [cuts](const auto& column) { return varies_within(column, cuts); }});
  };
  if (model.term_count() > 1) {
    Cuts cuts;
    for (Index c = 0; c <= model.cluster_count(); ++c) {
      cuts.push_back(model.group_begin(model.cluster_begin(c)));
    }
    add(std::move(cuts));
  }
  Cuts cuts;
  for (Index g = 0; g <= model.group_count(); ++g) cuts.push_back(model.group_begin(g));
  add(std::move(cuts));
  return result;
}

/// The finest stratum in which a column varies: 0 is between the coarsest groups.
std::size_t stratum_of(const Eigen::Ref<const VectorXd>& column,
                       const std::vector<Grouping>& levels) {
  for (std::size_t level = levels.size(); level > 0; --level) {
    if (levels[level - 1].column_varies_within(column)) return level;
  }
  return 0;
}

/// A coefficient whose column is constant in the groups of a term has the groups of that term less
/// the number of such coefficients, the least of several terms; the others have the observations
/// less the groups of all terms.
FixedFreedom crossed_freedom(const NonlinearModel& model,
                             const Eigen::Ref<const MatrixXd>& jacobian) {
  const Index p = jacobian.cols();
  FixedFreedom result{.of_tests = VectorXd(p)};
  double rest = static_cast<double>(model.observations() - p);
  for (std::size_t t = 0; t < model.term_count(); ++t) {
    rest -= static_cast<double>(model.group_count(t) - 1);
  }
  result.of_tests.setConstant(rest);
  for (std::size_t t = 0; t < model.term_count(); ++t) {
    std::vector<Index> between;
    int counted = 0;  // without constants, which are between the groups of every term
    for (Index j = 0; j < p; ++j) {
      if (varies_within(model, t, jacobian.col(j))) continue;
      between.push_back(j);
      if (!is_constant(jacobian.col(j))) ++counted;
    }
    const auto freedom = static_cast<double>(model.group_count(t) - std::ssize(between));
    for (const Index j : between) result.of_tests[j] = std::min(result.of_tests[j], freedom);
    result.coefficients_between.push_back(counted);
  }
  result.of_tests = result.of_tests.cwiseMax(1.0);
  return result;
}

}  // namespace

FixedFreedom fixed_freedom(const NonlinearModel& model,
                           const Eigen::Ref<const MatrixXd>& jacobian,
                           const std::vector<double>& units) {
  if (model.crossed() != nullptr && !are_nested(model)) return crossed_freedom(model, jacobian);
  const std::vector<Grouping> levels = groupings(model);
  const auto n = units.empty() ? static_cast<double>(model.observations()) : units.back();
  const auto p = static_cast<double>(jacobian.cols());
  if (levels.empty()) return {.of_tests = VectorXd::Constant(jacobian.cols(), n - p)};
  std::vector<double> freedom;
  double above = 0.0;
  for (std::size_t level = 0; level < levels.size(); ++level) {
    const auto count = units.empty() ? static_cast<double>(levels[level].groups) : units[level];
    freedom.push_back(count - above);
    above = count;
  }
  freedom.push_back(n - above);

  constexpr std::size_t kIntercept = 99;
  std::vector<std::size_t> strata;
  for (Index j = 0; j < jacobian.cols(); ++j) {
    strata.push_back(is_constant(jacobian.col(j)) ? kIntercept
                                                  : stratum_of(jacobian.col(j), levels));
    if (strata.back() != kIntercept) freedom[strata.back()] -= 1.0;
  }
  if (std::ranges::find(strata, kIntercept) != strata.end()) {
    freedom.front() -= 1.0;
  } else {
    for (std::size_t level = 1; level < freedom.size(); ++level) freedom[level] += 1.0;
  }
  FixedFreedom result{.of_tests = VectorXd(jacobian.cols())};
  for (Index j = 0; j < result.of_tests.size(); ++j) {
    const std::size_t stratum = strata[static_cast<std::size_t>(j)];
    result.of_tests[j] = stratum == kIntercept ? std::ranges::max(freedom) : freedom[stratum];
  }
  for (std::size_t level = 0; level < levels.size(); ++level) {
    result.coefficients_between.push_back(static_cast<int>(std::ranges::count(strata, level)));
  }
  return result;
}

FixedFreedom fixed_freedom_at(const NonlinearModel& model,
                              const VectorXd& coefficients,
                              const std::vector<double>& units) {
  return fixed_freedom(model, model.curve_at(coefficients).jacobian, units);
}

}  // namespace silvafit::fit
