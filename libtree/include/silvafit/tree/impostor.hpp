// SPDX-License-Identifier: MIT
// Trees seen from far away: pictures of the crown on crossed cards.
#pragma once

#include <memory>

#include "silvafit/base/random.hpp"
#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/mesh.hpp"
#include "silvafit/tree/morphology.hpp"

namespace silvafit::tree {

/// The level of detail of impostors, which follows those of meshes.
inline constexpr int kImpostorLevel = kLevelsOfDetail;

/// Draws crowns and places their pictures on trees.
///
/// An impostor is a tube for the stem below the crown, and five crossed cards for the crown: four
/// upright ones through the stem's axis and a level one at the widest height. Each card is two
/// surfaces, so that both sides have normals away from the crown. The pictures show a typical tree
/// of the preset with a crown of similar size and proportions; all trees of this class share them.
/// The cards stretch them to each tree: the crown curve of the picture becomes that of the tree.
class Impostors {
 public:
  Impostors();
  ~Impostors();
  Impostors(const Impostors&) = delete;
  Impostors& operator=(const Impostors&) = delete;

  /// Height, crown base, DBH and the four radii of the mesh are those of the shape. Several threads
  /// may call this.
  /// \param builder  must live as long as this object
  /// \param random   chooses which sides of the typical tree are shown
  /// \param options  of which the stem's tolerance and the season are used
  /// \throws as Builder::build_mesh()
  Mesh build(const Builder& builder,
             const TreeShape& shape,
             Random& random,
             const MeshOptions& options);

 private:
  class Pictures;
  std::unique_ptr<Pictures> pictures_;
};

}  // namespace silvafit::tree
