// SPDX-License-Identifier: MIT
#include "impostors/crown_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "impostors/orthographic_picture.hpp"
#include "pictures/shoot_canvas.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/tree/point.hpp"

namespace silvafit::tree {
namespace {

/// Width and height of a crown's picture in pixels.
constexpr std::size_t kCrownSide = 120;

/// A value in [0, 1] of each pixel, row by row from the upper left.
using PixelValues = std::vector<double>;

/// The picture from above on its pyramid.
struct CrownRoof {
  const PixelValues& opacities;
  double base = 0.0;  ///< height of the edge in the crown, from the crown base (0) to the top (1)
  double rise = 0.0;  ///< of its middle above the edge
};

constexpr double kMiddle = 0.5 * kCrownSide;
constexpr double kOpaque = 0.5;

double mean(const PixelValues& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Interpolated between the middles of pixels, as viewers do; 0 outside.
/// \param x, y  in pixels from the upper left corner
double interpolated(const PixelValues& values, double x, double y) {
  const auto pixel = [&values](double column, double row) {
    constexpr double kLast = kCrownSide - 1;
    if (column < 0.0 || row < 0.0 || column > kLast || row > kLast) return 0.0;
    return values[static_cast<std::size_t>(row) * kCrownSide + static_cast<std::size_t>(column)];
  };
  const double left = std::floor(x - 0.5);
  const double top = std::floor(y - 0.5);
  const double s = x - 0.5 - left;
  const double t = y - 0.5 - top;
  return (1.0 - t) * ((1.0 - s) * pixel(left, top) + s * pixel(left + 1.0, top)) +
         t * ((1.0 - s) * pixel(left, top + 1.0) + s * pixel(left + 1.0, top + 1.0));
}

/// Lines of pixels from an edge of the picture inwards get an opaque pixel each, if they show a
/// part of the crown, until one has an opaque pixel anyway: thin tips must not shorten the crown.
/// \param first  pixel of the line at the edge
/// \param along, inwards  distances of the next pixel of a line, and of the next line
void keep_tips(PixelValues& opacities,
               std::ptrdiff_t first,
               std::ptrdiff_t along,
               std::ptrdiff_t inwards) {
  const auto side = static_cast<std::ptrdiff_t>(kCrownSide);
  for (std::ptrdiff_t line = 0; line < side; ++line) {
    const auto pixel = [&](std::ptrdiff_t i) -> double& {
      return opacities[static_cast<std::size_t>(first + line * inwards + i * along)];
    };
    std::ptrdiff_t strongest = 0;
    for (std::ptrdiff_t i = 1; i < side; ++i) {
      if (pixel(i) > pixel(strongest)) strongest = i;
    }
    if (pixel(strongest) >= 0.5) return;
    if (pixel(strongest) > 0.0) pixel(strongest) = 1.0;
  }
}

/// Opacities of a picture that is opaque where more than the limit of a pixel is covered. Mipmaps
/// average them: if they were proportional to the covered share, crowns would vanish in small
/// mipmaps, and if all opaque pixels were 1, their gaps would.
PixelValues opacities(const PixelValues& covered, double limit) {
  constexpr double kContrast = 0.5;
  PixelValues result(covered.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const double proportional = kOpaque * covered[i] / limit;
    const double above = (covered[i] - limit) / (1.0 - limit);
    const double full = above < 0.0 ? proportional : kOpaque + kOpaque * above;
    result[i] = std::min(1.0, proportional + kContrast * (full - proportional));
  }
  const auto side = static_cast<std::ptrdiff_t>(kCrownSide);
  const std::ptrdiff_t last = side * side - 1;
  keep_tips(result, 0, 1, side);
  keep_tips(result, last, -1, -side);
  keep_tips(result, 0, side, 1);
  keep_tips(result, last, -side, -1);
  return result;
}

/// Covered shares that decrease towards the edges of dense parts as well, so that a limit can make
/// these parts smaller.
PixelValues with_soft_edges(const PixelValues& covered) {
  constexpr double kNeighbors = 0.25;
  constexpr std::size_t kReach = 2;
  PixelValues result(covered.size());
  for (std::size_t i = 0; i < covered.size(); ++i) {
    const std::size_t column = i % kCrownSide;
    const std::size_t row = i / kCrownSide;
    double sum = 0.0;
    for (std::size_t y = row - std::min(row, kReach); y <= std::min(row + kReach, kCrownSide - 1);
         ++y) {
      for (std::size_t x = column - std::min(column, kReach);
           x <= std::min(column + kReach, kCrownSide - 1);
           ++x) {
        sum += covered[y * kCrownSide + x];
      }
    }
    constexpr double kPixels = (2 * kReach + 1) * (2 * kReach + 1);
    result[i] =
        covered[i] > 0.0 ? (1.0 - kNeighbors) * covered[i] + kNeighbors * sum / kPixels : 0.0;
  }
  return result;
}

/// The limit for which a share of a view is hidden.
/// \param hidden  the hidden share for a limit, which decreases
template <typename Hidden>
double limit_for(double share, Hidden hidden) {
  // Pictures without gaps, and nearly empty ones.
  double low = 0.02;
  double high = 0.98;
  constexpr int kHalvings = 7;
  for (int i = 0; i < kHalvings; ++i) {
    const double limit = 0.5 * (low + high);
    (hidden(limit) > share ? low : high) = limit;
  }
  return 0.5 * (low + high);
}

/// Places that are no middles of pixels.
std::array<double, 2> sample_place(std::size_t pixel) {
  return {static_cast<double>(pixel % kCrownSide) + 0.25,
          static_cast<double>(pixel / kCrownSide) + 0.75};
}

/// Whether the roof hides a place, seen from a side.
/// \param x, y  in pixels from the middle of the crown base, to the right and up
/// \param right  direction to the right
bool is_behind_roof(const CrownRoof& roof, Point right, double x, double y) {
  const double share = (y / kCrownSide - roof.base) / roof.rise;
  if (!(share >= 0.0 && share < 1.0)) return false;
  // At this height the roof's section is a square; the viewer sees its front.
  const double half = kMiddle * (1.0 - share);
  const Point towards{right.y, -right.x, 0.0};
  double front = kInfinity;
  for (const auto& [place, slope] :
       {std::pair{x * right.x, towards.x}, std::pair{x * right.y, towards.y}}) {
    front = std::min(front, (half - std::copysign(1.0, slope) * place) / std::abs(slope));
  }
  const Point at = x * right + front * towards;
  constexpr double kRounding = 1e-6;
  if (std::max(std::abs(at.x), std::abs(at.y)) > half + kRounding) return false;
  return interpolated(roof.opacities, kMiddle + at.x, kMiddle - at.y) >= kOpaque;
}

/// The four cards and the roof from several sides.
class CrossedCards {
 public:
  explicit CrossedCards(const CrownRoof& roof) {
    for (int d = 0; d < kDirections; ++d) {
      const double azimuth = kBetweenCards * direction_of(d);
      const Point right{std::cos(azimuth), std::sin(azimuth), 0.0};
      for (std::size_t i = 0; i < kCrownSide * kCrownSide; ++i) {
        const auto [x, y] = sample_place(i);
        behind_roof_.push_back(is_behind_roof(roof, right, x - kMiddle, kCrownSide - y));
      }
    }
  }

  /// \param cards  from east over north
  double hidden_share(const std::array<const PixelValues*, 4>& cards) const {
    std::size_t hidden = 0;
    for (int d = 0; d < kDirections; ++d) {
      std::array<double, 4> narrowed{};
      for (std::size_t k = 0; k < cards.size(); ++k) {
        narrowed[k] = std::cos(kBetweenCards * (static_cast<double>(k) - direction_of(d)));
      }
      for (std::size_t i = 0; i < kCrownSide * kCrownSide; ++i) {
        const auto [x, y] = sample_place(i);
        bool is_hidden = behind_roof_[static_cast<std::size_t>(d) * kCrownSide * kCrownSide + i];
        for (std::size_t k = 0; k < cards.size() && !is_hidden; ++k) {
          const double on_card = (x - kMiddle) / narrowed[k];
          is_hidden = std::abs(on_card) < kMiddle &&
                      interpolated(*cards[k], kMiddle + on_card, y) >= kOpaque;
        }
        if (is_hidden) ++hidden;
      }
    }
    return static_cast<double>(hidden) / (kDirections * kCrownSide * kCrownSide);
  }

 private:
  static constexpr int kDirections = 4;
  static constexpr double kBetweenCards = 0.25 * std::numbers::pi;

  /// In the angle between two cards.
  static double direction_of(int number) { return (number + 0.5) / kDirections; }

  std::vector<bool> behind_roof_{};
};

/// The picture is opaque (at least one half, also between pixels) where more than a limit of a
/// pixel is covered. The limit is chosen so that the picture hides the same area as the mesh.
/// \param covered  the share of each pixel that the mesh covers
PixelValues opacities_from_above(const PixelValues& covered) {
  const PixelValues soft = with_soft_edges(covered);
  const auto hidden = [&](double limit) {
    const PixelValues tried = opacities(soft, limit);
    std::size_t opaque = 0;
    for (std::size_t i = 0; i < tried.size(); ++i) {
      const auto [x, y] = sample_place(i);
      if (interpolated(tried, x, y) >= kOpaque) ++opaque;
    }
    return static_cast<double>(opaque) / static_cast<double>(tried.size());
  };
  return opacities(soft, limit_for(mean(covered), hidden));
}

/// The same for four crossed cards together with the roof, in the mean over their directions. From
/// most directions several cards are seen, one through the gaps of another; the limit is therefore
/// higher than that of one picture.
/// \param covered  seen from south, southeast and east; the fourth card has the second picture
std::array<PixelValues, 3> opacities_from_sides(const std::array<PixelValues, 3>& covered,
                                                const CrownRoof& roof) {
  const CrossedCards crossed(roof);
  const std::array soft{
      with_soft_edges(covered[0]), with_soft_edges(covered[1]), with_soft_edges(covered[2])};
  const auto all_opacities = [&](double limit) {
    return std::array{
        opacities(soft[0], limit), opacities(soft[1], limit), opacities(soft[2], limit)};
  };
  const auto hidden = [&](double limit) {
    const auto tried = all_opacities(limit);
    return crossed.hidden_share({&tried[0], &tried[1], &tried[2], &tried[1]});
  };
  const double share = 0.25 * (mean(covered[0]) + 2.0 * mean(covered[1]) + mean(covered[2]));
  return all_opacities(limit_for(share, hidden));
}

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
