// SPDX-License-Identifier: MIT
#include "report/report_fit.hpp"

#include "silvafit/fit/fit_json.hpp"

namespace silvafit::study {

using nlohmann::ordered_json;

ordered_json fit_object(const fit::FittedModel& fit) {
  ordered_json object = fit::json_of(fit);
  object.erase("seconds");
  if (!fit.has_random_effects() || !fit.uncertainty.is_known()) return object;
  ordered_json& random = object["random"];
  // Matrices of each group would double the page; it shows their diagonals.
  for (const char* key : {"eblup_covariance", "eblup_by_fixed", "eblup_outer_covariance"}) {
    random.erase(key);
  }
  return object;
}

}  // namespace silvafit::study
