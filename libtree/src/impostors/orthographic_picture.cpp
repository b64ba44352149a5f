// SPDX-License-Identifier: MIT
#include "impostors/orthographic_picture.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pictures/shoot_canvas.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::tree {

/// A vertex in pixels from the upper left corner.
struct OrthographicPicture::Corner {
  double x = 0.0;
  double y = 0.0;
  double nearness = 0.0;
  std::array<double, 3> color{};
  std::array<double, 2> uv{};
};

namespace {

constexpr double kWholeByte = 255.0;
constexpr std::uint8_t kHalfOpaque = 128;

/// The nearest pixel of a texture that repeats, or null if it is transparent.
const std::uint8_t* visible_texel(const Texture& texture, double u, double v) {
  const auto along = [](double at, std::size_t size) {
    const auto texel = static_cast<std::size_t>((at - std::floor(at)) * static_cast<double>(size));
    return std::min(texel, size - 1);
  };
  const std::uint8_t* texel = texture.rgba.data() + 4 * (along(v, texture.height) * texture.width +
                                                         along(u, texture.width));
  return texel[3] < kHalfOpaque ? nullptr : texel;
}

/// Brightness of a surface: much light from everywhere, and some from above the viewer, so that
/// shoots of different inclinations can be told apart.
double brightness(Point normal, bool is_double_sided, const PictureWindow& window) {
  constexpr double kFromAll = 0.25;
  const bool is_turned = is_double_sided && dot(normal, window.towards) < 0.0;
  const Point light = direction(window.towards + Point{0.0, 0.0, 1.0});
  const double facing = (is_turned ? -1.0 : 1.0) * dot(normal, light);
  return kFromAll + (1.0 - kFromAll) * std::max(facing, 0.0);
}

/// The first pixel, and that behind the last one, whose middle is between two places.
std::size_t first_pixel(double from, std::size_t side) {
  return static_cast<std::size_t>(
      std::clamp(std::ceil(from - 0.5), 0.0, static_cast<double>(side)));
}
std::size_t end_pixel(double to, std::size_t side) {
  return static_cast<std::size_t>(std::clamp(std::floor(to + 0.5), 0.0, static_cast<double>(side)));
}

/// A value that changes linearly over the picture.
struct Linear {
  double origin = 0.0;
  double per_x = 0.0;
  double per_y = 0.0;

  double at(double x, double y) const { return origin + per_x * x + per_y * y; }
};

/// The three weights of the corners, each linear.
class TriangleOnPicture {
 public:
  template <typename Corners>
  explicit TriangleOnPicture(const Corners& corners) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& from = corners[(k + 1) % 3];
      const auto& to = corners[(k + 2) % 3];
      weights_[k] = {from.x * to.y - to.x * from.y, from.y - to.y, to.x - from.x};
    }
    area_ = weights_[0].origin + weights_[1].origin + weights_[2].origin;
    if (!has_area()) return;
    for (Linear& weight : weights_) {
      weight = {weight.origin / area_, weight.per_x / area_, weight.per_y / area_};
    }
  }

  bool has_area() const { return std::abs(area_) > 1e-9; }

  Linear interpolated(double a, double b, double c) const {
    const auto sum = [&](double Linear::*term) {
      return a * weights_[0].*term + b * weights_[1].*term + c * weights_[2].*term;
    };
    return {sum(&Linear::origin), sum(&Linear::per_x), sum(&Linear::per_y)};
  }

  /// Where no weight is negative in a row; the second value is less than the first if nowhere.
  std::array<double, 2> span(double y) const {
    std::array<double, 2> ends{-kInfinity, kInfinity};
    for (const Linear& weight : weights_) {
      const double at_zero = weight.at(0.0, y);
      if (weight.per_x > 0.0) {
        ends[0] = std::max(ends[0], -at_zero / weight.per_x);
      } else if (weight.per_x < 0.0) {
        ends[1] = std::min(ends[1], -at_zero / weight.per_x);
      } else if (at_zero < 0.0) {
        return {1.0, 0.0};
      }
    }
    return ends;
  }

 private:
  std::array<Linear, 3> weights_{};
  double area_ = 0.0;
};

}  // namespace

OrthographicPicture::OrthographicPicture(const PictureWindow& window, std::size_t side)
    : window_(window), side_(side), pixels_(side * side) {}

OrthographicPicture::Corner OrthographicPicture::corner(const MeshPart& part,
                                                        std::uint32_t vertex) const {
  const float* at = part.positions.data() + std::size_t{3} * vertex;
  const Point point{at[0], -double{at[2]}, at[1]};
  const float* normal = part.normals.data() + std::size_t{3} * vertex;
  const double light =
      brightness({normal[0], -double{normal[2]}, normal[1]}, part.double_sided, window_);
  const auto side = static_cast<double>(side_);
  Corner corner{.x = side * (dot(point, window_.right) - window_.left_m) / window_.width_m,
                .y = side * (1.0 - (dot(point, window_.up) - window_.low_m) / window_.height_m),
                .nearness = dot(point, window_.towards),
                .color = {light * part.color[0], light * part.color[1], light * part.color[2]}};
  if (!part.colors.empty()) {
    const std::uint8_t* color = part.colors.data() + std::size_t{4} * vertex;
    for (std::size_t k = 0; k < 3; ++k) corner.color[k] *= color[k] / kWholeByte;
  }
  if (!part.uvs.empty()) {
    const float* uv = part.uvs.data() + std::size_t{2} * vertex;
    corner.uv = {uv[0], uv[1]};
  }
  return corner;
}

void OrthographicPicture::draw(const MeshPart& part) {
  std::vector<Corner> corners;
  corners.reserve(part.vertex_count());
  for (std::uint32_t i = 0; i < part.vertex_count(); ++i) corners.push_back(corner(part, i));
  // The nearest first, so that the textures of hidden surfaces are not read.
  std::vector<std::pair<double, std::uint32_t>> order;
  order.reserve(part.triangle_count());
  for (std::uint32_t i = 0; i < part.indices.size(); i += 3) {
    order.emplace_back(-corners[part.indices[i]].nearness, i);
  }
  std::ranges::sort(order);
  for (const auto& [depth, first] : order) {
    draw(part,
         {corners[part.indices[first]],
          corners[part.indices[first + 1]],
          corners[part.indices[first + 2]]});
  }
}

void OrthographicPicture::draw(const MeshPart& part, const std::array<Corner, 3>& corners) {
  const TriangleOnPicture triangle(corners);
  // Triangles seen from their edge.
  if (!triangle.has_area()) return;
  const auto mean = [&](auto value) {
    return triangle.interpolated(value(corners[0]), value(corners[1]), value(corners[2]));
  };
  const Linear nearness = mean([](const Corner& corner) { return corner.nearness; });
  const Linear u = mean([](const Corner& corner) { return corner.uv[0]; });
  const Linear v = mean([](const Corner& corner) { return corner.uv[1]; });
  std::array<Linear, 3> color{};
  for (std::size_t k = 0; k < 3; ++k) {
    color[k] = mean([k](const Corner& corner) { return corner.color[k]; });
  }
  const Texture* texture = part.uvs.empty() ? nullptr : part.texture.get();
  const auto [top, bottom] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
  for (std::size_t row = first_pixel(top, side_); row < end_pixel(bottom, side_); ++row) {
    const double y = static_cast<double>(row) + 0.5;
    const auto [left, right] = triangle.span(y);
    for (std::size_t column = first_pixel(left, side_); column < end_pixel(right, side_);
         ++column) {
      const double x = static_cast<double>(column) + 0.5;
      Pixel& pixel = pixels_[row * side_ + column];
      const auto near = static_cast<float>(nearness.at(x, y));
      if (near <= pixel.nearness) continue;
      const std::uint8_t* texel = nullptr;
      if (texture != nullptr) {
        texel = visible_texel(*texture, u.at(x, y), v.at(x, y));
        if (texel == nullptr) continue;
      }
      pixel.nearness = near;
      for (std::size_t k = 0; k < 3; ++k) {
        const double tint = texel == nullptr ? 1.0 : linear_light(texel[k]);
        pixel.color[k] = static_cast<float>(tint * color[k].at(x, y));
      }
    }
  }
}

}  // namespace silvafit::tree
