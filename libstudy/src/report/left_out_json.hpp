// SPDX-License-Identifier: MIT
// Predictions for plots left out, as JSON of the report and of run.json.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "silvafit/study/study.hpp"

namespace silvafit::study {

/// null if there are none.
nlohmann::ordered_json left_out_object(const ResponseStudy& result);

}  // namespace silvafit::study
