// SPDX-License-Identifier: MIT
// Wavefront OBJ with its materials in a separate MTL file.
#include <fmt/format.h>

#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "files/baked.hpp"
#include "files/format_writers.hpp"
#include "files/palette.hpp"
#include "silvafit/base/atomic_file.hpp"

namespace silvafit::tree {
namespace {

/// OBJ separates words by spaces.
std::string one_word(std::string name) {
  for (char& c : name) {
    if (static_cast<unsigned char>(c) <= ' ') c = '_';
  }
  return name;
}

class ObjWriter final : public BakingWriter {
 public:
  ObjWriter(const std::filesystem::path& path, const SceneOptions& options)
      : BakingWriter(options.origin),
        shared_(options.pictures),
        // The file name without spaces, as written in the OBJ file.
        materials_path_(path.parent_path() / one_word(path.stem().string() + ".mtl")),
        file_(path) {
    const Position& origin = options.origin;
    put(fmt::format("# silvafit: meters, y up, x east, z south; origin {} {} {}\nmtllib {}\n",
                    origin.x_m,
                    origin.y_m,
                    origin.z_m,
                    materials_path_.filename().string()));
  }

  std::vector<std::filesystem::path> other_files() const override {
    std::vector<std::filesystem::path> files{materials_path_};
    for (const auto& [name, path] : pictures_) files.push_back(path);
    return files;
  }

  std::size_t finish() override {
    if (vertices_ == 0) throw GeometryError("a scene needs at least one tree");
    AtomicFile materials(materials_path_);
    materials.stream() << materials_;
    // The OBJ file last, so that it never refers to a missing file.
    std::vector<AtomicFile*> files;
    for (const auto& picture : picture_files_) files.push_back(picture.get());
    files.push_back(&materials);
    files.push_back(&file_);
    commit_together(files);
    return size_ + materials_.size();
  }

 private:
  void begin_tree(const std::string& name) override { put(fmt::format("o {}\n", one_word(name))); }

  void add_part(const std::string& part,
                const std::string& material,
                const MeshPart& mesh) override {
    describe(material, mesh);
    fmt::memory_buffer text;
    auto to = std::back_inserter(text);
    fmt::format_to(to, "g {}\nusemtl {}\n", part, one_word(material));
    const auto put_triples =
        [&to](const std::vector<float>& values,
              fmt::format_string<const float&, const float&, const float&> line) {
          for (std::size_t i = 0; i < values.size(); i += 3) {
            fmt::format_to(to, line, values[i], values[i + 1], values[i + 2]);
          }
        };
    // Coordinates are written to a tenth of a millimeter.
    put_triples(mesh.positions, "v {:.4f} {:.4f} {:.4f}\n");
    put_triples(mesh.normals, "vn {:.3f} {:.3f} {:.3f}\n");
    for (std::size_t i = 0; i < mesh.uvs.size(); i += 2) {
      // In OBJ v increases upward.
      fmt::format_to(to, "vt {:.4f} {:.4f}\n", mesh.uvs[i], 1.0F - mesh.uvs[i + 1]);
    }
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      fmt::format_to(to, "f");
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t vertex = mesh.indices[i + k] + vertices_ + 1;
        const std::size_t uv = mesh.indices[i + k] + uvs_ + 1;
        if (mesh.uvs.empty()) {
          fmt::format_to(to, " {}//{}", vertex, vertex);
        } else {
          fmt::format_to(to, " {}/{}/{}", vertex, uv, vertex);
        }
      }
      fmt::format_to(to, "\n");
    }
    vertices_ += mesh.vertex_count();
    uvs_ += mesh.uvs.size() / 2;
    put(fmt::to_string(text));
  }

  void describe(const std::string& material, const MeshPart& mesh) {
    if (!known_.insert(material).second) return;
    materials_ += fmt::format("newmtl {}\nKd {:.4f} {:.4f} {:.4f}\nKs 0 0 0\nillum 1\n",
                              one_word(material),
                              mesh.color[0],
                              mesh.color[1],
                              mesh.color[2]);
    if (mesh.texture != nullptr && !mesh.uvs.empty()) {
      const std::string file = picture_file(mesh.texture);
      materials_ += fmt::format("map_Kd {}\n", file);
      if (has_transparency(*mesh.texture)) materials_ += fmt::format("map_d {}\n", file);
    }
    materials_ += '\n';
  }

  std::filesystem::path path_of_picture(const std::string& name) const {
    std::filesystem::path path = materials_path_;
    path.replace_extension();
    path += "-" + one_word(name) + ".png";
    return path;
  }

  /// Writes an image to the folder of the materials, once.
  std::string picture_file(const std::shared_ptr<const Texture>& texture) {
    std::filesystem::path& path = pictures_[texture->name];
    if (path.empty() && shared_ != nullptr) {
      path = shared_->add(materials_path_.parent_path(), texture);
    } else if (path.empty()) {
      path = path_of_picture(texture->name);
      const auto bytes = png_file(texture);
      picture_files_.push_back(std::make_unique<AtomicFile>(path));
      picture_files_.back()->stream() << *bytes;
      size_ += bytes->size();
    }
    return path.filename().string();
  }

  void put(const std::string& text) {
    file_.stream() << text;
    size_ += text.size();
  }

  SharedPictures* shared_;
  std::filesystem::path materials_path_;
  AtomicFile file_;
  std::string materials_{};
  std::set<std::string> known_{};
  std::map<std::string, std::filesystem::path> pictures_{};  ///< by the name of the texture
  std::vector<std::unique_ptr<AtomicFile>> picture_files_{};
  std::size_t vertices_ = 0;
  std::size_t uvs_ = 0;
  std::size_t size_ = 0;
};

}  // namespace

std::filesystem::path SharedPictures::add(const std::filesystem::path& folder,
                                          const std::shared_ptr<const Texture>& texture) {
  const std::scoped_lock lock(mutex_);
  const auto bytes = png_file(texture);
  const std::string name = one_word(texture->name);
  for (int number = 1;; ++number) {
    const std::filesystem::path path =
        folder / (number == 1 ? name + ".png" : fmt::format("{}~{}.png", name, number));
    const auto [found, is_new] = files_.emplace(path, bytes);
    if (is_new) write_file(path, *bytes);
    if (is_new || *found->second == *bytes) return path;
  }
}

std::unique_ptr<SceneWriter> make_obj_writer(const std::filesystem::path& path,
                                             const SceneOptions& options) {
  return std::make_unique<ObjWriter>(path, options);
}

}  // namespace silvafit::tree
