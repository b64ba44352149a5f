// SPDX-License-Identifier: MIT
// Whether one model is a special case of another, by their specifications.
#include "silvafit/fit/nesting.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "inference/comparable_likelihoods.hpp"
#include "inference/grouping_agreement.hpp"
#include "silvafit/data/table.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {
namespace {

/// A coefficient of a fit: estimated, or at a value. One that the model does not have is at 0.
struct CoefficientState {
  bool is_estimated = false;
  double value = 0.0;
};

CoefficientState state_of(const FittedModel& fit, const std::string& name) {
  const auto place = std::ranges::find(fit.coefficient_names, name) - fit.coefficient_names.begin();
  if (place == std::ssize(fit.coefficient_names)) return {};
  // A coefficient that is held at a value or a bound has no variance.
  return {.is_estimated = !std::isnan(fit.covariance(place, place)), .value = fit.estimate[place]};
}

/// Whether it is known which coefficients of a fit are estimated: at least one has a variance, or
/// all are at their bounds. Without any variance, others may be held or have an unknown variance.
bool has_known_estimates(const FittedModel& fit) {
  if (fit.covariance.rows() != std::ssize(fit.coefficient_names)) return false;
  return !fit.covariance.diagonal().array().isNaN().all() ||
         std::ranges::all_of(fit.coefficient_names,
                             [&](const std::string& name) { return is_at_bound(fit, name); });
}

/// Whether the effects have a common variance, and there are several of them.
bool has_joint_variance(const RandomEffects& random) {
  return random.covariance == Covariance::kIdentity && random.coefficients.size() > 1;
}

/// The factor that is most similar to one of a simpler variance function, of those that may contain
/// it: the same stratum is preferred to the same kind. The end if there is none.
std::vector<VarianceFactor>::const_iterator most_alike(const std::vector<VarianceFactor>& factors,
                                                       const VarianceFactor& simpler) {
  auto best = factors.end();
  int best_score = -1;
  for (auto factor = factors.begin(); factor != factors.end(); ++factor) {
    const bool is_same_kind = factor->kind == simpler.kind;
    const bool is_power_within = kind_of(*factor).without_constant() == simpler.kind;
    if (!(is_same_kind || is_power_within) || factor->column != simpler.column) continue;
    const int score = (factor->stratum == simpler.stratum ? 2 : 0) + (is_same_kind ? 1 : 0);
    if (score <= best_score) continue;
    best = factor;
    best_score = score;
  }
  return best;
}

bool has_parameter(const ModelSpecification& specification, const std::string& name) {
  return std::ranges::find(specification.parameters, name, &ParameterModel::name) !=
         specification.parameters.end();
}

/// Collects what the larger model has in addition, up to the first obstacle.
class Comparer {
 public:
  Comparer(const FittedModel& larger, const FittedModel& smaller)
      : larger_fit_(larger),
        smaller_fit_(smaller),
        larger_(larger.specification),
        smaller_(smaller.specification) {}

  Nesting run() {
    compare_formulas();
    compare_columns();
    compare_parameters();
    compare_levels();
    compare_variance();
    compare_correlation();
    nesting_.is_nested = nesting_.reason.empty();
    return nesting_;
  }

 private:
  void fail(const std::string& reason) {
    if (nesting_.reason.empty()) nesting_.reason = reason;  // the first one
  }

  void compare_formulas() {
    if (larger_.formula.left != smaller_.formula.left) {
      fail(fmt::format(
          "the responses differ: {} and {}", larger_.formula.left, smaller_.formula.left));
    } else if (larger_.formula.right.text() != smaller_.formula.right.text()) {
      fail("the formulas differ, so it is unknown whether one is a special case of the other");
    }
  }

  /// Fits to the same observations have the same range of a column, unless the columns differ and
  /// only have the same name.
  void compare_columns() {
    for (const ColumnRange& small : smaller_fit_.ranges) {
      const auto large = std::ranges::find(larger_fit_.ranges, small.column, &ColumnRange::column);
      if (large == larger_fit_.ranges.end()) continue;
      if (large->low != small.low || large->high != small.high) {
        fail(fmt::format("the column {} differs between the fits: {} to {}, and {} to {}",
                         small.column,
                         data::shortest(small.low),
                         data::shortest(small.high),
                         data::shortest(large->low),
                         data::shortest(large->high)));
      }
    }
  }

  void compare_parameters() {
    for (const ParameterModel& small : smaller_.parameters) {
      if (!has_parameter(larger_, small.name)) {
        fail(fmt::format("only the smaller model estimates {}", small.name));
      }
    }
    for (const ParameterModel& large : larger_.parameters) {
      if (!has_parameter(smaller_, large.name)) {
        fail(fmt::format("only the larger model has the parameter {}", large.name));
      }
    }
    if (!has_known_estimates(larger_fit_) || !has_known_estimates(smaller_fit_)) {
      fail("a fit does not store which coefficients were estimated and which were fixed");
      return;
    }
    std::set<std::string> names;
    for (const FittedModel* const fit : {&larger_fit_, &smaller_fit_}) {
      names.insert(fit->coefficient_names.begin(), fit->coefficient_names.end());
    }
    for (const std::string& name : names) compare_coefficient(name);
  }

  void compare_coefficient(const std::string& name) {
    const CoefficientState large = state_of(larger_fit_, name);
    const CoefficientState small = state_of(smaller_fit_, name);
    if (large.is_estimated) {
      if (!small.is_estimated) ++nesting_.regular;
      nesting_.has_bounded = nesting_.has_bounded || is_at_bound(smaller_fit_, name);
      return;
    }
    const auto& known = larger_fit_.coefficient_names;
    if (std::ranges::find(known, name) == known.end()) {
      if (small.is_estimated || small.value != 0.0) {
        fail(fmt::format("only the smaller model has {}", name));
      }
    } else if (small.is_estimated) {
      fail(fmt::format("the larger model fixes {} at {}; the smaller model estimates it",
                       name,
                       data::shortest(large.value)));
    } else if (small.value != large.value) {
      fail(fmt::format("the larger model fixes {} at {}; the smaller model has {}",
                       name,
                       data::shortest(large.value),
                       data::shortest(small.value)));
    }
  }

  /// The random effects of a specification by the groups of a term, or null.
  static const RandomEffects* by_group(const ModelSpecification& specification,
                                       const RandomEffects& of) {
    for (const RandomEffects& term : specification.random) {
      const bool is_crossed = of.is_crossed || term.is_crossed;
      if (is_crossed ? term.has_groups_of(of) : term.group == of.group) return &term;
    }
    return nullptr;
  }

  void compare_levels() {
    for (const RandomEffects& term : smaller_.random) {
      if (by_group(larger_, term) == nullptr) {
        fail(fmt::format("only the smaller model has random effects by {}", term.group_name()));
        return;
      }
      fail(obstacle_to_same_groups(larger_fit_, smaller_fit_, term));
    }
    for (const RandomEffects& term : larger_.random) {
      compare_level(term, by_group(smaller_, term));
    }
  }

  /// The number of the block of each effect, by name.
  static int block_of(const RandomEffects& random, const std::string& name) {
    const auto at = std::ranges::find(random.coefficients, name) - random.coefficients.begin();
    if (at == static_cast<std::ptrdiff_t>(random.coefficients.size())) return -1;
    int block = 0;
    std::ptrdiff_t end = 0;
    for (const int size : random.block_sizes()) {
      end += size;
      if (at < end) return block;
      ++block;
    }
    return block;
  }

  void compare_level(const RandomEffects& large, const RandomEffects* small) {
    const std::vector<std::string> known =
        small == nullptr ? std::vector<std::string>{} : small->coefficients;
    for (const std::string& name : known) {
      if (block_of(large, name) < 0) {
        fail(fmt::format("only the smaller model has a random effect on {}", name));
        return;
      }
    }
    if (is_symmetric(large) || (small != nullptr && is_symmetric(*small))) {
      return compare_symmetric(large, small);
    }
    const bool is_identity = has_joint_variance(large);
    const bool was_identity = small != nullptr && has_joint_variance(*small);
    if (is_identity && !was_identity && small != nullptr) {
      fail(known.size() == 1 ? "a common variance for all random effects does not contain a model "
                               "with one random effect"
                             : "a common variance for all random effects does not contain a model "
                               "with several variances");
      return;
    }
    if (is_identity || (was_identity && known.size() != large.coefficients.size())) {
      compare_identity(large, small);
      return;
    }
    // Of effects that both have, one variance becomes several, which are regular parameters.
    if (was_identity) nesting_.regular += static_cast<int>(known.size()) - 1;
    const auto is_old = [&](const std::string& name) {
      return std::ranges::find(known, name) != known.end();
    };
    for (std::size_t j = 0; j < large.coefficients.size(); ++j) {
      const std::string& name = large.coefficients[j];
      int covariances = 0;
      for (std::size_t i = 0; i < large.coefficients.size(); ++i) {
        const std::string& other = large.coefficients[i];
        if (i == j || block_of(large, name) != block_of(large, other)) continue;
        ++covariances;
        const bool is_pair_of_old = i < j && is_old(name) && is_old(other);
        const bool was_free =
            is_pair_of_old && !was_identity && block_of(*small, name) == block_of(*small, other);
        if (is_pair_of_old && !was_free) ++nesting_.regular;
      }
      if (is_old(name)) continue;
      (covariances > 0 ? nesting_.correlated_effects : nesting_.independent_effects) += 1;
    }
    for (const std::string& name : known) {
      for (const std::string& other : known) {
        const bool was_free = !was_identity && block_of(*small, name) == block_of(*small, other);
        if (was_free && block_of(large, name) != block_of(large, other)) {
          fail("only the smaller model has covariances between some random effects");
        }
      }
    }
  }

  static bool is_symmetric(const RandomEffects& random) {
    return random.covariance == Covariance::kCompoundSymmetry && random.coefficients.size() > 1;
  }

  /// Compound symmetry is between a multiple of the identity and a general covariance.
  void compare_symmetric(const RandomEffects& large, const RandomEffects* small) {
    if (small == nullptr) {
      nesting_.has_other_edge = true;  // without effects their correlation is arbitrary
      return;
    }
    const auto effects = [](const RandomEffects& of) {
      return std::set(of.coefficients.begin(), of.coefficients.end());
    };
    const auto count = static_cast<int>(large.coefficients.size());
    if (effects(large) != effects(*small)) {
      fail("compound symmetry is a special case only if the random effects are the same");
    } else if (is_symmetric(large)) {
      if (!small->has_equal_variances()) {
        fail("compound symmetry does not contain a model with several variances");
      }
      if (!is_symmetric(*small)) nesting_.regular += 1;
    } else if (large.block_sizes().size() > 1) {
      fail("only the smaller model has covariances between some random effects");
    } else {
      nesting_.regular += count * (count + 1) / 2 - 2;
    }
  }

  void compare_identity(const RandomEffects& large, const RandomEffects* small) {
    if (small == nullptr) {
      nesting_.independent_effects += 1;  // one variance for all
    } else if (std::set(large.coefficients.begin(), large.coefficients.end()) !=
                   std::set(small->coefficients.begin(), small->coefficients.end()) ||
               large.covariance != small->covariance) {
      fail(
          "a common variance for all random effects is a special case only if the random effects "
          "are the same");
    }
  }

  void compare_variance() {
    std::vector<VarianceFactor> left = larger_.variance.factors;
    for (const VarianceFactor& small : smaller_.variance.factors) {
      const auto large = most_alike(left, small);
      if (large == left.end()) {
        fail(fmt::format("only the smaller model has the variance function {}", small.text()));
        return;
      }
      compare_factor(*large, small);
      left.erase(large);
    }
    for (const VarianceFactor& factor : left) {
      if (!contains_constant(factor)) {
        fail(fmt::format(
            "the larger model fixes the exponent of {}, which the smaller model does not have",
            factor.text()));
      }
      // Without the factor its constant is arbitrary: no reference distribution is known for this
      // case.
      const bool is_loose = kind_of(factor).has_constant() && !factor.constant;
      nesting_.has_other_edge = nesting_.has_other_edge || is_loose;
    }
  }

  /// Independence is inside the range of correlations that can have both signs, and at the edge of
  /// that of the others.
  void compare_correlation() {
    const auto& large = larger_.correlation;
    const auto& small = smaller_.correlation;
    if (large == small) return;
    if (!large) return fail("only the smaller model has correlated residuals");
    using Kind = Correlation::Kind;
    const bool has_both_signs = large->kind != Kind::kCar1 && large->kind < Kind::kExponential;
    if (!small) {
      nesting_.has_other_edge = nesting_.has_other_edge || !has_both_signs;
      return;
    }
    if (correlated_groups(larger_) != correlated_groups(smaller_)) {
      return fail(fmt::format("the residuals are correlated within other groups by {} than by {}",
                              large->text(),
                              small->text()));
    }
    const bool is_symmetric = large->kind == Kind::kSymmetric;
    const bool has_same_rows = large->columns == small->columns ||
                               (is_symmetric && small->kind == Kind::kCompoundSymmetry);
    const bool is_same = large->kind == small->kind && large->has_nugget >= small->has_nugget &&
                         large->autoregressive >= small->autoregressive &&
                         large->moving_average >= small->moving_average;
    // car1 is ar1 with a positive phi.
    const bool is_ar1 = small->kind == Kind::kAr1 || small->kind == Kind::kCar1;
    const bool is_order = is_ar1 && (large->kind == Kind::kAr1 || large->autoregressive > 0);
    // One correlation for each pair of times has those of any function of two times.
    if (!has_same_rows || !(is_same || is_order || is_symmetric)) {
      return fail(fmt::format("{} does not contain {}", large->text(), small->text()));
    }
    nesting_.has_other_edge = nesting_.has_other_edge || large->has_nugget != small->has_nugget;
  }

  /// The columns whose values together are the groups of rows that are correlated.
  static std::set<std::string> correlated_groups(const ModelSpecification& of) {
    std::set<std::string> result;
    for (const RandomEffects& term : of.random) result.insert(term.group);
    if (!of.correlation->group.empty()) result.insert(of.correlation->group);
    return result;
  }

  void compare_factor(const VarianceFactor& large, const VarianceFactor& small) {
    if (!small.stratum.empty() && large.stratum != small.stratum) {
      fail("the strata of the variance functions differ");
    }
    if (large.delta && (!small.delta || *small.delta != *large.delta)) {
      fail("the larger model fixes an exponent that the smaller model does not fix");
    }
    const bool is_power_within = kind_of(large).without_constant() == small.kind;
    const std::optional<double> constant = is_power_within ? 0.0 : small.constant;
    if (large.constant && constant != large.constant) {
      fail("the larger model fixes a constant that the smaller model does not fix");
    }
    if (is_power_within && !large.constant) nesting_.has_other_edge = true;
  }

  const FittedModel& larger_fit_;
  const FittedModel& smaller_fit_;
  const ModelSpecification& larger_;
  const ModelSpecification& smaller_;
  Nesting nesting_;
};

}  // namespace

Nesting nesting(const FittedModel& larger, const FittedModel& smaller) {
  return Comparer(larger, smaller).run();
}

}  // namespace silvafit::fit
