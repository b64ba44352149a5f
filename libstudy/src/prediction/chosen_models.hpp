// SPDX-License-Identifier: MIT
// Chooses the models of a library that predict the trees of a table.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/study/model_library.hpp"
#include "silvafit/study/predict_responses.hpp"

namespace silvafit::study {

/// The models of one response, by species; the species "" stands for all.
struct ResponseModels {
  std::string response{};
  std::map<std::string, const LibraryModel*> by_species{};
  /// The reason why the usual model of a species is not used.
  std::map<std::string, std::string> remarks{};

  /// Null if there is none.
  const LibraryModel* model_for(const std::string& species) const;
  bool needs(const std::string& column) const;
  bool is_by_species() const;
};

struct ChosenModels {
  std::vector<ResponseModels> responses{};  ///< in the order of the library
  std::vector<UnusedModel> unused{};        ///< for which the table lacks columns
  std::vector<std::string> notes{};         ///< for the user
};

/// Of each response and species the model of the role that converged and has the lowest AIC. Where
/// the table lacks a column of it, and no other response predicts that column, the next one that
/// does not need it; if there is none, no model.
/// \param role  empty: nlme, and simpler ones where the table lacks a column
/// \throws UsageError if the library has no model of the role that converged; InputError if the
///   library is empty, or columns are missing for all of its models
ChosenModels choose_models(const ModelLibrary& library,
                           const data::Table& table,
                           const std::string& role);

/// The responses in an order of prediction: those that others need come first.
std::vector<std::size_t> order_of(const std::vector<ResponseModels>& models);

}  // namespace silvafit::study
