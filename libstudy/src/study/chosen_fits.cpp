// SPDX-License-Identifier: MIT
#include "study/chosen_fits.hpp"

#include <cmath>

#include "study/letter_groups.hpp"
#include "study/nested_tests.hpp"

namespace silvafit::study {
namespace {

bool differ(const fit::FittedModel& larger,
            const fit::FittedModel& smaller,
            const StudyOptions& options) {
  if (const auto test = nested_test(larger, smaller)) return test->p < options.significance;
  return std::abs(larger.aic() - smaller.aic()) > options.equally_good;
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

std::optional<LikelihoodRatioTest> test_against_before(const std::vector<ChosenFit>& fits,
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

}  // namespace silvafit::study
