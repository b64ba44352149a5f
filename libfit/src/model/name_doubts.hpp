// SPDX-License-Identifier: MIT
// Names of a formula that were taken as parameters and may be misspelt columns.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "silvafit/fit/model_specification.hpp"

namespace silvafit::fit {

struct NameDoubts {
  std::vector<std::string> names{};  ///< that may be misspelt columns
  std::string text{};                ///< the sentences about them; empty if there are none
};

/// Doubts that hold whatever the fit is: a name near that of a column, and parameters that have one
/// effect together only, such as b and dhb in a + b*dhb.
/// \param known  names that the caller has treated as parameters, by a start value or a bound
/// \param held   coefficients that are not estimated
NameDoubts name_doubts(const ModelSpecification& specification,
                       const std::set<std::string>& known,
                       const std::map<std::string, double>& held);

/// The sentence for a fit that failed: all names that were taken as parameters, and columns near
/// them. Empty if all of them are known or said.
/// \param said  names of which the message speaks already
std::string parameters_taken(const ModelSpecification& specification,
                             const std::set<std::string>& known,
                             const std::set<std::string>& said);

}  // namespace silvafit::fit
