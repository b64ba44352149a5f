// SPDX-License-Identifier: MIT
// Names of a formula that were taken as parameters and may be misspelt columns.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "silvafit/fit/finding.hpp"
#include "silvafit/fit/model_specification.hpp"

namespace silvafit::fit {

struct NameDoubts {
  std::vector<std::string> names{};  ///< that may be misspelt columns
  std::vector<Finding> findings{};   ///< about them
};

/// Doubts that hold whatever the fit is: a name near that of a column, and parameters that have one
/// effect together only, such as b and dhb in a + b*dhb.
/// \param known  names that the caller has treated as parameters, by a start value or a bound
/// \param held   coefficients that are not estimated
NameDoubts name_doubts(const ModelSpecification& specification,
                       const std::set<std::string>& known,
                       const std::map<std::string, double>& held);

/// For a fit that failed: all names that were taken as parameters, each with the columns near it.
/// None if all of them are known or said.
/// \param said  names of which the message speaks already
std::vector<std::string> parameters_taken(const ModelSpecification& specification,
                                          const std::set<std::string>& known,
                                          const std::set<std::string>& said);

}  // namespace silvafit::fit
