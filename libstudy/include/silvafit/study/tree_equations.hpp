// SPDX-License-Identifier: MIT
// Published equations of volume, biomass and carbon of trees, as data.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/expression.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/inventory.hpp"

namespace silvafit::study {

/// Values of a column for which an equation was fitted, in our unit.
struct EquationRange {
  std::string column{};
  double low = 0.0;
  double high = 0.0;
};

/// A value of an equation computed outside of the program; arguments and value in our units.
struct EquationPoint {
  std::map<std::string, double> arguments{};
  double value = 0.0;
};

/// One entry of a file of equations.
struct TreeEquation {
  std::string id{};
  std::string title{};
  std::string quantity{};  ///< volume, biomass, carbon, stem_biomass ...
  std::string unit{};      ///< of the value: m3 or kg
  std::string formula{};   ///< as in the file, in the file's units
  /// The value in `unit`, of columns in our units.
  data::Expression value = data::Expression::constant(0.0);
  std::vector<std::string> species{};  ///< for which it was fitted; empty: unknown
  std::string region{};
  std::vector<EquationRange> domain{};
  std::vector<std::string> source{};
  std::string notes{};
  std::vector<EquationPoint> reference_points{};
  std::string file{};
};

/// The equations of models/equations, and of further files of the same form (docs/stand.md).
class TreeEquations {
 public:
  /// \param models  the catalogue's folder
  /// \throws InputError that names file and key if an entry cannot be used
  static TreeEquations load(const std::filesystem::path& models);

  /// Adds the equations of a file; one with the id of an earlier one replaces it.
  void add(const std::filesystem::path& file);

  const std::vector<TreeEquation>& all() const { return equations_; }
  /// \throws UsageError with the nearest names if there is no such equation
  const TreeEquation& find(std::string_view id) const;

 private:
  std::vector<TreeEquation> equations_{};
};

/// Which equations are used for which trees.
struct EquationSettings {
  /// `ID`, or `SPECIES=ID`. The id `taper` is the volume of the stem by the taper equation that the
  /// tree is drawn with.
  std::vector<std::string> equations{};
  std::vector<std::string> files{};  ///< further equations
  std::filesystem::path models{};    ///< the catalogue's folder
};

struct TreeQuantities {
  std::vector<stand::TreeQuantity> quantities{};  ///< in the order of the settings
  std::vector<std::string> notes{};               ///< missing values, trees outside of domains
};

/// Values of each tree. Trees outside of an equation's domain have values, with a note; those
/// without a needed measure, or with a value that is not positive, have none, with a note.
/// \param trees  with our columns and those that equations need; an equation may also use the
///               quantities before it, such as carbon the biomass
/// \throws UsageError if a setting cannot be used or two equations are meant for the same trees;
///   InputError if an equation needs a column that is missing
TreeQuantities tree_quantities(const data::Table& trees, const EquationSettings& settings);

/// tree_quantities() of an inventory in parts; the notes are on all parts together.
class QuantitiesOfParts {
 public:
  /// \throws UsageError as tree_quantities()
  explicit QuantitiesOfParts(const EquationSettings& settings);
  ~QuantitiesOfParts();
  QuantitiesOfParts(QuantitiesOfParts&&) noexcept;
  QuantitiesOfParts& operator=(QuantitiesOfParts&&) noexcept;

  std::vector<stand::TreeQuantity> add(const data::Table& trees);
  std::vector<std::string> notes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Columns besides ours that the equations need.
std::vector<std::string> columns_of(const EquationSettings& settings);

}  // namespace silvafit::study
