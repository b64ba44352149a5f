// SPDX-License-Identifier: MIT
// The coefficients that vary between groups, and the form of their covariance.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/enum_words.hpp"

namespace silvafit::fit {

/// The form of the covariance matrix Psi of a group's random effects.
enum class Covariance { kGeneral, kDiagonal, kIdentity, kBlock, kCompoundSymmetry };
constexpr std::array<std::string_view, 5> words_of(Covariance /*covariance*/) {
  return {"general", "diagonal", "identity", "block", "compound-symmetry"};
}

/// Coefficients that vary between groups, written `a + b:C | plot`.
struct RandomEffects {
  std::vector<std::string> coefficients{};
  std::string group{};  ///< the column whose values are the groups
  /// The columns of the coarser groups within which the labels of `group` hold, the coarsest first,
  /// written `| stand/plot`: equal labels in different stands are different plots. Empty if not
  /// written.
  std::vector<std::string> within{};
  /// Whether this is a term of groups that are not one or two nested levels: crossed ones, three
  /// levels, or combinations such as `| recipe:replicate`. Then it is so of all terms.
  bool is_crossed = false;
  Covariance covariance = Covariance::kGeneral;
  /// For kBlock: number of coefficients of each block, in order. Effects of different blocks are
  /// independent.
  std::vector<int> blocks{};

  /// Sizes of the blocks within which covariances are not zero: all in one for the general form and
  /// compound symmetry, ones for the diagonal form and multiples of the identity.
  std::vector<int> block_sizes() const;
  /// Whether all effects have the same variance, and all pairs of them the same correlation.
  bool has_equal_variances() const {
    return covariance == Covariance::kIdentity || covariance == Covariance::kCompoundSymmetry;
  }
  /// The coefficients as text, blocks in parentheses: "(a + b) + c".
  std::string text() const;
  /// The groups as text: "plot", or "stand/plot" if the labels hold within stands; of crossed terms
  /// "stand:plot", which is one term, not two.
  std::string group_text() const;
  /// The groups in names of parameters: the column, of crossed terms group_text().
  std::string group_name() const { return is_crossed ? group_text() : group; }
  bool has_groups_of(const RandomEffects& other) const {
    return group == other.group && within == other.within;
  }
};

/// Whether the groups are not those of one or two nested levels; see RandomEffects::is_crossed.
bool are_crossed(const std::vector<RandomEffects>& terms);

/// Reads `a + b + b:C | plot`; parentheses make blocks, as in `(a + b) + c | plot`. Nested
/// groupings: `a | stand/plot` gives both the same effects, `a | stand; a + b | plot` each its own.
/// `a | stand; a + b | stand/plot` is the latter with labels of plots that hold within stands.
/// Crossed groupings: `a | plot + year`, or `(a | plot) + (a + b | year)` with own effects.
/// \returns one element for each grouping; two nested ones with the coarser one first
/// \throws FormulaError with the position of the error
std::vector<RandomEffects> parse_random_effects(std::string_view text);

/// Whether all terms between semicolons are in parentheses, as lme4 writes them: terms that may be
/// crossed.
bool are_bars(std::string_view text);

/// The label of a group within a coarser one, `outer/inner`. A slash of the coarser label becomes
/// `%2F`, so that different groups have different labels: `A` with `1/1` is not `A/1` with `1`.
std::string nested_label(std::string_view outer, std::string_view inner);
/// The same for any number of coarser groups, from the coarsest one.
std::string nested_label(const std::vector<std::string_view>& labels);

/// The labels in a nested one.
struct NestedParts {
  std::string_view outer{};  ///< in the form of outer_part(); empty if there is no slash
  std::string_view inner{};
};

/// Splits a label of nested_label(); the parts are views of it.
NestedParts nested_parts(std::string_view label);
/// The label of a coarser group in the form of nested labels, with `%2F` for a slash.
std::string outer_part(std::string_view outer);
/// The label of a coarser group from that form.
std::string without_escapes(std::string_view part);

/// Reads general, diagonal, identity or compound-symmetry; blocks are made in the text of random
/// effects.
Covariance parse_covariance(std::string_view text);

}  // namespace silvafit::fit
