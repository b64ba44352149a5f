// SPDX-License-Identifier: MIT
// The stages of a study, one after the other for all species and responses.
#pragma once

#include <vector>

#include "silvafit/study/study.hpp"
#include "study/study_work.hpp"

namespace silvafit::study {

/// Runs the three levels and the cross-validation of the chosen models; fills in the results of the
/// works, and the study's stages.
/// \param works  must not move in memory
void run_stages(std::vector<Work>& works, Study& study, const ProgressCallback& progress);

}  // namespace silvafit::study
