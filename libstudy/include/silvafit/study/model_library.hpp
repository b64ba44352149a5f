// SPDX-License-Identifier: MIT
// Model libraries: the fits of a study in one file, for prediction and for other programs.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/json_reader.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::study {

/// The data that a library was fitted to.
struct LibraryInventory {
  std::string file{};
  std::string fingerprint{};  ///< of the bytes of the file: "fnv1a64:..."; may be empty
  std::size_t trees = 0;
  std::map<std::string, double> commonest_dbh_cm{};  ///< by species; see commonest_dbh_cm()
  std::optional<UnitSettings> units{};  ///< what its structural indices, if any, were computed with
};

/// The models of a study by their role, from the simplest one, which needs the fewest columns.
inline constexpr std::array<std::string_view, 3> kRoles{"ols", "covariates", "nlme"};

/// One fit and its use.
struct LibraryModel {
  std::string species{};   ///< empty: for trees of any species
  std::string response{};  ///< "h"
  std::string unit{};      ///< of the response, "m"; empty where it is not known
  std::string role{};      ///< one of kRoles; empty: used for every requested role
  fit::FittedModel fit;
};

struct ModelLibrary {
  LibraryInventory inventory{};
  std::vector<LibraryModel> models{};
};

/// The library as JSON, schema silvafit-library/1 (docs/json.md). Doubles read back bit by bit.
std::string to_json(const ModelLibrary& library);

/// Writes the library, whole or not at all.
/// \throws IoError if the file cannot be written
void write_library(const ModelLibrary& library, const std::filesystem::path& path);

/// Reads a library, published coefficients, or what `silvafit fit --json` prints: one fit or
/// several, which have neither species nor role and the left side of their formula as response.
/// \throws InputError that names file and key if it is none of these, or from a newer silvafit
ModelLibrary read_library(const std::filesystem::path& path);
/// The same from JSON that has been read already, such as the text of a library in memory.
ModelLibrary read_library(const data::JsonReader& json);

/// Names of the published libraries in `published` of the folder models, in alphabetical order.
/// \throws InputError if the folder cannot be read
std::vector<std::string> published_libraries(const std::filesystem::path& models_directory);

/// Reads a file, or the published library of that name: `shanxia-2023`.
/// \throws InputError that lists the published ones if it is neither; as read_library
ModelLibrary find_library(const std::string& name_or_file,
                          const std::filesystem::path& models_directory);

}  // namespace silvafit::study
