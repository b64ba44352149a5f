// SPDX-License-Identifier: MIT
// Curves of several models of one response over DBH.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "silvafit/study/model_library.hpp"

namespace silvafit::study {

struct ComparedCurves {
  std::map<std::string, double> held_at{};
  std::vector<double> dbh_cm{};
  bool own_heights = false;                   ///< heights are those of each library's height model
  std::vector<std::vector<double>> values{};  ///< by library; empty without a curve, NaN outside
                                              ///< the DBH that the model was fitted to
};

/// Population curves of the models of one species, response and role; empty if no model
/// has a curve.
/// \param models     by library, null if it has no such model
/// \param libraries  in the same order
ComparedCurves compared_curves(const std::vector<const LibraryModel*>& models,
                               const std::vector<ModelLibrary>& libraries);

}  // namespace silvafit::study
