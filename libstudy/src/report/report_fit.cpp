// SPDX-License-Identifier: MIT
#include "report/report_fit.hpp"

#include "silvafit/fit/fit_json.hpp"

namespace silvafit::study {

using nlohmann::ordered_json;

ordered_json fit_object(const fit::FittedModel& fit) {
  ordered_json object = fit::json_of(fit);
  object.erase("seconds");
  // Matrices of each group would double the size of the page, which shows their diagonals only.
  for (ordered_json& term : object["random"]) {
    for (const char* key : {"eblup_covariance", "eblup_by_fixed", "eblup_cross_covariance"}) {
      term.erase(key);
    }
  }
  return object;
}

}  // namespace silvafit::study
