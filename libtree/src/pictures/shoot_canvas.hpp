// SPDX-License-Identifier: MIT
// Draws leaves and twigs on a square picture, from back to front.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "silvafit/tree/texture_library.hpp"

namespace silvafit::tree {

/// A point of a picture: x to the right, y up, both from 0 to 1.
struct Spot {
  double x = 0.0;
  double y = 0.0;
};

inline Spot operator+(Spot a, Spot b) { return {a.x + b.x, a.y + b.y}; }
inline Spot operator-(Spot a, Spot b) { return {a.x - b.x, a.y - b.y}; }
inline Spot operator*(double s, Spot a) { return {s * a.x, s * a.y}; }
/// The direction at an angle from upward, to the right.
Spot towards(double angle_rad);

struct PictureLeaf {
  Spot base{};
  double angle_rad = 0.0;  ///< from upward, to the right
  double length = 0.2;     ///< relative to the picture
  double width = 0.07;
  double bend = 0.0;   ///< sideways deviation of the tip, relative to the length
  double shade = 1.0;  ///< brightness
  double warmth = 0.0;
  double tilt_x = 0.0;  ///< inclination of its surface, for the normal map
  double tilt_y = 0.0;
};

/// A picture under construction.
class ShootCanvas {
 public:
  /// \param size  width and height in pixels
  explicit ShootCanvas(std::size_t size);

  /// \param shadow  darkening of what is behind it, close to its edge
  void leaf(const PictureLeaf& leaf, const Blade& blade, double shadow = 0.3);
  /// A round twig from one point to another.
  void twig(Spot from, Spot to, double base_width, double tip_width, const Tint& tint);

  std::size_t size() const { return size_; }
  /// Copies the picture into a quarter, or other part, of two textures.
  /// \param scale  brightness, so that several pictures have a common mean
  void copy_to(Texture& color, Texture& normals, std::size_t x, std::size_t y, double scale) const;

  /// Sums over the covered pixels: their brightness, and their area in pixels.
  double brightness() const;
  double covered() const;
  /// Area of all leaves [pixels], also where others are in front of them.
  double leaf_area() const { return leaf_area_; }

 private:
  struct Pixel {
    std::array<float, 3> color{};
    std::array<float, 2> tilt{};
    float cover = 0.0F;
  };

  /// Puts a surface over a pixel.
  static void cover(Pixel& pixel, double share, const Tint& color, double tilt_x, double tilt_y);
  Tint mean_color() const;

  std::size_t size_;
  std::vector<Pixel> pixels_;
  double leaf_area_ = 0.0;
};

/// Linear light as sRGB (IEC 61966-2-1), limited to [0, 1].
std::uint8_t exact_srgb_byte(double linear);
/// The same by a table, for pictures of millions of values; at most one byte apart.
std::uint8_t srgb_byte(double linear);
/// The reverse.
double linear_light(std::uint8_t srgb);

}  // namespace silvafit::tree
