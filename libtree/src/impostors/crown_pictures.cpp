// SPDX-License-Identifier: MIT
#include "impostors/crown_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "impostors/crown_coverage.hpp"
#include "impostors/orthographic_picture.hpp"
#include "pictures/shoot_canvas.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::tree {
namespace {

// Factors between neighboring classes. The share of gaps in a crown depends on its slenderness and,
// for wide crowns, on its width.
constexpr double kWidthStep = 1.35;
constexpr double kSlendernessStep = 1.3;
constexpr std::size_t kPixelsPerStep = 2;
static_assert(kCrownSide == kCrownSteps * kPixelsPerStep);
constexpr std::size_t kBorder = kBorderSteps * kPixelsPerStep;
constexpr std::size_t kAtlasSide = kAtlasSteps * kPixelsPerStep;
// Samples of a pixel in each direction.
constexpr std::size_t kSamples = 3;

/// A crown's picture: the covered share of each pixel, and the mean color there.
struct View {
  PixelValues covered = PixelValues(kCrownSide * kCrownSide);
  std::vector<Tint> colors = std::vector<Tint>(kCrownSide * kCrownSide);
};

View view_of(const Mesh& mesh, const PictureWindow& window) {
  OrthographicPicture picture(window, kCrownSide * kSamples);
  for (const MeshPart& part : mesh.parts) {
    // Aerial roots are below the crown.
    if (part.kind != PartKind::kAerialRoots) picture.draw(part);
  }
  View view;
  for (std::size_t i = 0; i < view.covered.size(); ++i) {
    Tint sum{};
    int covered = 0;
    for (std::size_t k = 0; k < kSamples * kSamples; ++k) {
      const auto& sample = picture.at(i % kCrownSide * kSamples + k % kSamples,
                                      i / kCrownSide * kSamples + k / kSamples);
      if (!sample.is_covered()) continue;
      ++covered;
      for (std::size_t c = 0; c < 3; ++c) sum[c] += double{sample.color[c]};
    }
    view.covered[i] = static_cast<double>(covered) / (kSamples * kSamples);
    for (std::size_t c = 0; c < 3; ++c) view.colors[i][c] = sum[c] / std::max(covered, 1);
  }
  return view;
}

/// One of several pixels in each direction. A picture of the whole crown skips more of them, and a
/// small texture stays in the processor's cache: drawing takes a third of the time.
std::shared_ptr<const Texture> thinned(const Texture& texture) {
  constexpr std::size_t kSide = 256;
  const std::size_t step =
      std::max<std::size_t>(1, std::min(texture.width, texture.height) / kSide);
  Texture result{.width = texture.width / step, .height = texture.height / step};
  result.rgba.reserve(4 * result.width * result.height);
  for (std::size_t y = 0; y < result.height; ++y) {
    for (std::size_t x = 0; x < result.width; ++x) {
      const std::uint8_t* from = texture.rgba.data() + 4 * step * (y * texture.width + x);
      result.rgba.insert(result.rgba.end(), from, from + 4);
    }
  }
  return std::make_shared<const Texture>(std::move(result));
}

PictureWindow window_from_side(double azimuth_rad, const TreeShape& shape) {
  const double radius = shape.radii.east_m;
  const Point right{std::cos(azimuth_rad), std::sin(azimuth_rad), 0.0};
  return {.right = right,
          .up = {0.0, 0.0, 1.0},
          .towards = {right.y, -right.x, 0.0},
          .left_m = -radius,
          .low_m = shape.hcb_m,
          .width_m = 2.0 * radius,
          .height_m = shape.h_m - shape.hcb_m};
}

PictureWindow window_from_above(const TreeShape& shape) {
  const double radius = shape.radii.east_m;
  return {.right = {1.0, 0.0, 0.0},
          .up = {0.0, 1.0, 0.0},
          .towards = {0.0, 0.0, 1.0},
          .left_m = -radius,
          .low_m = -radius,
          .width_m = 2.0 * radius,
          .height_m = 2.0 * radius};
}

using Views = std::array<View, kCrownViews>;

const View& of(const Views& views, CrownView view) { return views[static_cast<std::size_t>(view)]; }

/// Around the crown the picture has its mean color, so that interpolation gives no other one.
Tint mean_color(const View& view) {
  Tint sum{};
  double area = 1e-9;
  for (std::size_t i = 0; i < view.covered.size(); ++i) {
    area += view.covered[i];
    for (std::size_t k = 0; k < 3; ++k) sum[k] += view.covered[i] * view.colors[i][k];
  }
  for (double& channel : sum) channel /= area;
  return sum;
}

void copy_to(Texture& atlas, CrownView which, const View& view, const PixelValues& opacities) {
  const auto cell = static_cast<std::size_t>(which);
  constexpr std::size_t kCellSide = kAtlasSide / 2;
  const Tint around = mean_color(view);
  for (std::size_t i = 0; i < kCellSide * kCellSide; ++i) {
    const std::size_t column = i % kCellSide;
    const std::size_t row = i / kCellSide;
    const bool is_border = column < kBorder || row < kBorder || column >= kBorder + kCrownSide ||
                           row >= kBorder + kCrownSide;
    const std::size_t pixel = is_border ? 0 : (row - kBorder) * kCrownSide + column - kBorder;
    const bool is_empty = is_border || view.covered[pixel] <= 0.0;
    const Tint& color = is_empty ? around : view.colors[pixel];
    std::uint8_t* to = atlas.rgba.data() + 4 * ((cell / 2 * kCellSide + row) * kAtlasSide +
                                                cell % 2 * kCellSide + column);
    for (std::size_t k = 0; k < 3; ++k) to[k] = srgb_byte(color[k]);
    to[3] = is_empty ? 0 : static_cast<std::uint8_t>(std::lround(255.0 * opacities[pixel]));
  }
}

/// The material's color times the mean of its texture.
Color mean_bark(const Mesh& mesh) {
  const MeshPart& stem = mesh.parts.front();
  Color color = stem.color;
  if (stem.texture == nullptr) return color;
  const std::vector<std::uint8_t>& rgba = stem.texture->rgba;
  for (std::size_t k = 0; k < color.size(); ++k) {
    double sum = 0.0;
    for (std::size_t i = k; i < rgba.size(); i += 4) sum += linear_light(rgba[i]);
    color[k] *= 4.0 * sum / static_cast<double>(rgba.size());
  }
  return color;
}

int class_number(double value, double step, int least, int most) {
  const long number = std::lround(std::log(value) / std::log(step));
  return static_cast<int>(std::clamp<long>(number, least, most));
}

}  // namespace

CrownClass class_of(const TreeShape& shape) {
  const double length = shape.h_m - shape.hcb_m;
  const double width = shape.radii.width_m();
  // From crowns of 40 cm to those of 36 m, and four times as wide as long to the reverse.
  return {class_number(width, kWidthStep, -3, 12),
          class_number(length / width, kSlendernessStep, -5, 5)};
}

Morphology typical_tree(CrownClass crown, const PresetHead& preset) {
  const double width = std::pow(kWidthStep, crown.width);
  const double length = width * std::pow(kSlendernessStep, crown.slenderness);
  // A crown of 60 % of the height, on a stem of 1.2 cm a meter.
  const double h = std::max(length / 0.6, length + 1.35);
  const double hc =
      std::clamp(std::round(kCrownSteps * preset.relative_hc), 1.0, kCrownSteps - 1.0);
  return {.plot = "crown",
          .tree = fmt::format("{}-{}", crown.width, crown.slenderness),
          .dbh_cm = 1.2 * h,
          .h_m = h,
          .hcb_m = h - length,
          .hc_m = h - length + hc / kCrownSteps * length,
          .cw_m = width};
}

double roof_rise_m(const TreeShape& shape) {
  constexpr double kSlope = 0.15;
  return std::min(kSlope * 0.5 * shape.radii.width_m(), shape.h_m - shape.hc_m);
}

CrownPictures draw_crown(const Builder& builder, CrownClass crown, Season season) {
  const Morphology tree = typical_tree(crown, builder.preset());
  const TreeShape shape = builder.shape_of(tree);
  const Crown curve(shape, builder.preset().crown_index);
  const MeshOptions options{.textured = true, .season = season};
  Random random = random_of_tree(1, tree.plot, tree.tree);
  const Skeleton skeleton = builder.grow_skeleton(shape, curve, random, options);
  Mesh mesh = builder.build_mesh(skeleton, curve, random, options);
  for (MeshPart& part : mesh.parts) {
    if (part.texture != nullptr) part.texture = thinned(*part.texture);
  }

  constexpr double kQuarter = 0.5 * std::numbers::pi;
  const Views views{view_of(mesh, window_from_side(0.0, shape)),
                    view_of(mesh, window_from_side(kQuarter, shape)),
                    view_of(mesh, window_from_side(0.5 * kQuarter, shape)),
                    view_of(mesh, window_from_above(shape))};
  const std::string name = fmt::format("{}-{}", tree.plot, tree.tree);
  Texture atlas{.name = fmt::format("{}-{}", builder.name(), name),
                .width = kAtlasSide,
                .height = kAtlasSide,
                .rgba = std::vector<std::uint8_t>(4 * kAtlasSide * kAtlasSide),
                .pictures = kAtlasSteps};
  const double length = shape.h_m - shape.hcb_m;
  const View& above = of(views, CrownView::kAbove);
  const PixelValues roof = opacities_from_above(above.covered);
  copy_to(atlas, CrownView::kAbove, above, roof);
  constexpr std::array kSides{CrownView::kSouth, CrownView::kSoutheast, CrownView::kEast};
  const auto opacities = opacities_from_sides(
      {of(views, kSides[0]).covered, of(views, kSides[1]).covered, of(views, kSides[2]).covered},
      {.opacities = roof,
       .base = (shape.hc_m - shape.hcb_m) / length,
       .rise = roof_rise_m(shape) / length});
  for (std::size_t i = 0; i < kSides.size(); ++i) {
    copy_to(atlas, kSides[i], of(views, kSides[i]), opacities[i]);
  }
  return {.name = name,
          .texture = std::make_shared<const Texture>(std::move(atlas)),
          .relative_hc = (shape.hc_m - shape.hcb_m) / (shape.h_m - shape.hcb_m),
          .bark = mean_bark(mesh)};
}

}  // namespace silvafit::tree
