// SPDX-License-Identifier: MIT
// Builder of the vertices and triangles of a part of a mesh.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "mesh/bark_surface.hpp"

namespace silvafit::tree {

using Bytes4 = std::array<std::uint8_t, 4>;

/// Linear 0 .. 1 as a byte.
inline std::uint8_t to_byte(double value) {
  return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(value, 0.0, 1.0)));
}

/// Optional data of a vertex besides position and normal.
struct Texturing {
  double u = 0.0;
  double v = 0.0;
  Point tangent{};  ///< direction of increasing u
  float sign = 1.0F;
};

/// Transforms the tree's frame (z up) into the mesh's (y up) while it fills a part. Buffers are
/// resized by whole blocks and cut to size by finish(), because a vertex takes fewer instructions
/// than a call of push_back.
class PartBuilder {
 public:
  /// \param paint  of bark with a texture
  explicit PartBuilder(MeshPart& part, const BarkPaint* paint = nullptr)
      : part_(part), paint_(paint) {}

  /// The width of the picture of bark for wood of this thickness.
  BarkScale bark_scale(double radius_m) const {
    constexpr double kUnused = 1.0;
    return {radius_m, paint_ != nullptr ? paint_->picture_m() : kUnused};
  }

  /// The vertices that are textured from here on have the color of bark of this thickness.
  void paint(double radius_m) {
    if (paint_ == nullptr || !paint_->is_varied()) return;
    const Color color = paint_->relative(radius_m);
    bark_color_ = Bytes4{to_byte(color[0]), to_byte(color[1]), to_byte(color[2]), 255};
  }

  /// Reserves space; no more than this may be added before the next call.
  void reserve(std::size_t vertices, std::size_t triangles) {
    grow(part_.positions, 3 * (vertices_ + vertices));
    grow(part_.normals, 3 * (vertices_ + vertices));
    grow(part_.indices, indices_ + 3 * triangles);
    reserved_ = vertices_ + vertices;
  }

  /// Cuts the buffers to the added size.
  void finish() {
    part_.positions.resize(3 * vertices_);
    part_.normals.resize(3 * vertices_);
    part_.indices.resize(indices_);
    part_.uvs.resize(2 * textured_);
    part_.tangents.resize(4 * textured_);
    part_.colors.resize(4 * colored_);
  }

  std::uint32_t vertex_count() const { return static_cast<std::uint32_t>(vertices_); }

  std::uint32_t vertex(Point at, Point normal) {
    write(part_.positions.data() + 3 * vertices_, at);
    write(part_.normals.data() + 3 * vertices_, normal);
    return static_cast<std::uint32_t>(vertices_++);
  }

  void texture(const Texturing& texturing) {
    if (part_.uvs.size() < 2 * (textured_ + 1)) {
      const std::size_t vertices = std::max(textured_ + 1, reserved_);
      grow(part_.uvs, 2 * vertices);
      grow(part_.tangents, 4 * vertices);
    }
    float* const uv = part_.uvs.data() + 2 * textured_;
    uv[0] = static_cast<float>(texturing.u);
    uv[1] = static_cast<float>(texturing.v);
    float* const tangent = part_.tangents.data() + 4 * textured_++;
    write(tangent, texturing.tangent);
    tangent[3] = texturing.sign;
    if (bark_color_) color(*bark_color_);
  }

  void color(Bytes4 color) {
    if (part_.colors.size() < 4 * (colored_ + 1)) {
      grow(part_.colors, 4 * std::max(colored_ + 1, reserved_));
    }
    std::copy(color.begin(),
              color.end(),
              part_.colors.begin() + static_cast<std::ptrdiff_t>(4 * colored_++));
  }

  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    std::uint32_t* to = part_.indices.data() + indices_;
    to[0] = a;
    to[1] = b;
    to[2] = c;
    indices_ += 3;
  }

  /// Joins two rings of a tube, each with its vertices one after the other; with a seam, the last
  /// ones are at the position of the first ones.
  void join(std::uint32_t lower, std::uint32_t upper, std::uint32_t sides, bool seam) {
    for (std::uint32_t i = 0; i < sides; ++i) {
      const std::uint32_t j = !seam && i + 1 == sides ? 0 : i + 1;
      triangle(lower + i, lower + j, upper + j);
      triangle(lower + i, upper + j, upper + i);
    }
  }

  /// Joins the last ring of a tube with its end.
  void join_to_tip(std::uint32_t ring, std::uint32_t tip, std::uint32_t sides, bool seam) {
    for (std::uint32_t i = 0; i < sides; ++i) {
      triangle(ring + i, ring + (!seam && i + 1 == sides ? 0 : i + 1), tip);
    }
  }

  /// Closes the first ring of a tube.
  void close(std::uint32_t ring, std::uint32_t sides) {
    for (std::uint32_t i = 1; i + 1 < sides; ++i) triangle(ring, ring + i + 1, ring + i);
  }

 private:
  template <typename T>
  static void grow(std::vector<T>& buffer, std::size_t size) {
    if (size <= buffer.size()) return;
    if (size > buffer.capacity()) buffer.reserve(std::max(size, 2 * buffer.capacity()));
    buffer.resize(size);
  }

  static void write(float* to, Point p) {
    // Adding zero turns -0 into 0, so that equal positions have equal bytes.
    to[0] = static_cast<float>(p.x) + 0.0F;
    to[1] = static_cast<float>(p.z) + 0.0F;
    to[2] = static_cast<float>(-p.y) + 0.0F;
  }

  MeshPart& part_;
  const BarkPaint* paint_;
  std::optional<Bytes4> bark_color_{};
  std::size_t vertices_ = 0;
  std::size_t indices_ = 0;
  std::size_t textured_ = 0;  ///< vertices with texture coordinates
  std::size_t colored_ = 0;   ///< vertices with colors
  std::size_t reserved_ = 0;  ///< vertices
};

}  // namespace silvafit::tree
