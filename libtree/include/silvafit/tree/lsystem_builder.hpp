// SPDX-License-Identifier: MIT
// L-system trees, fitted to their measurements.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/lsystem.hpp"

namespace silvafit::tree {

/// Fields of grammar presets in addition to those of all freely grown trees.
struct LsystemPreset : FreePreset {
  /// The grammar of trees from a minimum height on; the constants may differ by height.
  struct Stage {
    double from_m = 0.0;
    Grammar grammar;
  };
  std::vector<Stage> stages{};  ///< at least one, by increasing height, the first from 0
  std::optional<std::uint32_t> bud_grade{};  ///< the index of the leaf type for buds
};

/// Derives a grammar, draws it, and fits the skeleton to the measurements.
class LsystemBuilder : public FreeBuilder {
 public:
  /// \param models  folder with taper/ and grammars/
  /// \param file    a preset, as docs/tree-builders.md describes it
  /// \throws InputError naming file and field, or file and line of the grammar
  static std::unique_ptr<LsystemBuilder> load(const std::filesystem::path& models,
                                              const std::filesystem::path& file);

  explicit LsystemBuilder(LsystemPreset preset);
  ~LsystemBuilder() override;

  /// The same crown, taper, bark and leaves with a user's grammar.
  std::unique_ptr<LsystemBuilder> with_grammar(const Grammar& grammar) const;

  const LsystemPreset& preset() const override { return preset_; }

  /// A grammar without random numbers is derived only once.
  /// \throws InputError as Grammar::derive, draw and skeleton_of
  Skeleton grow_freely(double h_m, Random& random) const override;

 private:
  struct Derived;

  Skeleton drawn(double h_m, bool has_leaves, Random& random) const override;
  std::string file_of(double h_m) const override;
  /// The stage with the grammar for trees of that height.
  std::size_t stage_of(double h_m) const;
  Skeleton derive(const Grammar& grammar, Random& random) const;

  LsystemPreset preset_;
  std::vector<std::unique_ptr<Derived>> derived_;  ///< of each stage
};

}  // namespace silvafit::tree
