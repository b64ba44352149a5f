// SPDX-License-Identifier: MIT
// Stands with overlapping crowns: which branches are removed, which are turned, and where the
// crowns meet.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "silvafit/tree/crown_meeting.hpp"
#include "silvafit/tree/mesh.hpp"
#include "silvafit/tree/territory.hpp"

namespace silvafit::tree {

/// A branch of a tree in its own frame.
struct BranchLine {
  std::uint32_t axis = 0;  ///< in the skeleton
  std::vector<SkeletonPoint> points{};
  bool bears = false;  ///< it is the parent of a radius branch and is not moved
};

/// The data of a tree that resolving overlaps needs: some 10 kB, not its whole skeleton.
struct StandTree {
  std::string plot{};
  std::string tree{};
  Position position{};
  std::shared_ptr<const Crown> crown{};
  Lane stem{{}};                       ///< with the stem's own radius
  std::vector<BranchLine> branches{};  ///< those that may be removed
  std::vector<BranchLine>
      radius_branches{};  ///< those that end at a measured radius, and their parents
};

/// \param skeleton  of the same tree, grown in the crown
StandTree stand_tree(const Morphology& morphology, const Crown& crown, const Skeleton& skeleton);

/// Two trees whose crowns overlap. The first is the weaker one.
struct PairOverlap {
  std::size_t weaker = 0;  ///< index of the tree
  std::size_t stronger = 0;
  double distance_m = 0.0;
  double facing_radii_m = 0.0;  ///< lc, the sum of both
  Competition competition{};    ///< of the weaker against the stronger
  std::optional<CrownMeeting> meeting{};
  /// Branches of the weaker in the stronger's crown that are removed, alternately in the proportion
  /// Ct with those of the stronger in the weaker's.
  std::size_t removed_weaker = 0;
  std::size_t removed_stronger = 0;
  double log_share = 0.0;  ///< ln l: the meeting surface is where s_weaker = l s_stronger
};

/// The result for one tree.
struct TreeOverlap {
  std::vector<std::uint32_t> removed{};  ///< axes of removed branches, increasing
  std::vector<BranchLine> turned{};      ///< radius branches with a new course
  std::vector<std::uint32_t> lanes{};    ///< axes of all radius branches
  std::size_t crossing = 0;              ///< radius branches without a free course
  Territory territory{};
};

struct StandOverlap {
  std::vector<PairOverlap> pairs{};  ///< by plot and tree of the weaker, then of the stronger
  std::vector<TreeOverlap> trees{};  ///< in the order of the trees given
};

/// Resolves the overlaps of all neighbors.
///
/// For each pair whose facing radii add up to more than its distance, the branches that enter the
/// neighbor's crown are removed alternately, those that reach farthest first, one of the weaker
/// tree per Ct of the stronger, until a meeting surface (see Territory) separates the rest. Radius
/// branches are kept: the stronger tree's is not changed, the weaker tree's is turned in azimuth
/// and angle within the tolerance of its measured radius, until it clears the stronger tree's
/// radius branches and all stems. Other branches keep a lane around them and around stems free.
///
/// Each pair is resolved separately, starting from the whole trees, in any order and by any thread.
/// \param threads  0: one for each core
/// \throws UsageError if two trees have the same plot and label; GeometryError with the tree if
///   more crowns meet in one place than can be resolved in a reasonable time
StandOverlap resolve_overlaps(std::span<const StandTree> trees, unsigned threads = 0);

/// Checks that resolve_overlaps() can resolve the overlaps of these trees.
/// \param threads  0: one for each core
/// \throws GeometryError with the tree if more crowns meet in one place than can be resolved in a
///   reasonable time
void check_crown_density(std::span<const Morphology> trees, unsigned threads = 0);

/// A skeleton after its overlaps are resolved.
struct PrunedSkeleton {
  Skeleton skeleton{};
  double length_before_m = 0.0;  ///< of branches and twigs
  double length_after_m = 0.0;

  double removed_share() const {
    return length_before_m > 0.0 ? 1.0 - length_after_m / length_before_m : 0.0;
  }
};

/// Removes branches, gives turned ones their new course, and cuts limbs and twigs back to the
/// tree's territory. If nothing would be left at the crown base, one branch is cut back there
/// instead of removed, so that the crown base stays as measured. Leaves go with their axis.
PrunedSkeleton prune(const Skeleton& skeleton, const Crown& crown, const TreeOverlap& overlap);

/// Moves foliage that crosses the meeting surface towards the point where it grows; foliage that
/// still does not fit is removed.
void keep_within(const Territory& territory, Mesh& mesh);

}  // namespace silvafit::tree
