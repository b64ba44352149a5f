// SPDX-License-Identifier: MIT
// Trees at their positions, and a function from a morphology to a tree.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/impostor.hpp"
#include "silvafit/tree/mesh.hpp"
#include "silvafit/tree/morphology.hpp"
#include "silvafit/tree/overlap.hpp"

namespace silvafit::tree {

/// A finished tree.
struct SceneTree {
  std::string plot{};
  std::string tree{};
  std::string species{};
  std::string preset{};
  Position position{};
  Mesh mesh{};
  Measurements measured{};
  std::vector<Note> notes{};
  /// Relative length of branches and twigs removed because of neighbors; only if overlaps were
  /// resolved.
  std::optional<double> removed_share{};

  /// "plot-tree", the name of its node and mesh.
  std::string name() const { return plot + "-" + tree; }
};

struct GrowOptions {
  std::uint64_t seed = 1;
  MeshOptions mesh{};
  /// Draws the tree as its grammar or function system is, scaled to the height only; the other
  /// measurements are ignored.
  bool is_unfitted = false;
  /// If given, it builds the tree for the far distance; of the mesh options only the stem's
  /// tolerance is used. Impostors show whole and fitted crowns: neither overlaps nor `is_unfitted`
  /// can be combined with them.
  Impostors* impostors = nullptr;
};

/// Morphology -> shape -> skeleton -> mesh -> measurements. The same input and seed give the same
/// tree.
/// \param overlap  the result of resolve_overlaps() for this tree, or null for a single tree
/// \throws DomainError, GeometryError with plot and tree; UsageError for options that cannot be
///   combined
SceneTree grow_tree(const Morphology& morphology,
                    const Builder& builder,
                    const GrowOptions& options = {},
                    const TreeOverlap* overlap = nullptr);
/// The data that resolve_overlaps() needs of the tree that grow_tree() grows from the same input.
/// \throws as grow_tree()
StandTree grow_for_stand(const Morphology& morphology,
                         const Builder& builder,
                         const GrowOptions& options = {});

/// An origin near the trees if coordinates are so large that single precision, which viewers use,
/// would move trees by more than a millimeter; else the origin of the inventory.
Position scene_origin(const std::vector<Morphology>& morphologies);

/// Bytes of a mesh in a GLB file, without its part of the description.
std::size_t glb_mesh_bytes(const Mesh& mesh);

}  // namespace silvafit::tree
