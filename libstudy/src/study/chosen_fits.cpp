// SPDX-License-Identifier: MIT
#include "study/chosen_fits.hpp"

#include <cmath>
#include <cstddef>

#include "study/nested_tests.hpp"

namespace silvafit::study {
namespace {

bool differ(const fit::FittedModel& larger,
            const fit::FittedModel& smaller,
            const StudyOptions& options) {
  if (const auto test = nested_test(larger, smaller)) return test->p < options.significance;
  return std::abs(larger.aic() - smaller.aic()) > options.equally_good;
}

using Set = std::vector<bool>;

bool is_within(const Set& inner, const Set& outer) {
  for (std::size_t k = 0; k < inner.size(); ++k) {
    if (inner[k] && !outer[k]) return false;
  }
  return true;
}

/// Sets that contain both members are split into one without each.
std::vector<Set> split_between(const std::vector<Set>& sets,
                               std::size_t first,
                               std::size_t second) {
  std::vector<Set> result;
  for (const Set& set : sets) {
    result.push_back(set);
    if (!set[first] || !set[second]) continue;
    result.back()[second] = false;
    result.push_back(set);
    result.back()[first] = false;
  }
  return result;
}

/// Subsets of other sets are removed; of equal sets the first remains.
std::vector<Set> without_subsets(const std::vector<Set>& sets) {
  std::vector<Set> result;
  for (std::size_t a = 0; a < sets.size(); ++a) {
    bool is_needed = true;
    for (std::size_t b = 0; b < sets.size() && is_needed; ++b) {
      if (a != b && is_within(sets[a], sets[b])) is_needed = sets[a] == sets[b] && a < b;
    }
    if (is_needed) result.push_back(sets[a]);
  }
  return result;
}

}  // namespace

std::vector<ChosenFit> chosen_fits(const ResponseStudy& result) {
  std::vector<ChosenFit> fits;
  if (result.ols) fits.push_back({"ols", &result.ols->fit});
  if (result.with_covariates) fits.push_back({"covariates", &result.with_covariates->fit});
  if (result.nlme) fits.push_back({"nlme", &result.nlme->fit});
  return fits;
}

std::vector<ChosenFit> distinct_fits(const ResponseStudy& result) {
  std::vector<ChosenFit> fits = chosen_fits(result);
  std::erase_if(fits, [&](const ChosenFit& chosen) {
    return chosen.level == "covariates" && result.ols &&
           chosen.fit->coefficient_names == result.ols->fit.coefficient_names;
  });
  return fits;
}

std::string grouping_suffix(const fit::FittedModel& fit, std::size_t grouping) {
  if (fit.random.size() < 2) return "";
  return " | " + fit.specification.random[grouping].group;
}

std::optional<fit::NestedTest> test_against_before(const std::vector<ChosenFit>& fits,
                                                   std::size_t index) {
  if (index == 0) return std::nullopt;
  return nested_test(*fits[index].fit, *fits[index - 1].fit);
}

std::vector<std::string> letters_of(const std::vector<ChosenFit>& fits,
                                    const StudyOptions& options) {
  std::vector<std::vector<bool>> differs(fits.size(), std::vector<bool>(fits.size(), false));
  for (std::size_t i = 0; i < fits.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      differs[i][j] = differs[j][i] = differ(*fits[i].fit, *fits[j].fit, options);
    }
  }
  return letter_groups(differs);
}

std::vector<std::string> letter_groups(const std::vector<std::vector<bool>>& differs) {
  const std::size_t n = differs.size();
  std::vector<Set> sets{Set(n, true)};
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      if (differs[i][j]) sets = without_subsets(split_between(sets, i, j));
    }
  }
  std::vector<std::string> letters(n);
  for (std::size_t s = 0; s < sets.size(); ++s) {
    for (std::size_t k = 0; k < n; ++k) {
      if (sets[s][k]) letters[k] += static_cast<char>('a' + s);
    }
  }
  return letters;
}

}  // namespace silvafit::study
