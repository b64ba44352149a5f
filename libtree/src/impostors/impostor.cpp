// SPDX-License-Identifier: MIT
#include "silvafit/tree/impostor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include "impostors/crown_pictures.hpp"
#include "mesh/crown_light.hpp"
#include "mesh/mesh_checks.hpp"
#include "mesh/part_builder.hpp"
#include "mesh/segment_tubes.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::tree {
namespace {

/// A line of a card's grid: its place on the tree and in the picture.
struct GridLine {
  double place_m = 0.0;
  double share = 0.0;  ///< of the picture's width or height
};

/// A picture in the atlas.
struct PictureCell {
  CrownView view = CrownView::kSouth;
  bool is_mirrored = false;

  /// \param right, up  from the lower left corner of the crown, in [0, 1]
  std::array<double, 2> uv(double right, double up) const {
    constexpr double kCell = 0.5 * kAtlasSteps;
    const auto number = static_cast<std::size_t>(view);
    const double across = is_mirrored ? 1.0 - right : right;
    const double u = kCell * static_cast<double>(number % 2) + kBorderSteps + kCrownSteps * across;
    const double v =
        kCell * static_cast<double>(number / 2) + kBorderSteps + kCrownSteps * (1.0 - up);
    return {u / kAtlasSteps, v / kAtlasSteps};
  }
};

/// A plane with a picture, seen against `facing`.
struct Card {
  Point origin{};
  Point right{};
  Point up{};
  Point facing{};
  std::vector<GridLine> columns{};  ///< along `right`
  std::vector<GridLine> rows{};     ///< along `up`
  PictureCell picture{};
};

/// The cards of a crown.
class CardBuilder {
 public:
  CardBuilder(const TreeShape& shape, const Crown& crown, PartBuilder& build)
      : light_(crown),
        // Less than floats and pictures resolve, but enough to keep the two sides apart.
        gap_m_(0.001 * shape.radii.narrowest_m()),
        build_(build) {}

  /// Both sides of a card.
  void add(const Card& card) {
    add_side(card, 1.0);
    add_side(card, -1.0);
  }

  /// The crown from above, on a flat pyramid that has the measured radii at the widest height and
  /// rises towards the axis. Seen from a low angle it does not look like a plate.
  void add_roof(const TreeShape& shape, const PictureCell& picture) {
    const CrownRadii& radii = shape.radii;
    const std::array<GridLine, 3> columns{{{-radii.west_m, 0.0}, {0.0, 0.5}, {radii.east_m, 1.0}}};
    const std::array<GridLine, 3> rows{{{-radii.south_m, 0.0}, {0.0, 0.5}, {radii.north_m, 1.0}}};
    const double rise = roof_rise_m(shape);
    const std::uint32_t first = build_.vertex_count();
    for (const GridLine& row : rows) {
      for (const GridLine& column : columns) {
        const bool is_middle = column.share == 0.5 && row.share == 0.5;
        const Point at{column.place_m, row.place_m, shape.hc_m + (is_middle ? rise : 0.0)};
        build_.vertex(at, direction(light_.outward(at) + Point{0.0, 0.0, 1.0}));
        const auto [u, v] = picture.uv(column.share, row.share);
        build_.texture({.u = u, .v = v, .tangent = {1.0, 0.0, 0.0}});
      }
    }
    // All diagonals meet in the middle.
    constexpr std::array<std::uint32_t, 9> kAround{0, 1, 2, 5, 8, 7, 6, 3, 0};
    for (std::size_t i = 0; i + 1 < kAround.size(); ++i) {
      build_.triangle(first + 4, first + kAround[i], first + kAround[i + 1]);
    }
  }

 private:
  void add_side(const Card& card, double side) {
    const auto columns = static_cast<std::uint32_t>(card.columns.size());
    const std::uint32_t first = build_.vertex_count();
    for (const GridLine& row : card.rows) {
      for (const GridLine& column : card.columns) {
        const Point on_card = card.origin + column.place_m * card.right + row.place_m * card.up;
        const Point facing = side * card.facing;
        build_.vertex(on_card + gap_m_ * facing,
                      direction(facing + light_.outward(on_card) + CrownLight::kAbove));
        const auto [u, v] = card.picture.uv(column.share, row.share);
        build_.texture({.u = u, .v = v, .tangent = card.right});
      }
    }
    for (std::uint32_t row = 0; row + 1 < card.rows.size(); ++row) {
      for (std::uint32_t column = 0; column + 1 < columns; ++column) {
        const std::uint32_t low = first + row * columns + column;
        const std::uint32_t high = low + columns;
        add_quad({low, low + 1, high + 1, high}, side > 0.0);
      }
    }
  }

  void add_quad(std::array<std::uint32_t, 4> corners, bool is_front) {
    if (!is_front) std::swap(corners[1], corners[3]);
    build_.triangle(corners[0], corners[1], corners[2]);
    build_.triangle(corners[0], corners[2], corners[3]);
  }

  CrownLight light_;
  double gap_m_;
  PartBuilder& build_;
};

/// The ends, and a line between them unless it is where the picture has it anyway.
std::vector<GridLine> grid_lines(double from_m, double middle_m, double to_m, double share) {
  constexpr double kSame = 1e-3;
  const double length = to_m - from_m;
  const double at = (middle_m - from_m) / length;
  // A crown may be widest at its base or its top; that part of the picture then has no space.
  if (std::abs(at - share) < kSame) return {{from_m, 0.0}, {to_m, 1.0}};
  if (at < kSame) return {{from_m, share}, {to_m, 1.0}};
  if (at > 1.0 - kSame) return {{from_m, 0.0}, {to_m, share}};
  return {{from_m, 0.0}, {middle_m, share}, {to_m, 1.0}};
}

/// Which of the pictures a tree shows, and which way round.
struct Sides {
  bool is_turned = false;
  std::array<bool, 4> is_mirrored{};

  explicit Sides(Random& random) : is_turned(random.below(2) == 1) {
    for (bool& mirrored : is_mirrored) mirrored = random.below(2) == 1;
  }

  /// \param eighths  direction of the card, from east over north
  PictureCell of(int eighths) const {
    const auto number = static_cast<std::size_t>(eighths);
    if (eighths % 2 == 1) return {CrownView::kSoutheast, is_mirrored[number]};
    const bool is_south = (eighths == 0) != is_turned;
    return {is_south ? CrownView::kSouth : CrownView::kEast, is_mirrored[number]};
  }
};

void add_crown(const TreeShape& shape,
               const Crown& crown,
               double relative_hc,
               const Sides& sides,
               PartBuilder& build) {
  CardBuilder cards(shape, crown, build);
  constexpr int kUpright = 4;
  const auto rows = grid_lines(shape.hcb_m, shape.hc_m, shape.h_m, relative_hc);
  for (int i = 0; i < kUpright; ++i) {
    const double azimuth = i * std::numbers::pi / kUpright;
    // Exactly the measured directions, although cosines are rounded.
    const Point right = i == 0   ? Point{1.0, 0.0, 0.0}
                        : i == 2 ? Point{0.0, 1.0, 0.0}
                                 : Point{std::cos(azimuth), std::sin(azimuth), 0.0};
    cards.add({.right = right,
               .up = {0.0, 0.0, 1.0},
               .facing = {right.y, -right.x, 0.0},
               .columns = grid_lines(
                   -crown.radius_m(-right.x, -right.y), 0.0, crown.radius_m(right.x, right.y), 0.5),
               .rows = rows,
               .picture = sides.of(i)});
  }
  cards.add_roof(shape, {CrownView::kAbove, sides.is_mirrored[0]});
}

/// The stem up to the crown base or above breast height, and its end in the crown. Above, it is in
/// the pictures.
std::vector<SkeletonPoint> visible_stem(const TreeShape& shape, const Taper& taper) {
  // Trees that share a model are scaled, so that another section is at breast height.
  constexpr double kShortest = 2.0 * kBreastHeight;
  constexpr double kEnd = 0.1;
  const double top = std::max(shape.hcb_m, kShortest);
  std::vector<double> heights = section_heights_m(shape.h_m);
  const bool is_cut = top < shape.h_m;
  if (is_cut) {
    // Sections that floats can distinguish.
    constexpr double kNearest = 0.002;
    std::erase_if(heights, [top](double z) { return z > top - kNearest; });
    heights.push_back(top);
  }
  const std::vector<double> radii = taper.radii_m(heights, shape.h_m, shape.dbh_cm);
  std::vector<SkeletonPoint> points;
  points.reserve(heights.size() + 1);
  for (std::size_t i = 0; i < heights.size(); ++i) {
    points.push_back({{0.0, 0.0, heights[i]}, radii[i]});
  }
  if (is_cut) points.push_back({{0.0, 0.0, top + kEnd * (shape.h_m - top)}, 0.0});
  return points;
}

}  // namespace

/// The pictures that were drawn, each once.
class Impostors::Pictures {
 public:
  const CrownPictures& of(const Builder& builder, CrownClass crown, Season season) {
    Drawn* drawn = nullptr;
    {
      const std::scoped_lock lock(mutex_);
      drawn = &drawn_[{&builder, crown, season}];
    }
    std::call_once(drawn->once, [&] { drawn->pictures = draw_crown(builder, crown, season); });
    return drawn->pictures;
  }

 private:
  struct Drawn {
    std::once_flag once{};
    CrownPictures pictures{};
  };
  std::mutex mutex_{};
  std::map<std::tuple<const Builder*, CrownClass, Season>, Drawn> drawn_{};
};

Impostors::Impostors() : pictures_(std::make_unique<Pictures>()) {}
Impostors::~Impostors() = default;

Mesh Impostors::build(const Builder& builder,
                      const TreeShape& shape,
                      Random& random,
                      const MeshOptions& options) {
  const CrownPictures& pictures = pictures_->of(builder, class_of(shape), options.season);
  const Crown crown(shape, builder.preset().crown_index);
  MeshPart stem{.kind = PartKind::kStem, .color = pictures.bark};
  MeshPart foliage{.kind = PartKind::kFoliage,
                   .variant = pictures.name,
                   .color = {1.0, 1.0, 1.0},
                   .texture = pictures.texture};
  PartBuilder stem_builder(stem);
  constexpr int kSides = 4;
  add_stem(visible_stem(shape, builder.preset().taper),
           {.stem_sides = kSides, .stem_tolerance_m = options.stem_tolerance_m},
           stem_builder);
  stem_builder.finish();
  PartBuilder foliage_builder(foliage);
  foliage_builder.reserve(128, 128);
  add_crown(shape, crown, pictures.relative_hc, Sides(random), foliage_builder);
  foliage_builder.finish();

  // Wood is inside the crown, and the stem ends at its base.
  Mesh mesh{.surface_error_m = std::hypot(shape.radii.widest_m(), shape.h_m - shape.hcb_m)};
  take_parts(mesh, {&stem, &foliage});
  return mesh;
}

}  // namespace silvafit::tree
