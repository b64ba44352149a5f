// SPDX-License-Identifier: MIT
#include "impostors/crown_coverage.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "silvafit/base/constants.hpp"
#include "silvafit/tree/point.hpp"

namespace silvafit::tree {
namespace {

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

}  // namespace

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

}  // namespace silvafit::tree
