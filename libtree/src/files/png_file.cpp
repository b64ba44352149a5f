// SPDX-License-Identifier: MIT
#include "files/png_file.hpp"

#include <map>
#include <mutex>
#include <utility>

#include "files/palette.hpp"

namespace silvafit::tree {
namespace {

struct Known {
  std::weak_ptr<const Texture> texture{};  ///< expired if another texture is at its address now
  std::once_flag once{};
  std::shared_ptr<const std::string> bytes{};
};

}  // namespace

std::shared_ptr<const std::string> png_file(const std::shared_ptr<const Texture>& texture,
                                            bool has_palette) {
  static std::mutex mutex;
  static std::map<std::pair<const Texture*, bool>, std::shared_ptr<Known>> files;
  std::shared_ptr<Known> known;
  {
    const std::scoped_lock lock(mutex);
    std::erase_if(files, [](const auto& file) { return file.second->texture.expired(); });
    std::shared_ptr<Known>& entry = files[{texture.get(), has_palette}];
    if (entry == nullptr) {
      entry = std::make_shared<Known>();
      entry->texture = texture;
    }
    known = entry;
  }
  // Without the lock, so that several pictures can be encoded at the same time.
  std::call_once(known->once, [&] {
    known->bytes = std::make_shared<const std::string>(has_palette ? palette_png_bytes(*texture)
                                                                   : png_bytes(*texture));
  });
  return known->bytes;
}

}  // namespace silvafit::tree
