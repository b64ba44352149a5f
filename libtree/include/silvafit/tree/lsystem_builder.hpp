// SPDX-License-Identifier: MIT
// L-system trees, fitted to their measurements.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/fitted_skeleton.hpp"
#include "silvafit/tree/lsystem.hpp"
#include "silvafit/tree/smooth_mesh.hpp"

namespace silvafit::tree {

/// Fields of grammar presets in addition to those of all builders.
struct LsystemPreset {
  /// The grammar of trees from a minimum height on; the constants may differ by height.
  struct Stage {
    double from_m = 0.0;
    Grammar grammar;
  };
  std::vector<Stage> stages{};  ///< at least one, by increasing height, the first from 0
  FitOptions fit{};
  SmoothStyle style{};
  std::optional<std::uint32_t> bud_grade{};  ///< the index of the leaf type for buds
};

/// Derives a grammar, draws it, and fits the skeleton to the measurements.
class LsystemBuilder : public Builder {
 public:
  /// \param models  folder with taper/ and grammars/
  /// \param file    a preset, as docs/tree-builders.md describes it
  /// \throws InputError naming file and field, or file and line of the grammar
  static std::unique_ptr<LsystemBuilder> load(const std::filesystem::path& models,
                                              const std::filesystem::path& file);

  LsystemBuilder(PresetHead head, LsystemPreset preset);
  ~LsystemBuilder() override;

  /// The same crown, taper, bark and leaves with a user's grammar.
  std::unique_ptr<LsystemBuilder> with_grammar(const Grammar& grammar) const;

  const LsystemPreset& lsystem() const { return lsystem_; }

  /// A grammar without random numbers is derived only once.
  /// \throws InputError as Grammar::derive, draw and skeleton_of
  Skeleton grow_freely(double h_m, Random& random) const override;

  /// \throws InputError as grow_freely; GeometryError naming the grammar's file, as
  /// fit_to_measurements
  Skeleton grow_skeleton(const TreeShape& shape, const Crown& crown, Random& random) const override;
  Skeleton grow_skeleton_for(const MeshOptions& mesh,
                             const TreeShape& shape,
                             const Crown& crown,
                             Random& random) const override;
  Mesh build_mesh(const Skeleton& skeleton,
                  const Crown& crown,
                  Random& random,
                  const MeshOptions& options) const override;

 private:
  struct Derived;

  /// The stage with the grammar for trees of that height.
  std::size_t stage_of(double h_m) const;
  Skeleton derive(const Grammar& grammar, Random& random) const;
  Skeleton fitted(Skeleton grown, const TreeShape& shape, const Crown& crown, Random& random) const;

  LsystemPreset lsystem_;
  std::vector<std::unique_ptr<Derived>> derived_;  ///< of each stage
};

}  // namespace silvafit::tree
