// SPDX-License-Identifier: MIT
#include "silvafit/tree/turtle.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

// Larger numbers are errors, and their squares would soon overflow a double.
constexpr double kFarthest = 1e9;

/// Turns `a` towards `b`, and `b` away from `a`.
void turn(Point& a, Point& b, double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  const Point turned = c * a + s * b;
  b = c * b - s * a;
  a = turned;
}

/// Prevents that rounding errors accumulate: length 1, right angles.
void straighten(TurtleFrame& frame) {
  frame.heading = direction(frame.heading);
  frame.left = direction(frame.left - dot(frame.left, frame.heading) * frame.heading);
  frame.up = cross(frame.heading, frame.left);
}

bool is_near(Point p) {
  return std::abs(p.x) <= kFarthest && std::abs(p.y) <= kFarthest && std::abs(p.z) <= kFarthest;
}

constexpr char kApex = '\0';
constexpr char kLeaf = 'L';
constexpr char kBud = 'B';

/// What a module does: kLeaf, kBud, its symbol, or kApex for an unknown module.
char command_of(const std::string& name) {
  if (name == "~L" || name == "~B") return name[1];
  constexpr std::string_view kCommands = "Ff+-&^\\/|$!'@[]{}";
  const bool is_known = name.size() == 1 && kCommands.find(name[0]) != std::string_view::npos;
  return is_known ? name[0] : kApex;
}

class Turtle {
 public:
  Turtle(const ModuleString& string,
         const TurtleSettings& settings,
         const std::string& file,
         const LsystemLimits& limits)
      : string_(string), settings_(settings), file_(file), limits_(limits) {
    state_.width = settings.width;
    state_.elasticity = settings.elasticity;
    state_.tropism = settings.tropism;
    for (const std::string& name : string.alphabet()) commands_.push_back(command_of(name));
  }

  Drawing draw() {
    for (at_ = 0; at_ < string_.size(); ++at_) obey(commands_[string_.symbol(at_)]);
    if (!stack_.empty()) fail("a '[' is not closed");
    if (in_outline_) fail("a '{' is not closed");
    return std::move(drawing_);
  }

 private:
  struct State {
    TurtleFrame frame{};
    Point at{};
    double width = 0.0;
    double elasticity = 0.0;
    Point tropism{};
    std::uint32_t segment = Drawing::kNone;  ///< at whose end the turtle is
    std::uint32_t line = Drawing::kNone;     ///< parent of the next segment
    std::uint32_t grade = 0;
    bool begins_line = true;  ///< the next segment is the first of a line
  };

  [[noreturn]] void fail(const std::string& message) const {
    const std::string where =
        at_ < string_.size() ? fmt::format("module {}, {}: ", at_ + 1, string_.text(at_)) : "";
    throw InputError(where + message, {.file = file_});
  }

  double parameter(std::size_t i, double otherwise) const {
    const auto parameters = string_.parameters(at_);
    return i < parameters.size() ? parameters[i] : otherwise;
  }

  double angle_rad() const { return kRadian * parameter(0, settings_.angle_deg); }

  void obey(char command) {
    switch (command) {
      case kApex:
        return note_apex();
      case 'F':
      case 'f':
        return step(command == 'F');
      case '+':
        return state_.frame.turn_left(angle_rad());
      case '-':
        return state_.frame.turn_left(-angle_rad());
      case '&':
        return state_.frame.pitch_down(angle_rad());
      case '^':
        return state_.frame.pitch_down(-angle_rad());
      case '\\':
        return state_.frame.roll_left(angle_rad());
      case '/':
        return state_.frame.roll_left(-angle_rad());
      case '|':
        return state_.frame.turn_left(std::numbers::pi);
      case '$':
        return state_.frame.level();
      case '!':
        return set_width();
      case '\'':
        return set_grade();
      case '@':
        return set_elasticity();
      case '[':
        return begin();
      case ']':
        return end();
      case '{':
        return begin_outline();
      case '}':
        return end_outline();
      case kLeaf:
      case kBud:
        return leaf(command == kBud);
    }
  }

  // ---- Wood -----------------------------------------------------------------------------------

  void step(bool draws) {
    const double distance = parameter(0, settings_.length);
    const Point from = state_.at;
    state_.at = from + distance * state_.frame.heading;
    if (!is_near(state_.at)) {
      fail(fmt::format("the position is farther than {} from the root", kFarthest));
    }
    if (in_outline_) {
      outline_.push_back(state_.at);
    } else if (draws && distance != 0.0) {
      add_segment(from);
    } else if (distance != 0.0) {
      // The next segment does not start where the last one ends.
      state_.begins_line = true;
    }
    if (draws && state_.elasticity != 0.0) {
      state_.frame.bend_towards(state_.tropism, state_.elasticity);
    }
  }

  void add_segment(Point from) {
    const auto index = static_cast<std::uint32_t>(drawing_.segments.size());
    if (state_.begins_line) {
      drawing_.lines.push_back({.from = from, .before = state_.segment, .first = index});
      state_.line = static_cast<std::uint32_t>(drawing_.lines.size() - 1);
      state_.begins_line = false;
    }
    drawing_.segments.push_back({state_.at, state_.width, state_.segment, state_.line});
    DrawnLine& line = drawing_.lines[state_.line];
    line.last = index;
    line.has_apex = false;
    state_.segment = index;
  }

  /// An apex that does not grow further still ends its axis here.
  void note_apex() {
    if (!state_.begins_line && state_.line != Drawing::kNone) {
      drawing_.lines[state_.line].has_apex = true;
    }
  }

  void begin() {
    if (stack_.size() >= limits_.depth) {
      fail(fmt::format("branches are nested more than {} levels deep", limits_.depth));
    }
    stack_.push_back(state_);
    state_.begins_line = true;
  }

  void end() {
    if (stack_.empty()) fail("']' without a matching '['");
    state_ = stack_.back();
    stack_.pop_back();
  }

  void set_width() {
    state_.width = parameter(0, state_.width * settings_.width_ratio);
    if (!(state_.width >= 0.0 && state_.width <= kFarthest)) {
      fail(fmt::format("a width must be a number from 0 to {}", kFarthest));
    }
  }

  void set_grade() {
    constexpr double kMost = 255.0;
    const double grade = parameter(0, state_.grade + 1.0);
    if (!(grade >= 0.0 && grade <= kMost))
      fail("the grade of a leaf must be a number from 0 to 255");
    state_.grade = static_cast<std::uint32_t>(grade);
  }

  void set_elasticity() {
    state_.elasticity = parameter(0, settings_.elasticity);
    if (string_.parameters(at_).size() >= 4) {
      state_.tropism = {parameter(1, 0.0), parameter(2, 0.0), parameter(3, 0.0)};
    }
    if (!is_near(state_.tropism) || std::abs(state_.elasticity) > kFarthest) {
      fail(fmt::format("the components of a tropism must be numbers up to {}", kFarthest));
    }
  }

  // ---- Leaves ---------------------------------------------------------------------------------

  void add_leaf(Point along, Point facing, double length, std::uint32_t grade, bool is_bud) {
    if (length == 0.0) return;
    const LeafSite site{.at = outline_.empty() ? state_.at : outline_.front(),
                        .along = along,
                        .facing = facing,
                        .length_m = length,
                        .grade = grade};
    drawing_.leaves.push_back({site, state_.line, is_bud});
  }

  void leaf(bool is_bud) {
    const double length = parameter(0, settings_.length);
    if (!(length >= 0.0 && length <= kFarthest)) {
      fail(fmt::format("the length of a leaf must be a number from 0 to {}", kFarthest));
    }
    constexpr double kMost = 255.0;
    const double grade = parameter(1, state_.grade);
    if (!(grade >= 0.0 && grade <= kMost))
      fail("the grade of a leaf must be a number from 0 to 255");
    outline_.clear();
    add_leaf(
        state_.frame.heading, state_.frame.up, length, static_cast<std::uint32_t>(grade), is_bud);
    if (is_bud) note_apex();
  }

  void begin_outline() {
    if (in_outline_) fail("outlines { } must not be nested");
    in_outline_ = true;
    outline_.assign(1, state_.at);
  }

  /// An outline represents one leaf: from its first vertex to the farthest one, in its plane.
  void end_outline() {
    if (!in_outline_) fail("'}' without a matching '{'");
    in_outline_ = false;
    const Point base = outline_.front();
    Point farthest{};
    Point normal{};
    for (std::size_t i = 1; i < outline_.size(); ++i) {
      const Point across = outline_[i] - base;
      if (length(across) > length(farthest)) farthest = across;
      if (i + 1 < outline_.size()) normal = normal + cross(across, outline_[i + 1] - base);
    }
    const Point along = direction(farthest, state_.frame.heading);
    normal = normal - dot(normal, along) * along;
    Point facing = direction(normal, state_.frame.up);
    facing = direction(facing - dot(facing, along) * along, state_.frame.left);
    // The upper side is that of the turtle.
    if (dot(facing, state_.frame.up) < 0.0) facing = -1.0 * facing;
    add_leaf(along, facing, length(farthest), state_.grade, false);
    outline_.clear();
  }

  const ModuleString& string_;
  const TurtleSettings& settings_;
  const std::string& file_;
  const LsystemLimits& limits_;
  std::string commands_{};
  State state_{};
  std::vector<State> stack_{};
  std::vector<Point> outline_{};
  bool in_outline_ = false;
  std::size_t at_ = 0;
  Drawing drawing_{};
};

}  // namespace

void TurtleFrame::turn_left(double angle_rad) {
  turn(heading, left, angle_rad);
  straighten(*this);
}

void TurtleFrame::pitch_down(double angle_rad) {
  turn(heading, up, -angle_rad);
  straighten(*this);
}

void TurtleFrame::roll_left(double angle_rad) {
  turn(left, up, -angle_rad);
  straighten(*this);
}

void TurtleFrame::level() {
  const Point horizontal = cross({0.0, 0.0, 1.0}, heading);
  constexpr double kUpright = 1e-9;
  if (length(horizontal) < kUpright) return;
  left = direction(horizontal);
  up = cross(heading, left);
}

void TurtleFrame::bend_towards(Point towards, double elasticity) {
  const Point torque = cross(heading, towards);
  const double size = length(torque);
  if (!(size > 0.0)) return;
  const double angle = elasticity * size;
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const Point axis = (1.0 / size) * torque;
  const auto turned = [&](Point v) {
    return c * v + s * cross(axis, v) + ((1.0 - c) * dot(axis, v)) * axis;
  };
  heading = turned(heading);
  left = turned(left);
  straighten(*this);
}

Drawing draw(const ModuleString& string,
             const TurtleSettings& settings,
             const std::string& file,
             const LsystemLimits& limits) {
  return Turtle(string, settings, file, limits).draw();
}

}  // namespace silvafit::tree
