// SPDX-License-Identifier: MIT
#include "report/left_out_json.hpp"

#include <nlohmann/json.hpp>

#include "silvafit/base/json_values.hpp"

namespace silvafit::study {

nlohmann::ordered_json left_out_object(const ResponseStudy& result) {
  if (!result.left_out) return nullptr;
  const LeftOutPlots& left_out = *result.left_out;
  return {{"folds", left_out.folds},
          {"trees", left_out.trees},
          {"rmse_ols", number_or_null(left_out.rmse_ols)},
          {"rmse_covariates", number_or_null(left_out.rmse_covariates)},
          {"rmse_nlme", number_or_null(left_out.rmse_nlme)},
          {"r2_ols", number_or_null(left_out.r2_ols)},
          {"r2_covariates", number_or_null(left_out.r2_covariates)},
          {"r2_nlme", number_or_null(left_out.r2_nlme)},
          {"t", number_or_null(left_out.t)},
          {"worse", left_out.is_worse}};
}

}  // namespace silvafit::study
