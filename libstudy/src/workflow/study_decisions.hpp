// SPDX-License-Identifier: MIT
// The decisions of a study in words, for its report.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "silvafit/study/study_record.hpp"

namespace silvafit::study {

using Decisions = std::vector<std::pair<std::string, std::string>>;

/// What was decided before fitting, and how each level chose.
Decisions decisions_of(const StudyRecord& record);

}  // namespace silvafit::study
