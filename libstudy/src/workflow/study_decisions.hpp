// SPDX-License-Identifier: MIT
// The decisions of a study as sentences, for its report.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "silvafit/study/study_record.hpp"

namespace silvafit::study {

using Decisions = std::vector<std::pair<std::string, std::string>>;

/// The decisions before fitting, and the rule by which each level chose.
Decisions decisions_of(const StudyRecord& record);

}  // namespace silvafit::study
