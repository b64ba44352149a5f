// SPDX-License-Identifier: MIT
// From a turtle's lines to axes with orders.
#include <algorithm>
#include <limits>
#include <span>

#include "silvafit/base/error.hpp"
#include "silvafit/tree/turtle.hpp"

namespace silvafit::tree {
namespace {

class SkeletonMaker {
 public:
  SkeletonMaker(const Drawing& drawing, std::optional<std::uint32_t> bud_grade)
      : drawing_(drawing), bud_grade_(bud_grade) {}

  Skeleton make() {
    find_tops();
    group_by_bearer();
    skeleton_.points.reserve(drawing_.segments.size() + drawing_.lines.size());
    skeleton_.axes.reserve(drawing_.lines.size());
    axis_of_line_.assign(drawing_.lines.size(), kNone);
    add_axis(stem(), 0, 0, true);
    // Parents come before their children, so a parent's axis always exists.
    for (std::uint32_t line = 0; line < drawing_.lines.size(); ++line) {
      if (axis_of_line_[line] != kNone) continue;
      const std::uint32_t before = drawing_.lines[line].before;
      const std::uint32_t parent =
          before == kNone ? 0 : axis_of_line_[drawing_.segments[before].line];
      add_axis(line, skeleton_.axes[parent].order + 1, parent, false);
    }
    add_leaves();
    return std::move(skeleton_);
  }

 private:
  const DrawnLine& line_at(std::uint32_t i) const { return drawing_.lines[i]; }
  double width(std::uint32_t line) const { return drawing_.segments[line_at(line).first].width; }

  /// The height that each segment reaches with its branches.
  void find_tops() {
    tops_.resize(drawing_.segments.size());
    for (std::size_t i = 0; i < tops_.size(); ++i) tops_[i] = drawing_.segments[i].to.z;
    for (std::size_t i = tops_.size(); i-- > 0;) {
      const std::uint32_t before = drawing_.segments[i].before;
      if (before != kNone) tops_[before] = std::max(tops_[before], tops_[i]);
    }
  }

  /// Lines in the order of the segments at whose end they start.
  void group_by_bearer() {
    borne_.resize(drawing_.lines.size());
    for (std::uint32_t i = 0; i < borne_.size(); ++i) borne_[i] = i;
    std::stable_sort(borne_.begin(), borne_.end(), [this](std::uint32_t a, std::uint32_t b) {
      return line_at(a).before < line_at(b).before;
    });
  }

  /// Lines that start at the end of a segment, or at the root.
  std::span<const std::uint32_t> borne_by(std::uint32_t segment) const {
    const auto begin = std::lower_bound(
        borne_.begin(), borne_.end(), segment, [this](std::uint32_t line, std::uint32_t wanted) {
          return line_at(line).before < wanted;
        });
    const auto end = std::upper_bound(
        begin, borne_.end(), segment, [this](std::uint32_t wanted, std::uint32_t line) {
          return wanted < line_at(line).before;
        });
    return {begin, end};
  }

  Point from(std::uint32_t segment) const {
    const DrawnLine& line = line_at(drawing_.segments[segment].line);
    return line.first == segment ? line.from
                                 : drawing_.segments[drawing_.segments[segment].before].to;
  }

  Point heading(std::uint32_t segment) const {
    return direction(drawing_.segments[segment].to - from(segment));
  }

  /// The thickest; of equally thick ones the one with the best score, of equal ones the first.
  template <typename Score>
  std::uint32_t best(std::span<const std::uint32_t> lines, Score score) const {
    constexpr double kEqual = 1e-9;
    std::uint32_t chosen = kNone;
    for (const std::uint32_t line : lines) {
      if (chosen == kNone || width(line) > width(chosen) * (1.0 + kEqual) ||
          (width(line) >= width(chosen) * (1.0 - kEqual) && score(line) > score(chosen) + kEqual)) {
        chosen = line;
      }
    }
    return chosen;
  }

  double top(std::uint32_t line) const { return tops_[line_at(line).first]; }

  /// Of several lines from the ground one is the stem, the others are limbs from its base.
  std::uint32_t stem() const {
    return best(borne_by(kNone), [this](std::uint32_t line) { return top(line); });
  }

  /// The line that continues a line, or kNone.
  std::uint32_t continuation(std::uint32_t line, bool is_stem) const {
    if (line_at(line).has_apex) return kNone;
    const std::uint32_t last = line_at(line).last;
    const Point along = heading(last);
    const Point end = drawing_.segments[last].to;
    std::vector<std::uint32_t> adjoining;
    for (const std::uint32_t next : borne_by(last)) {
      // After a move, a new axis starts.
      if (length(line_at(next).from - end) == 0.0) adjoining.push_back(next);
    }
    return best(adjoining, [&](std::uint32_t next) {
      return is_stem ? top(next) : dot(along, heading(line_at(next).first));
    });
  }

  void add_axis(std::uint32_t line, std::uint32_t order, std::uint32_t parent, bool is_stem) {
    const std::uint32_t index = skeleton_.add_axis(order, parent);
    const std::uint32_t first = skeleton_.axes.back().first;
    skeleton_.add_point(line_at(line).from, 0.5 * width(line));
    for (; line != kNone; line = continuation(line, is_stem)) {
      axis_of_line_[line] = index;
      // A line's segments are consecutive, except for those of its branches.
      const std::size_t begin = skeleton_.points.size();
      for (std::uint32_t segment = line_at(line).last;;
           segment = drawing_.segments[segment].before) {
        skeleton_.add_point(drawing_.segments[segment].to, 0.5 * drawing_.segments[segment].width);
        if (segment == line_at(line).first) break;
      }
      std::reverse(skeleton_.points.begin() + static_cast<std::ptrdiff_t>(begin),
                   skeleton_.points.end());
    }
    // Up to here each point has the width of the segment that ends there.
    for (std::size_t i = first; i + 1 < skeleton_.points.size(); ++i) {
      skeleton_.points[i].radius_m = skeleton_.points[i + 1].radius_m;
    }
    skeleton_.points.back().radius_m = 0.0;
  }

  void add_leaves() {
    skeleton_.leaves.reserve(drawing_.leaves.size());
    for (const DrawnLeaf& leaf : drawing_.leaves) {
      if (leaf.is_bud && !bud_grade_) continue;
      skeleton_.leaves.push_back(leaf.site);
      LeafSite& site = skeleton_.leaves.back();
      site.axis = leaf.line == kNone ? 0 : axis_of_line_[leaf.line];
      if (leaf.is_bud) site.grade = *bud_grade_;
    }
  }

  const Drawing& drawing_;
  std::optional<std::uint32_t> bud_grade_;
  Skeleton skeleton_{};
  std::vector<double> tops_{};
  std::vector<std::uint32_t> borne_{};
  std::vector<std::uint32_t> axis_of_line_{};
};

}  // namespace

Skeleton skeleton_of(const Drawing& drawing,
                     const std::string& file,
                     std::optional<std::uint32_t> bud_grade) {
  if (drawing.lines.empty()) {
    throw InputError(
        "draws no wood; draw branches with F, for example F(1), and check that productions match "
        "the number of parameters and that the number of iterations is not 0",
        {.file = file});
  }
  return SkeletonMaker(drawing, bud_grade).make();
}

}  // namespace silvafit::tree
