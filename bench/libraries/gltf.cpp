// SPDX-License-Identifier: MIT
// Seconds and memory to read a GLB file: the project's reader, or tinygltf (which also writes it
// again), one of them a call, since memory is that of the process.
#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <cstring>
#include <string>

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE  // for scenes without pictures
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include "measurement.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/tree/scene_reader.hpp"

namespace {

class Timer {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

void read_with_silvafit(const std::string& file) {
  const Timer timer;
  const silvafit::tree::ReadScene scene = silvafit::tree::read_scene(file);
  std::printf("silvafit: read %zu triangles in %.3f s, %.0f MB\n",
              scene.triangle_count(),
              timer.seconds(),
              peak_megabytes());
}

void read_with_tinygltf(const std::string& file) {
  tinygltf::Model model;
  tinygltf::TinyGLTF io;
  std::string error;
  std::string warning;
  const Timer reading;
  if (!io.LoadBinaryFromFile(&model, &error, &warning, file)) {
    throw silvafit::InputError("tinygltf cannot read it: " + error, {.file = file});
  }
  std::printf("tinygltf: read %zu meshes in %.3f s, %.0f MB\n",
              model.meshes.size(),
              reading.seconds(),
              peak_megabytes());
  const Timer writing;
  if (!io.WriteGltfSceneToFile(&model, file + ".tinygltf.glb", false, true, false, true)) {
    throw silvafit::InputError("tinygltf cannot write it", {.file = file});
  }
  std::printf("tinygltf: written in %.3f s, %.0f MB\n", writing.seconds(), peak_megabytes());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: %s silvafit|tinygltf FILE.glb\n", argv[0]);
    return 2;
  }
  return silvafit::bench::exit_status([&] {
    if (std::strcmp(argv[1], "silvafit") == 0) {
      read_with_silvafit(argv[2]);
    } else {
      read_with_tinygltf(argv[2]);
    }
  });
}
