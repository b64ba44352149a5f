// SPDX-License-Identifier: MIT
// Pictures of meshes from infinitely far away.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

/// The window of a picture in the tree's frame (z up). The three directions are orthonormal and
/// `right` x `up` = `towards`, which points to the viewer.
struct PictureWindow {
  Point right{};
  Point up{};
  Point towards{};
  double left_m = 0.0;  ///< along `right`
  double low_m = 0.0;   ///< along `up`
  double width_m = 1.0;
  double height_m = 1.0;
};

/// Colors of the nearest surfaces in soft light, by a depth buffer.
class OrthographicPicture {
 public:
  struct Pixel {
    std::array<float, 3> color{};  ///< linear
    float nearness = -std::numeric_limits<float>::infinity();

    bool is_covered() const { return nearness > -std::numeric_limits<float>::infinity(); }
  };

  /// \param side  width and height in pixels
  OrthographicPicture(const PictureWindow& window, std::size_t side);

  /// Draws both sides of a part's triangles. Pixels of textures with less than half opacity are not
  /// drawn.
  void draw(const MeshPart& part);

  /// \param row  from the upper edge
  const Pixel& at(std::size_t column, std::size_t row) const {
    return pixels_[row * side_ + column];
  }

 private:
  struct Corner;
  Corner corner(const MeshPart& part, std::uint32_t vertex) const;
  void draw(const MeshPart& part, const std::array<Corner, 3>& corners);

  PictureWindow window_;
  std::size_t side_;
  std::vector<Pixel> pixels_;
};

}  // namespace silvafit::tree
