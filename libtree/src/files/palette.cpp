// SPDX-License-Identifier: MIT
#include "files/palette.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <queue>
#include <span>
#include <unordered_map>
#include <vector>

namespace silvafit::tree {
namespace {

constexpr std::size_t kMostColors = 96;  // of 256; more are hardly visible

/// A color with the number of its pixels.
struct Counted {
  Rgba color{};
  std::size_t pixels = 0;
};

/// Colors that the palette does not distinguish.
struct Box {
  std::span<Counted> colors{};
  std::size_t channel = 0;  ///< the one that varies most
  double gain = 0.0;        ///< of a cut: the extent times the number of pixels

  explicit Box(std::span<Counted> of) : colors(of) {
    std::size_t pixels = 0;
    for (const Counted& one : colors) pixels += one.pixels;
    int widest = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto [low, high] =
          std::ranges::minmax_element(colors, {}, [k](const Counted& one) { return one.color[k]; });
      const int extent = high->color[k] - low->color[k];
      if (extent > widest) {
        widest = extent;
        channel = k;
      }
    }
    gain = static_cast<double>(widest) * static_cast<double>(pixels);
  }

  bool operator<(const Box& other) const { return gain < other.gain; }

  /// Both parts have about half of the pixels, and at least one color each.
  std::size_t cut() {
    std::ranges::sort(colors, [this](const Counted& a, const Counted& b) {
      return a.color[channel] != b.color[channel] ? a.color[channel] < b.color[channel]
                                                  : a.color < b.color;
    });
    std::size_t pixels = 0;
    for (const Counted& one : colors) pixels += one.pixels;
    std::size_t sum = 0;
    std::size_t at = 0;
    while (at + 2 < colors.size() && 2 * (sum + colors[at].pixels) < pixels) {
      sum += colors[at++].pixels;
    }
    return at + 1;
  }
};

Rgba mean_of(std::span<const Counted> colors) {
  std::array<std::size_t, 4> sums{};
  std::size_t pixels = 0;
  for (const Counted& one : colors) {
    for (std::size_t k = 0; k < 4; ++k) sums[k] += one.pixels * one.color[k];
    pixels += one.pixels;
  }
  Rgba mean{};
  for (std::size_t k = 0; k < 4; ++k) {
    mean[k] = static_cast<std::uint8_t>((sums[k] + pixels / 2) / pixels);
  }
  return mean;
}

/// A number for each color. Pictures have a million pixels, of which many have the color of the one
/// before.
class ColorNumbers {
 public:
  std::size_t& operator[](const Rgba& color) {
    const std::uint32_t key = packed(color);
    if (last_ == nullptr || key != last_key_) {
      last_ = &numbers_[key];  // stays valid when others are added
      last_key_ = key;
    }
    return *last_;
  }

  bool contains(const Rgba& color) const { return numbers_.contains(packed(color)); }

  /// In the order of the colors.
  std::vector<Counted> sorted() const {
    std::vector<Counted> colors;
    colors.reserve(numbers_.size());
    for (const auto& [key, number] : numbers_) colors.push_back({unpacked(key), number});
    std::ranges::sort(colors, {}, &Counted::color);
    return colors;
  }

 private:
  static std::uint32_t packed(const Rgba& c) {
    return std::uint32_t{c[0]} << 24U | std::uint32_t{c[1]} << 16U | std::uint32_t{c[2]} << 8U |
           std::uint32_t{c[3]};
  }
  static Rgba unpacked(std::uint32_t key) {
    Rgba color{};
    for (std::size_t k = 0; k < 4; ++k) {
      color[k] = static_cast<std::uint8_t>(key >> (24U - 8U * k) & 255U);
    }
    return color;
  }

  std::unordered_map<std::uint32_t, std::size_t> numbers_{};
  std::uint32_t last_key_ = 0;
  std::size_t* last_ = nullptr;
};

/// Opaque and invisible colors are apart from all others.
std::vector<Box> separate_boxes(std::vector<Counted>& colors) {
  const auto kind = [](const Counted& one) {
    return one.color[3] == 255 ? 0 : one.color[3] == 0 ? 2 : 1;
  };
  std::ranges::stable_sort(colors, {}, kind);
  std::vector<Box> boxes;
  for (auto from = colors.begin(); from != colors.end();) {
    const auto to = std::find_if(
        from, colors.end(), [&](const Counted& one) { return kind(one) != kind(*from); });
    boxes.emplace_back(std::span(from, to));
    from = to;
  }
  return boxes;
}

}  // namespace

PaletteImage with_palette(const Texture& texture) {
  ColorNumbers counts;
  const auto color_at = [&](std::size_t pixel) {
    const std::uint8_t* from = texture.rgba.data() + 4 * pixel;
    return from[3] == 0 ? Rgba{} : Rgba{from[0], from[1], from[2], from[3]};
  };
  const std::size_t pixels = texture.rgba.size() / 4;
  for (std::size_t i = 0; i < pixels; ++i) ++counts[color_at(i)];
  std::vector<Counted> colors = counts.sorted();

  std::priority_queue<Box> boxes;
  for (const Box& box : separate_boxes(colors)) boxes.push(box);
  while (boxes.size() < kMostColors && boxes.top().gain > 0.0) {
    Box box = boxes.top();
    boxes.pop();
    const std::size_t at = box.cut();
    boxes.emplace(box.colors.first(at));
    boxes.emplace(box.colors.subspan(at));
  }

  PaletteImage image;
  for (; !boxes.empty(); boxes.pop()) {
    for (const Counted& one : boxes.top().colors) counts[one.color] = image.palette.size();
    image.palette.push_back(mean_of(boxes.top().colors));
  }
  if (counts.contains(Rgba{})) {
    std::erase_if(colors, [](const Counted& one) { return one.color[3] == 0; });
    Rgba& hidden = image.palette[counts[Rgba{}]];
    if (!colors.empty()) hidden = mean_of(colors);
    hidden[3] = 0;
  }
  image.numbers.reserve(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    image.numbers.push_back(static_cast<std::uint8_t>(counts[color_at(i)]));
  }
  return image;
}

}  // namespace silvafit::tree
