// SPDX-License-Identifier: MIT
// Trees of a 3D page from a table.
#pragma once

#include <string>

#include "silvafit/data/table.hpp"
#include "silvafit/study/view_data.hpp"
#include "silvafit/tree/builder.hpp"
#include "view/view_stand.hpp"

namespace silvafit::study {

/// \throws as view_of_trees()
ViewStand read_view_stand(const data::Table& table,
                          const tree::BuilderCatalogue& catalogue,
                          const ViewOptions& options);

/// The preset of a species, or that for species that no preset lists.
const tree::Builder& builder_of(const std::string& species,
                                const tree::BuilderCatalogue& catalogue);

}  // namespace silvafit::study
