// SPDX-License-Identifier: MIT
// What a report shows besides fits: the stand, height curves, and decisions as sentences.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/study_record.hpp"

namespace silvafit::study {

/// Adds values per hectare, volumes by the taper equations and the height curves of the study.
/// Nothing without areas, or with repeated measurements.
void add_stand(const stand::StructuralUnitOptions& units,
               const stand::SamplingDesign& design,
               const Catalogue& catalogue,
               StudyRecord& record);

/// Height curves of the species of an inventory with enough measured trees, by least squares.
std::vector<HeightCurve> height_curves_of(const stand::Inventory& inventory,
                                          const Catalogue& catalogue);

using Decisions = std::vector<std::pair<std::string, std::string>>;

/// The decisions before fitting, and the rule by which each level chose.
Decisions decisions_of(const StudyRecord& record);

}  // namespace silvafit::study
