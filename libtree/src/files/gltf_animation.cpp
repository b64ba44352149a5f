// SPDX-License-Identifier: MIT
#include "files/gltf_animation.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace silvafit::tree {

void GltfAnimation::add_scales(std::size_t node,
                               const std::vector<Keyframe>& keyframes,
                               Interpolation interpolation,
                               double step_m) {
  if (keyframes.empty()) return;
  std::vector<float> times;
  std::vector<float> scales;
  for (const Keyframe& keyframe : keyframes) {
    times.push_back(static_cast<float>(keyframe.time_s));
    for (const double scale : keyframe.scale) scales.push_back(static_cast<float>(step_m * scale));
  }
  const std::size_t output = accessor(scales, 3);
  const std::size_t input = accessor(times, 1);
  const std::string sampler = fmt::format("{{\"input\":{},\"interpolation\":\"{}\",\"output\":{}}}",
                                          input,
                                          interpolation == Interpolation::kStep ? "STEP" : "LINEAR",
                                          output);
  const auto [found, is_new] = samplers_.try_emplace(sampler, samplers_.size());
  if (is_new) sampler_text_ += (sampler_text_.empty() ? "" : ",") + sampler;
  if (!channels_.empty()) channels_ += ',';
  channels_ += fmt::format(
      "{{\"sampler\":{},\"target\":{{\"node\":{},\"path\":\"scale\"}}}}", found->second, node);
}

std::size_t GltfAnimation::accessor(const std::vector<float>& values, std::size_t each) {
  const auto [found, is_new] = accessors_.try_emplace({each, values}, 0);
  if (is_new) found->second = buffers_.add_floats(values, each, each == 1);
  return found->second;
}

std::string GltfAnimation::json(const std::vector<NamedTime>& names) const {
  if (channels_.empty()) return {};
  nlohmann::json times = nlohmann::json::array();
  for (const NamedTime& one : names) times.push_back({{"time", one.time_s}, {"name", one.name}});
  return ",\"animations\":[{\"name\":\"growth\",\"extras\":{\"times\":" + times.dump() +
         "},\"samplers\":[" + sampler_text_ + "],\"channels\":[" + channels_ + "]}]";
}

}  // namespace silvafit::tree
