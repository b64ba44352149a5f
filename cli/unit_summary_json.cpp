// SPDX-License-Identifier: MIT
#include "unit_summary_json.hpp"

#include <string>

#include "standard_output.hpp"

namespace silvafit::cli {

nlohmann::ordered_json unit_summary_json(const stand::UnitSummary& summary,
                                         const std::vector<stand::FurtherIndex>& further) {
  nlohmann::ordered_json result{{"trees", summary.trees},
                                {"core", summary.core_trees},
                                {"W", number_or_null(summary.W)},
                                {"M", number_or_null(summary.M)},
                                {"U", number_or_null(summary.U)},
                                {"C", number_or_null(summary.C)}};
  for (std::size_t i = 0; i < summary.further.size(); ++i) {
    result[std::string(stand::name_of(further[i]))] = number_or_null(summary.further[i]);
  }
  return result;
}

}  // namespace silvafit::cli
