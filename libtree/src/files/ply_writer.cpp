// SPDX-License-Identifier: MIT
// Stanford PLY with a color per vertex, binary or text.
#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstring>
#include <iterator>
#include <limits>

#include "files/baked.hpp"
#include "files/format_writers.hpp"
#include "files/spool.hpp"
#include "pictures/shoot_canvas.hpp"
#include "silvafit/base/atomic_file.hpp"

namespace silvafit::tree {
namespace {

static_assert(std::endian::native == std::endian::little,
              "PLY is written in the byte order of the machine");

class PlyWriter final : public BakingWriter {
 public:
  PlyWriter(const std::filesystem::path& path, const SceneOptions& options)
      : BakingWriter(options.origin),
        path_(path),
        options_(options),
        vertices_(path),
        faces_(path) {}

  std::size_t finish() override {
    if (face_count_ == 0) throw GeometryError("a scene needs at least one tree");
    const Position& origin = options_.origin;
    const std::string header = fmt::format(
        "ply\nformat {} 1.0\ncomment silvafit: meters, y up, x east, z south; origin {} {} {}\n"
        "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
        "property float nx\nproperty float ny\nproperty float nz\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        options_.ascii ? "ascii" : "binary_little_endian",
        origin.x_m,
        origin.y_m,
        origin.z_m,
        vertex_count_,
        face_count_);
    AtomicFile file(path_);
    file.stream() << header;
    vertices_.copy_to(file.stream());
    faces_.copy_to(file.stream());
    file.commit();
    return header.size() + vertices_.size() + faces_.size();
  }

 private:
  void begin_tree(const std::string& /*name*/) override {}

  void add_part(const std::string& /*part*/,
                const std::string& /*material*/,
                const MeshPart& mesh) override {
    if (vertex_count_ + mesh.vertex_count() > std::numeric_limits<std::int32_t>::max()) {
      throw GeometryError(
          "the scene has more vertices than a PLY file can index; grow fewer plots");
    }
    for (std::size_t i = 0; i < mesh.vertex_count(); ++i) add_vertex(mesh, i);
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) add_face(mesh, i);
    vertex_count_ += mesh.vertex_count();
    face_count_ += mesh.triangle_count();
    flush();
  }

  void add_vertex(const MeshPart& mesh, std::size_t i) {
    std::array<std::uint8_t, 3> color{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double factor = mesh.colors.empty() ? 1.0 : mesh.colors[4 * i + k] / 255.0;
      // PLY viewers use bytes as sRGB.
      color[k] = exact_srgb_byte(mesh.color[k] * factor);
    }
    const float* at = mesh.positions.data() + 3 * i;
    const float* normal = mesh.normals.data() + 3 * i;
    if (options_.ascii) {
      fmt::format_to(std::back_inserter(vertex_block_),
                     "{} {} {} {} {} {} {} {} {}\n",
                     at[0],
                     at[1],
                     at[2],
                     normal[0],
                     normal[1],
                     normal[2],
                     color[0],
                     color[1],
                     color[2]);
      return;
    }
    append(vertex_block_, at, 3 * sizeof(float));
    append(vertex_block_, normal, 3 * sizeof(float));
    append(vertex_block_, color.data(), color.size());
  }

  void add_face(const MeshPart& mesh, std::size_t i) {
    std::array<std::int32_t, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = static_cast<std::int32_t>(mesh.indices[i + k] + vertex_count_);
    }
    if (options_.ascii) {
      fmt::format_to(
          std::back_inserter(face_block_), "3 {} {} {}\n", corners[0], corners[1], corners[2]);
      return;
    }
    constexpr std::uint8_t kCorners = 3;
    append(face_block_, &kCorners, 1);
    append(face_block_, corners.data(), sizeof(corners));
  }

  static void append(std::string& to, const void* bytes, std::size_t size) {
    to.append(static_cast<const char*>(bytes), size);
  }

  void flush() {
    vertices_.append(vertex_block_);
    faces_.append(face_block_);
    vertex_block_.clear();
    face_block_.clear();
  }

  std::filesystem::path path_;
  SceneOptions options_;
  Spool vertices_;
  Spool faces_;
  std::string vertex_block_{};
  std::string face_block_{};
  std::size_t vertex_count_ = 0;
  std::size_t face_count_ = 0;
};

}  // namespace

std::unique_ptr<SceneWriter> make_ply_writer(const std::filesystem::path& path,
                                             const SceneOptions& options) {
  return std::make_unique<PlyWriter>(path, options);
}

}  // namespace silvafit::tree
