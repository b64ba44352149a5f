// SPDX-License-Identifier: MIT
#include "silvafit/tree/scene_writer.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <numbers>
#include <sstream>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/tree/ground.hpp"
#include "silvafit/tree/scene_reader.hpp"
#include "silvafit/tree/shared_models.hpp"
#include "test_support/stand_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

namespace fs = std::filesystem;

/// A folder that is removed at the end of the test.
class Folder {
 public:
  explicit Folder(const char* name) : path_(fs::temp_directory_path() / name) {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  fs::path operator/(const char* name) const { return path_ / name; }
  std::size_t count() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(path_), fs::directory_iterator()));
  }

 private:
  fs::path path_;
};

SceneTree fir_tree(const char* name, Position position) {
  Morphology tree = test::paper_tree_1();
  tree.tree = name;
  tree.position = position;
  return grow_tree(tree, test::shipped_presets().named("cunninghamia-lanceolata"));
}

/// All corners of all triangles of an instance, in the scene, as a sorted list, because packing may
/// change the order of triangles.
std::vector<std::array<double, 3>> corners_of(const ReadScene& scene,
                                              const ReadInstance& instance) {
  std::vector<std::array<double, 3>> corners;
  for (const ReadPart& part : scene.models[instance.model].parts) {
    for (const std::uint32_t index : part.mesh.indices) {
      const float* p = part.mesh.positions.data() + 3 * std::size_t{index};
      corners.push_back(instance.moved({p[0], p[1], p[2]}));
    }
  }
  return corners;
}

struct Extent {
  std::array<double, 3> least{1e9, 1e9, 1e9};
  std::array<double, 3> most{-1e9, -1e9, -1e9};
  std::array<double, 3> sum{};
};

Extent extent_of(const std::vector<std::array<double, 3>>& corners) {
  Extent extent;
  for (const auto& corner : corners) {
    for (std::size_t k = 0; k < 3; ++k) {
      extent.least[k] = std::min(extent.least[k], corner[k]);
      extent.most[k] = std::max(extent.most[k], corner[k]);
      extent.sum[k] += corner[k];
    }
  }
  return extent;
}

}  // namespace

TEST_CASE("uncompressed GLB and glTF are read back exactly") {
  const Folder folder("silvafit-plain-test");
  const SceneTree tree = fir_tree("1", {12.5, 30.25, 101.5});
  for (const SceneFormat format : {SceneFormat::kGlb, SceneFormat::kGltf}) {
    const fs::path path = folder / (format == SceneFormat::kGlb ? "a.glb" : "b c.gltf");
    const auto writer = open_scene(path, format, {.origin = {10, 30, 100}});
    writer->add_tree(tree);
    const std::size_t bytes = writer->finish();
    CHECK(bytes >= fs::file_size(path));
    const ReadScene scene = read_scene(path);
    CHECK(scene.origin.x_m == 10);
    CHECK(scene.origin.z_m == 100);
    REQUIRE(scene.instances.size() == 1);
    CHECK(scene.instances[0].name == "1-1");
    CHECK(scene.instances[0].transform[12] == 2.5);
    CHECK(scene.instances[0].transform[13] == 1.5);
    CHECK(scene.instances[0].transform[14] == -0.25);
    REQUIRE(scene.models[0].parts.size() == tree.mesh.parts.size());
    for (std::size_t p = 0; p < tree.mesh.parts.size(); ++p) {
      const ReadPart& part = scene.models[0].parts[p];
      CHECK(part.part == part_name(tree.mesh.parts[p].kind));
      CHECK(part.mesh.positions == tree.mesh.parts[p].positions);
      CHECK(part.mesh.normals == tree.mesh.parts[p].normals);
      CHECK(part.mesh.colors == tree.mesh.parts[p].colors);
      CHECK(part.mesh.uvs == tree.mesh.parts[p].uvs);
      CHECK(part.mesh.indices == tree.mesh.parts[p].indices);
      CHECK(part.mesh.color == tree.mesh.parts[p].color);
    }
    CHECK(scene.triangle_count() == tree.measured.triangles);
  }
}

TEST_CASE("quantized and packed trees have their measurements to the quantization step") {
  const Folder folder("silvafit-packed-test");
  const SceneTree tree = fir_tree("1", {3, 4, 5});
  const auto corners_with = [&](SceneOptions options, const char* name) {
    const auto writer = open_scene(folder / name, SceneFormat::kGlb, options);
    writer->add_tree(tree);
    writer->finish();
    const ReadScene scene = read_scene(folder / name);
    REQUIRE(scene.instances.size() == 1);
    return std::pair(corners_of(scene, scene.instances[0]), scene);
  };
  const auto plain = corners_with({}, "plain.glb").first;
  const auto [quantized, quantized_scene] = corners_with({.quantize = true}, "quantized.glb");
  const auto [packed, packed_scene] = corners_with({.compress = true}, "packed.glb");
  // Steps of 1.5 mm, because 20.2 m are fewer than 32767 of them; the error is half a step.
  const double half_step = 0.5 * 0.0015;
  REQUIRE(quantized.size() == plain.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      // The node's scale has seven digits: 2e-7 of 20 m.
      REQUIRE(std::abs(quantized[i][k] - plain[i][k]) < half_step + 1e-5);
    }
  }
  // Packing changes the order of triangles, but not the extent and the sum of their corners.
  REQUIRE(packed.size() == quantized.size());
  const Extent a = extent_of(quantized);
  const Extent b = extent_of(packed);
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK(a.least[k] == b.least[k]);
    CHECK(a.most[k] == b.most[k]);
    CHECK(a.sum[k] == Approx(b.sum[k]).epsilon(1e-9));  // another order of summation
  }
  const auto mesh_of = [](const ReadScene& scene) {
    Mesh mesh;
    for (const ReadPart& part : scene.models[0].parts) {
      mesh.parts.push_back(part.mesh);
      for (float& value : mesh.parts.back().positions) {
        value = static_cast<float>(value * scene.instances[0].transform[0]);
      }
    }
    return mesh;
  };
  // If its ring is moved by half a step, the section at 1.3 m is interpolated between two rings.
  const Measurements measured = measure(mesh_of(packed_scene));
  CHECK(measured.h_m == Approx(20.2).margin(0.001));
  CHECK(measured.dbh_cm == Approx(test::paper_tree_1().dbh_cm).margin(0.1));
  CHECK(measured.hcb_m == Approx(5.8).margin(0.01));
  // Normals in 8 bits: within 1 degree, octahedral or not.
  for (const ReadScene* scene : {&quantized_scene, &packed_scene}) {
    for (const ReadPart& part : scene->models[0].parts) {
      for (std::size_t i = 0; i < part.mesh.normals.size(); i += 3) {
        const float* n = part.mesh.normals.data() + i;
        REQUIRE(std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) == Approx(1.0).margin(0.02));
      }
    }
  }
  CHECK(fs::file_size(folder / "packed.glb") < fs::file_size(folder / "quantized.glb"));
  CHECK(fs::file_size(folder / "quantized.glb") < fs::file_size(folder / "plain.glb"));
}

TEST_CASE("quantized cards show the same places of their pictures") {
  const Folder folder("silvafit-cards-test");
  Morphology beech = test::paper_tree_1();
  beech.species = "Fagus sylvatica";
  const SceneTree tree =
      grow_tree(beech, test::shipped_presets().named("fagus"), {.mesh = {.textured = true}});
  const auto scene_with = [&](SceneOptions options, const char* name) {
    const auto writer = open_scene(folder / name, SceneFormat::kGlb, options);
    writer->add_tree(tree);
    writer->finish();
    return read_scene(folder / name);
  };
  const ReadScene plain = scene_with({}, "plain.glb");
  const ReadScene quantized = scene_with({.quantize = true}, "quantized.glb");
  std::size_t cards = 0;
  for (std::size_t p = 0; p < plain.models[0].parts.size(); ++p) {
    if (plain.models[0].parts[p].part != part_name(PartKind::kFoliage)) continue;
    const std::vector<float>& uvs = plain.models[0].parts[p].mesh.uvs;
    REQUIRE(quantized.models[0].parts[p].mesh.uvs.size() == uvs.size());
    for (std::size_t i = 0; i < uvs.size(); ++i) {
      REQUIRE(quantized.models[0].parts[p].mesh.uvs[i] == Approx(uvs[i]).margin(1e-5));
    }
    cards += uvs.size() / 2;
  }
  CHECK(cards > 100);
}

TEST_CASE("joined wood has all triangles of stem and branches, in one part") {
  for (const bool textured : {false, true}) {
    const Preset& fir = test::shipped_presets().named("cunninghamia-lanceolata");
    const Mesh whole = grow_tree(test::paper_tree_1(), fir, {.mesh = {.textured = textured}}).mesh;
    const Mesh joined = with_joined_wood(whole);
    REQUIRE(whole.parts.size() == 3);
    REQUIRE(joined.parts.size() == 2);
    CHECK(joined.vertex_count() == whole.vertex_count());
    CHECK(joined.triangle_count() == whole.triangle_count());
    const MeshPart& wood = joined.parts.front();
    CHECK(wood.kind == PartKind::kStem);
    CHECK(wood.normals.size() == wood.positions.size());
    CHECK(wood.uvs.size() == (textured ? 2 * wood.vertex_count() : 0));
    CHECK(wood.tangents.size() == (textured ? 4 * wood.vertex_count() : 0));
    // The last triangle of the branches, where it was.
    const MeshPart& branches = whole.parts[1];
    for (std::size_t k = 1; k <= 3; ++k) {
      const std::size_t was = branches.indices[branches.indices.size() - k];
      const std::size_t now = wood.indices[wood.indices.size() - k];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        CHECK(wood.positions[3 * now + axis] == branches.positions[3 * was + axis]);
      }
    }
  }
  const Mesh bare{.parts = {{.kind = PartKind::kStem}, {.kind = PartKind::kFoliage}}};
  CHECK(with_joined_wood(bare).parts.size() == 2);
}

TEST_CASE("shared models have the positions of the trees, as nodes and as instances") {
  const Folder folder("silvafit-shared-test");
  const SceneTree model = fir_tree("model", {});
  for (const bool compress : {false, true}) {
    for (const bool instancing : {false, true}) {
      const fs::path path = folder / "shared.glb";
      const auto writer =
          open_scene(path, SceneFormat::kGlb, {.instancing = instancing, .compress = compress});
      const auto id = writer->add_model("model", parts_of(model.mesh, model.preset));
      constexpr int kTrees = 50;
      for (int i = 0; i < kTrees; ++i) {
        const double size = 0.5 + 0.02 * i;
        writer->place(id,
                      "t-" + std::to_string(i),
                      {{1.5 * i, 2.0 * i, 0.25 * i}, 1.0, size, 1.0 / size},
                      static_cast<std::size_t>(i));
      }
      writer->finish();
      const ReadScene scene = read_scene(path);
      CHECK(scene.models.size() == 1);
      REQUIRE(scene.instances.size() == kTrees);
      for (int i = 0; i < kTrees; ++i) {
        const ReadInstance& instance = scene.instances[static_cast<std::size_t>(i)];
        CHECK((instancing ? instance.tree == i : instance.name == "t-" + std::to_string(i)));
        const Extent extent = extent_of(corners_of(scene, instance));
        const double size = 0.5 + 0.02 * i;
        // Floats and 16 bits of 20 m leave less than a millimeter.
        CHECK(extent.most[1] == Approx(0.25 * i + size * 20.2).margin(0.001));
        CHECK(extent.most[0] == Approx(1.5 * i + 2.1).margin(0.011));
        CHECK(extent.least[2] == Approx(-2.0 * i - 2.4 / size).margin(0.022));
      }
    }
  }
}

TEST_CASE("a tree needs less than 200 bytes as a node and 50 as an instance") {
  const Folder folder("silvafit-bytes-test");
  const SceneTree model = fir_tree("model", {});
  const auto size_with = [&](int trees, bool instancing) {
    const auto writer = open_scene(folder / "n.glb", SceneFormat::kGlb, {.instancing = instancing});
    const auto id = writer->add_model("model", parts_of(model.mesh, model.preset));
    Random random(60);
    for (int i = 0; i < trees; ++i) {
      const auto place = [&random] { return std::round(100 * random.uniform(0, 8000)) / 100; };
      const auto stretch = [&random] { return random.uniform(0.8, 1.25); };
      writer->place(id,
                    "plot12-" + std::to_string(100000 + i),
                    {{place(), place(), place()}, stretch(), stretch(), stretch()},
                    static_cast<std::size_t>(i));
    }
    return static_cast<double>(writer->finish());
  };
  CHECK((size_with(2000, false) - size_with(1000, false)) / 1000 < 200);
  CHECK((size_with(2000, true) - size_with(1000, true)) / 1000 < 50);
}

TEST_CASE("OBJ files of a folder share their pictures") {
  const Folder folder("silvafit-shared-pictures-test");
  const Preset& preset = test::shipped_presets().named("schima-superba");
  SharedPictures pictures;
  std::vector<std::string> materials;
  std::vector<fs::path> others;
  for (const auto& [file, of_materials] :
       {std::pair{"a.obj", "a.mtl"}, std::pair{"b.obj", "b.mtl"}}) {
    const auto writer = open_scene(folder / file, SceneFormat::kObj, {.pictures = &pictures});
    writer->add_tree(
        grow_tree(test::paper_tree_1(), preset, {.mesh = level_of_detail(3, {.textured = true})}));
    writer->finish();
    materials.push_back(read_file(folder / of_materials));
    others = writer->other_files();
  }
  CHECK(materials[0] == materials[1]);
  // The materials, bark and shoots.
  REQUIRE(others.size() == 3);
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(folder / "")) {
    files += entry.path().extension() == ".png" ? 1U : 0U;
  }
  CHECK(files == 2);
  for (std::size_t i = 1; i < others.size(); ++i) {
    CHECK(fs::exists(others[i]));
    CHECK(materials[0].find("map_Kd " + others[i].filename().string()) != std::string::npos);
  }
  // Another picture of the same name is not lost.
  const auto picture = [](std::uint8_t red) {
    return std::make_shared<const Texture>(
        Texture{.name = "same", .width = 1, .height = 1, .rgba = {red, 0, 0, 255}});
  };
  CHECK(pictures.add(folder / "", picture(1)).filename() == "same.png");
  CHECK(pictures.add(folder / "", picture(1)).filename() == "same.png");
  CHECK(pictures.add(folder / "", picture(2)).filename() == "same~2.png");
}

TEST_CASE("OBJ and PLY have the vertices of the mesh at their positions") {
  const Folder folder("silvafit-text-test");
  const SceneTree tree = fir_tree("a b", {10, 20, 5});
  const auto write = [&](const char* name, SceneFormat format, SceneOptions options) {
    const auto writer = open_scene(folder / name, format, options);
    writer->add_tree(tree);
    writer->finish();
    return read_file(folder / name);
  };
  std::istringstream obj(write("t.obj", SceneFormat::kObj, {}));
  std::size_t vertices = 0;
  std::size_t faces = 0;
  double top = 0.0;
  for (std::string line; std::getline(obj, line);) {
    if (line.rfind("v ", 0) == 0) {
      ++vertices;
      double x = 0, y = 0, z = 0;
      std::istringstream(line.substr(2)) >> x >> y >> z;
      top = std::max(top, y);
    }
    faces += line.rfind("f ", 0) == 0 ? 1 : 0;
    if (line.rfind("o ", 0) == 0) CHECK(line == "o 1-a_b");
  }
  CHECK(vertices == tree.measured.vertices);
  CHECK(faces == tree.measured.triangles);
  CHECK(top == Approx(25.2).margin(0.0001));  // four decimals are written
  CHECK(read_file(folder / "t.mtl").find("newmtl cunninghamia-lanceolata-bark") !=
        std::string::npos);

  const std::string binary = write("t.ply", SceneFormat::kPly, {});
  const std::size_t body = binary.find("end_header\n") + 11;
  CHECK(binary.size() - body == 27 * tree.measured.vertices + 13 * tree.measured.triangles);
  float first = 0.0F;
  std::memcpy(&first, binary.data() + body, sizeof(first));
  CHECK(first == tree.mesh.parts[0].positions[0] + 10.0F);
  const std::string text = write("u.ply", SceneFormat::kPly, {.ascii = true});
  CHECK(text.find("format ascii 1.0") != std::string::npos);
}

TEST_CASE("without finish no file is left, and impossible scenes are refused") {
  const Folder folder("silvafit-left-test");
  for (const SceneFormat format :
       {SceneFormat::kGlb, SceneFormat::kGltf, SceneFormat::kObj, SceneFormat::kPly}) {
    {
      const auto writer = open_scene(folder / "x", format);
      writer->add_tree(fir_tree("1", {}));
    }
    CHECK(folder.count() == 0);
    CHECK_THROWS_AS(open_scene(folder / "x", format)->finish(), GeometryError);
    CHECK(folder.count() == 0);
  }
  CHECK_THROWS_AS(open_scene(folder / "x", SceneFormat::kObj, {.compress = true}), UsageError);
  CHECK_THROWS_AS(silvafit::value_of<SceneFormat>("fbx", "scene format"), UsageError);
}

TEST_CASE("a scene that is too long for GLB is refused, but not as glTF") {
  const Folder folder("silvafit-long-test");
  const auto write = [&](SceneFormat format, std::size_t longest) {
    const auto writer = open_scene(folder / "x", format, {.longest_glb = longest});
    writer->add_tree(fir_tree("1", {}));
    return writer->finish();
  };
  write(SceneFormat::kGlb, std::numeric_limits<std::uint32_t>::max());
  const std::size_t size = fs::file_size(folder / "x");
  CHECK_NOTHROW(write(SceneFormat::kGlb, size));
  fs::remove(folder / "x");
  CHECK_THROWS_WITH(write(SceneFormat::kGlb, size - 1), Catch::Matchers::Contains("write glTF"));
  CHECK(folder.count() == 0);
  CHECK_NOTHROW(write(SceneFormat::kGltf, size - 1));
}

TEST_CASE("damaged files are refused with an error") {
  const Folder folder("silvafit-damaged-test");
  const auto writer = open_scene(folder / "d.glb", SceneFormat::kGlb, {.compress = true});
  writer->add_tree(fir_tree("1", {}));
  writer->finish();
  const std::string whole = read_file(folder / "d.glb");
  CHECK_NOTHROW(read_glb(whole));
  CHECK_THROWS_AS(read_glb(whole.substr(0, whole.size() / 2)), InputError);
  CHECK_THROWS_AS(read_glb(""), InputError);
  CHECK_THROWS_AS(read_glb("glTF and no more than that"), InputError);
  // A file with a changed byte is read or refused, without crashes; see the sanitizer builds.
  Random random(61);
  for (int i = 0; i < 300; ++i) {
    std::string damaged = whole;
    const std::size_t until = i % 2 == 0 ? 4000 : damaged.size();
    for (int k = 0; k < 3; ++k) {
      damaged[random.below(std::min(until, damaged.size()))] = static_cast<char>(random.below(256));
    }
    try {
      read_glb(damaged);
    } catch (const InputError&) {
    }
  }
  try {
    write_file(folder / "e.glb", whole.substr(0, 100));
    read_scene(folder / "e.glb");
    FAIL("a damaged file was read");
  } catch (const InputError& error) {
    CHECK(error.place().file == (folder / "e.glb").string());
  }
}

TEST_CASE("a description with the buffer of another scene is refused") {
  const Folder folder("silvafit-buffers-test");
  for (const char* const name : {"a.gltf", "b.gltf"}) {
    const auto writer = open_scene(folder / name, SceneFormat::kGltf);
    writer->add_tree(fir_tree(name, {}));
    if (name[0] == 'b') writer->add_tree(fir_tree("2", {}));
    writer->finish();
    CHECK_NOTHROW(read_scene(folder / name));
  }
  const std::string own = read_file(folder / "a.bin");
  std::string changed = own;
  changed.back() = static_cast<char>(changed.back() ^ 1);
  for (const std::string& buffer :
       {read_file(folder / "b.bin"), own.substr(0, own.size() - 4), changed}) {
    write_file(folder / "a.bin", buffer);
    CHECK_THROWS_WITH(
        read_scene(folder / "a.gltf"),
        Catch::Matchers::Contains("its buffer a.bin is not the one that was written with it"));
  }
  write_file(folder / "a.bin", own);
  CHECK_NOTHROW(read_scene(folder / "a.gltf"));
}

TEST_CASE("the ground passes through every stem base and covers the stand once") {
  std::vector<Position> stems;
  // A regular grid, where more than three stems lie on one circle, and scattered ones.
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 5; ++k) stems.push_back({100.0 + 2 * i, 200.0 + 2 * k, 0.1 * i * k});
  }
  Random random(62);
  for (int i = 0; i < 40; ++i) {
    stems.push_back({random.uniform(115, 130), random.uniform(200, 215), random.uniform(0, 3)});
  }
  const MeshPart ground = ground_mesh(stems, {100, 200, 0});
  for (const Position& stem : stems) {
    double nearest = 1e9;
    for (std::size_t v = 0; v < ground.vertex_count(); ++v) {
      const float* at = ground.positions.data() + 3 * v;
      if (std::hypot(at[0] + 100 - stem.x_m, 200 - at[2] - stem.y_m) < 0.0075) {
        nearest = std::min(nearest, std::abs(at[1] - stem.z_m));
      }
    }
    REQUIRE(nearest < 1e-6);
  }
  // Seen from above all triangles turn one way and their areas add up to the box with its margin.
  double area = 0.0;
  for (std::size_t i = 0; i < ground.indices.size(); i += 3) {
    const auto at = [&](std::size_t k) {
      return ground.positions.data() + 3 * std::size_t{ground.indices[i + k]};
    };
    const float *a = at(0), *b = at(1), *c = at(2);
    const double twice = (b[0] - a[0]) * (a[2] - c[2]) - (c[0] - a[0]) * (a[2] - b[2]);
    REQUIRE(twice > 0.0);
    area += 0.5 * twice;
  }
  float left = 1e9F, right = -1e9F, near = -1e9F, far = 1e9F;
  for (std::size_t v = 0; v < ground.vertex_count(); ++v) {
    left = std::min(left, ground.positions[3 * v]);
    right = std::max(right, ground.positions[3 * v]);
    near = std::max(near, ground.positions[3 * v + 2]);
    far = std::min(far, ground.positions[3 * v + 2]);
  }
  CHECK(area == Approx((right - left) * (near - far)).epsilon(1e-5));
  CHECK(left == -2.0F);
  CHECK(ground_mesh(std::vector<Position>{{5, 5, 1}}, {}).triangle_count() == 4);
  CHECK_THROWS_AS(ground_mesh({}, {}), GeometryError);
  CHECK_THROWS_AS(ground_mesh(std::vector<Position>{{5e8, 0, 0}, {0, 0, 0}}, {}), GeometryError);
}

TEST_CASE("the ground passes through the cells of a terrain between the stems") {
  // A slope of 1 in 10 to the east with a hill of one cell; one cell is unknown.
  data::Raster terrain{.west = 100.5, .north = 219.5, .columns = 40, .rows = 20};
  for (std::size_t row = 0; row < terrain.rows; ++row) {
    for (std::size_t column = 0; column < terrain.columns; ++column) {
      terrain.values.push_back(50.0F + 0.1F * static_cast<float>(column));
    }
  }
  terrain.values[10 * 40 + 8] = 60.0F;
  terrain.values[10 * 40 + 9] = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Position> stems{{105.25, 205.25, 50.475}, {112.75, 213.25, 51.225}};
  const MeshPart ground = ground_mesh(stems, {100, 200, 50}, 2.0, &terrain);
  // Centers 103.5 to 114.5 and 203.5 to 214.5, but for the unknown one; two stems, four corners.
  CHECK(ground.vertex_count() == 12 * 12 - 1 + 2 + 4);
  std::size_t hills = 0;
  for (std::size_t v = 0; v < ground.vertex_count(); ++v) {
    const float* at = ground.positions.data() + 3 * v;
    if (at[1] != 10.0F) continue;
    ++hills;
    CHECK(at[0] == 8.5F);
    CHECK(-at[2] == 9.5F);
  }
  CHECK(hills == 1);
  // The corner at 103.25, 203.25 is on the slope, 2.75 cells east of the first center.
  bool has_corner = false;
  for (std::size_t v = 0; v < ground.vertex_count(); ++v) {
    const float* at = ground.positions.data() + 3 * v;
    if (at[0] != 3.25F || at[2] != -3.25F) continue;
    has_corner = true;
    CHECK(at[1] == Approx(0.275).margin(1e-5));
  }
  CHECK(has_corner);
  // Beyond kMostGroundPoints only every second cell of each direction is used.
  data::Raster fine{.west = 0.0,
                    .north = 100.0,
                    .step_x = 0.4,
                    .step_y = 0.4,
                    .columns = 251,
                    .rows = 251,
                    .values = std::vector<float>(std::size_t{251} * 251, 1.0F)};
  const MeshPart thinned =
      ground_mesh(std::vector<Position>{{0, 0, 1}, {100, 100, 1}}, {}, 2.0, &fine);
  // The stems are cells, too.
  CHECK(thinned.vertex_count() == 126 * 126 + 4);
}

TEST_CASE("shared trees have their height and crown width, and the stated errors of the rest") {
  Random random(63);
  std::vector<Morphology> trees;
  std::vector<const Builder*> builders;
  const auto all = test::shipped_builders().of(BuilderKind::kSegment);
  for (int i = 0; i < 300; ++i) {
    Morphology tree{.plot = "p", .tree = std::to_string(i)};
    tree.h_m = random.uniform(5, 25);
    tree.hcb_m = tree.h_m * random.uniform(0.2, 0.6);
    tree.dbh_cm = tree.h_m * random.uniform(0.8, 1.6);
    const auto radius = [&] { return random.uniform(0.8, 3.0); };
    tree.radii = CrownRadii{radius(), radius(), radius(), radius()};
    trees.push_back(tree);
    builders.push_back(all[static_cast<std::size_t>(i) % 2]);
  }
  double worst_before = 1e9;
  for (const std::size_t number : {4, 30}) {
    const SharedModels shared = share_models(trees, builders, number);
    CHECK(shared.models.size() <= 2 * number);
    double worst = 0.0;
    std::vector<SceneTree> grown;
    for (const SharedModel& model : shared.models) {
      grown.push_back(grow_tree(model.morphology, *model.builder));
    }
    for (std::size_t i = 0; i < trees.size(); ++i) {
      const SharedTree& tree = shared.trees[i];
      REQUIRE(shared.models[tree.model].builder == builders[i]);
      const Measurements& model = grown[tree.model].measured;
      const CrownRadii& r = model.radii;
      const CrownRadii& own = *trees[i].radii;
      // The measurements of the stretched mesh; models have an error of 1 cm.
      CHECK(model.h_m * tree.stretch_up == Approx(trees[i].h_m).margin(0.02));
      const double width = 0.5 * (tree.stretch_east * (r.east_m + r.west_m) +
                                  tree.stretch_north * (r.south_m + r.north_m));
      CHECK(width == Approx(own.width_m()).margin(0.05));
      const double off_base = 100 * std::abs(model.hcb_m * tree.stretch_up - trees[i].hcb_m);
      CHECK(off_base == Approx(tree.error.hcb_cm).margin(2.5));
      const double off_east = 100 * std::abs(r.east_m * tree.stretch_east - own.east_m);
      CHECK(off_east <= tree.error.radius_cm + 2.5);
      worst = std::max(worst, tree.error.hcb_cm + tree.error.radius_cm);
    }
    CHECK(worst < worst_before);
    worst_before = worst;
  }
  // As many models as trees: every tree has its own model without error.
  const SharedModels exact = share_models(trees, builders, trees.size());
  for (const SharedTree& tree : exact.trees) {
    CHECK(tree.error.hcb_cm < 1e-6);
    CHECK(tree.error.radius_cm < 1e-6);
  }
  CHECK_THROWS_AS(share_models(trees, builders, 0), UsageError);
}

TEST_CASE("the error of a shared stem is that of the stretched mesh") {
  // A model and a tree 1.3 times as high and 1.2 times as wide: its section at 1.3 m was the
  // model's at 1 m. The model's stem here is a square tower that narrows from 60 cm at the ground
  // to 20 cm at 2 m, so 40 cm wide at 1 m, whatever any taper equation says.
  Mesh tower;
  MeshPart stem{.kind = PartKind::kStem};
  for (const auto& [y, half] : {std::pair{0.0F, 0.3F}, {2.0F, 0.1F}, {10.0F, 0.0F}}) {
    for (const auto& [x, z] :
         {std::pair{1.0F, 1.0F}, {-1.0F, 1.0F}, {-1.0F, -1.0F}, {1.0F, -1.0F}}) {
      stem.positions.insert(stem.positions.end(), {x * half, y, z * half});
    }
  }
  for (const std::uint32_t ring : {0U, 4U}) {
    for (std::uint32_t side = 0; side < 4; ++side) {
      const std::uint32_t a = ring + side, b = ring + (side + 1) % 4;
      stem.indices.insert(stem.indices.end(), {a, b, b + 4, a, b + 4, a + 4});
    }
  }
  tower.parts = {stem};
  const Morphology like{.plot = "p", .tree = "1", .dbh_cm = 34.0, .h_m = 10.0};
  Morphology tree = like;
  tree.dbh_cm = 50.0;
  SharedModels shared{
      .models = {{.morphology = like, .trees = {0, 1}}},
      .trees = {SharedTree{}, {.stretch_east = 1.5, .stretch_up = 1.3, .stretch_north = 0.96}}};
  measure_stems(0, tower, std::vector{like, tree}, shared);
  // 60 - 20 * 1.3 = 34 cm wide at 1.3 m; a square's area as a circle's. To the floats' rounding.
  const double of_square = 2.0 / std::sqrt(std::numbers::pi);
  CHECK(shared.trees[0].error.dbh_cm == Approx(34.0 * of_square - 34.0).margin(1e-4));
  CHECK(shared.trees[1].error.dbh_cm == Approx(40.0 * 1.2 * of_square - 50.0).margin(1e-4));
}
