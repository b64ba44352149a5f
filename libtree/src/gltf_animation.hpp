// SPDX-License-Identifier: MIT
// The one animation of a glTF file.
#pragma once

#include <map>
#include <string>

namespace silvafit::tree {

/// Samplers and channels as they are added; equal samplers are written once.
class GltfAnimation {
 public:
  /// \param sampler  a JSON object
  void add_scale_channel(std::size_t node, const std::string& sampler) {
    const auto [found, is_new] = samplers_.try_emplace(sampler, samplers_.size());
    if (is_new) sampler_text_ += (sampler_text_.empty() ? "" : ",") + sampler;
    if (!channels_.empty()) channels_ += ',';
    channels_ += "{\"sampler\":" + std::to_string(found->second) +
                 ",\"target\":{\"node\":" + std::to_string(node) + ",\"path\":\"scale\"}}";
  }

  /// The field "animations" after a comma, or nothing where none was added.
  std::string json() const {
    if (channels_.empty()) return {};
    return ",\"animations\":[{\"name\":\"growth\",\"samplers\":[" + sampler_text_ +
           "],\"channels\":[" + channels_ + "]}]";
  }

 private:
  std::map<std::string, std::size_t> samplers_{};
  std::string sampler_text_{};
  std::string channels_{};
};

}  // namespace silvafit::tree
