// SPDX-License-Identifier: MIT
// The chosen models of a result: the models of the levels, and which of them differ.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "silvafit/study/study.hpp"

namespace silvafit::study {

/// Letters of models in an order: two share one if and only if they do not differ.
/// \param differs  (n x n) symmetric
/// Source: Piepho 2004, J. Comput. Graph. Stat. 13, 456-466.
std::vector<std::string> letter_groups(const std::vector<std::vector<bool>>& differs);

/// A chosen model and the name of its level: ols, covariates or nlme.
struct ChosenFit {
  std::string level{};
  const fit::FittedModel* fit = nullptr;
};

/// The chosen models of a result in the order of the levels; missing ones are skipped.
std::vector<ChosenFit> chosen_fits(const ResponseStudy& result);

/// The same without a model of level 2 that has no covariates: it is that of level 1.
std::vector<ChosenFit> distinct_fits(const ResponseStudy& result);

/// What tells the random effects of a grouping from those of another, " | plot"; empty if the fit
/// has one grouping.
std::string grouping_suffix(const fit::FittedModel& fit, std::size_t grouping);

/// The likelihood-ratio test of a chosen model against the one before it; nothing for the first.
std::optional<fit::NestedTest> test_against_before(const std::vector<ChosenFit>& fits,
                                                   std::size_t index);

/// Letters of the models: two share one if they do not differ. Nested models differ where their
/// likelihood-ratio test is significant, others where their AIC are farther apart than those of
/// models that are equally good.
std::vector<std::string> letters_of(const std::vector<ChosenFit>& fits,
                                    const StudyOptions& options);

}  // namespace silvafit::study
