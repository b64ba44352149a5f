// SPDX-License-Identifier: MIT
// The trees of a 3D page with their measurements: read from a table or a scene, written as JSON.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/study/view_data.hpp"
#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/morphology.hpp"
#include "silvafit/tree/morphology_table.hpp"
#include "view/view_models.hpp"

namespace silvafit::study {

/// A column for colors: numbers, or texts.
struct ViewColumn {
  std::string name{};
  std::vector<std::string> texts{};  ///< distinct texts by falling number of trees; empty: numbers
  std::vector<double> values{};      ///< of the trees; indices of texts; NaN if missing
};

/// The columns that have no colors of their own: at most 30, in the order of the table. Columns
/// with a single value, and of texts those with more than 40 (names, remarks), are left out.
/// \param used  other names of the columns of trees, as in ViewOptions
/// \param rows  of the trees
std::vector<ViewColumn> color_columns(const data::Table& table,
                                      const std::map<std::string, std::string>& used,
                                      std::span<const std::size_t> rows);

/// Height, crown base, crown width [m]; NaN where unknown.
struct ViewSizes {
  double h_m = data::kMissing;
  double hcb_m = data::kMissing;
  double cw_m = data::kMissing;
};

struct ViewTree {
  std::string plot{};
  std::string tree{};
  std::string species{};
  const tree::Builder* preset = nullptr;
  tree::Position position{};
  double dbh_cm = data::kMissing;
  ViewSizes observed{};
  std::array<double, 4> indices{
      data::kMissing, data::kMissing, data::kMissing, data::kMissing};  ///< W, M, U, C
  double core = data::kMissing;
  /// The tree's node in the scene, or the number of its instance.
  std::optional<std::size_t> node{};
  std::optional<std::size_t> number{};
};

/// A tree with the sizes of a variant.
struct ViewVersion {
  ViewSizes sizes{};                       ///< as in the table
  std::optional<tree::TreeShape> shape{};  ///< none if the sizes are impossible
};

/// One set of sizes of all trees.
struct ViewVariant {
  std::string name{};   ///< observed, ols, population, conditional, thinned
  std::string title{};  ///< for people
  std::vector<ViewVersion> trees{};
};

struct ViewStand {
  std::vector<ViewTree> trees{};
  std::vector<ViewVariant> variants{};
  std::vector<ViewColumn> columns{};      ///< for colors
  std::vector<tree::LeftOut> left_out{};  ///< rows that cannot be drawn in any variant
  std::vector<std::string> notes{};
};

/// \throws as view_of_trees()
ViewStand read_view_stand(const data::Table& table,
                          const tree::BuilderCatalogue& catalogue,
                          const ViewOptions& options);

/// The preset of a species, or that for species that no preset lists.
const tree::Builder& builder_of(const std::string& species,
                                const tree::BuilderCatalogue& catalogue);

struct SceneTrees {
  ViewStand stand{};
  tree::Position origin{};     ///< of the scene's frame in the inventory's coordinates
  std::size_t unmeasured = 0;  ///< trees of a scene without any measurements
};

/// \throws as view_of_scene()
SceneTrees trees_of_scene(std::string_view glb,
                          const data::Table* table,
                          const tree::BuilderCatalogue& catalogue,
                          const ViewOptions& options);

/// Base64 with padding. Source: RFC 4648, section 4.
std::string base64(std::string_view bytes);

/// The objects that the page draws.
struct ViewDrawing {
  tree::Position origin{};
  const ViewModels* models = nullptr;  ///< of all trees of all variants that have a shape
  std::string scene{};                 ///< GLB, instead of models
};

std::string view_json(const ViewStand& stand,
                      const ViewDrawing& drawing,
                      const ViewOptions& options);

}  // namespace silvafit::study
