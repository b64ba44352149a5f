// SPDX-License-Identifier: MIT
// The same trees measured several times.
#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "silvafit/tree/morphology_table.hpp"
#include "silvafit/tree/scene_writer.hpp"

namespace silvafit::tree {

/// The trees of one time, such as a year.
struct Moment {
  std::string name{};
  double time = 0.0;  ///< the column's number, or its place in the order, from 0
  std::vector<Morphology> trees{};
};

struct Moments {
  std::vector<Moment> moments{};  ///< in the order of time
  std::vector<LeftOut> left_out{};
};

/// Splits a table by a column: numbers in increasing order, text in the order of first occurrence.
/// A tree may occur once at each time.
/// \throws InputError if there is no such column, or as read_morphologies()
Moments read_moments(const data::Table& table,
                     const std::string& by,
                     const MorphologyTableOptions& options);

/// A time at which a tree has changed: it has this form until its next stage.
struct Stage {
  std::size_t moment = 0;
  Morphology tree{};
};

/// A tree through time.
struct GrowingTree {
  std::vector<Stage> stages{};  ///< at least one, in the order of time
  std::size_t gone = 0;  ///< the moment from which it is permanently missing, or their number
};

/// All trees by plot and tree, in the order of first occurrence. A tree without a row at an
/// intermediate time was not measured and does not change then. Times without a change are not
/// stages.
std::vector<GrowingTree> growing_trees(std::span<const Moment> moments);

/// The times of the moments in an animation.
struct Pace {
  double seconds_per_unit = 1.0;  ///< of the moments' times; > 0
  /// Time before its first moment during which a new tree grows up, in units; at most the time
  /// since the previous moment, which is the default.
  double growing_up = std::numeric_limits<double>::infinity();
};

/// Keyframes of a tree's stages: each is visible from its moment to the next stage's, while its
/// height and widths grow linearly to those of the next; a new tree grows up before its first
/// moment. One more unit follows the last moment.
/// \param models  of the stages, in their order
/// \throws UsageError if the pace is not above 0, or if single precision, which files use for
/// times, could not distinguish the keyframes' times or represent them
std::vector<AnimatedModel> animated(const GrowingTree& tree,
                                    std::span<const Moment> moments,
                                    std::span<const SceneWriter::Model> models,
                                    const Pace& pace);

}  // namespace silvafit::tree
