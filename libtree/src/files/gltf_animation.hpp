// SPDX-License-Identifier: MIT
// The animation of a glTF file.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "files/gltf_buffers.hpp"
#include "silvafit/tree/scene_writer.hpp"

namespace silvafit::tree {

/// Interpolation between keyframes.
enum class Interpolation { kStep, kLinear };

/// Samplers and channels in the order of their addition. Many trees share their keyframes: equal
/// ones, and equal samplers, are written once.
class GltfAnimation {
 public:
  /// \param buffers  receive the keyframes; must outlive this
  explicit GltfAnimation(GltfBuffers& buffers) : buffers_(buffers) {}

  /// Scales of a node over time; nothing without keyframes.
  /// \param step_m  scale of the node's model: the step of its quantized positions, or 1
  void add_scales(std::size_t node,
                  const std::vector<Keyframe>& keyframes,
                  Interpolation interpolation,
                  double step_m);

  /// The field "animations" after a comma, or nothing if there is none.
  std::string json(const std::vector<NamedTime>& names) const;

 private:
  std::size_t accessor(const std::vector<float>& values, std::size_t each);

  GltfBuffers& buffers_;
  std::map<std::pair<std::size_t, std::vector<float>>, std::size_t> accessors_{};
  std::map<std::string, std::size_t> samplers_{};
  std::string sampler_text_{};
  std::string channels_{};
};

}  // namespace silvafit::tree
