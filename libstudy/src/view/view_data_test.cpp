// SPDX-License-Identifier: MIT
#include "silvafit/study/view_data.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "reference.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/tree/scene.hpp"
#include "silvafit/tree/scene_reader.hpp"
#include "silvafit/tree/scene_writer.hpp"
#include "view/view_stand.hpp"

using Catch::Matchers::Contains;
using nlohmann::json;
using namespace silvafit;
using study::View;
using study::ViewOptions;

namespace {

const tree::BuilderCatalogue& catalogue() {
  static const auto loaded = tree::BuilderCatalogue::load(test::source_file("models"));
  return loaded;
}

data::TextColumn texts(const std::vector<std::string>& values) {
  data::TextColumn column;
  for (const std::string& value : values) column.append(value);
  return column;
}

/// Four trees of two plots; the third has no crown width, the last an OLS crown base above its top.
data::Table four_trees() {
  const double none = data::kMissing;
  data::Table table(4);
  table.set("plot", texts({"1", "1", "2", "2"}));
  table.set("tree", texts({"7", "8", "7", "</script>"}));
  table.set("species", texts({"SM", "MH", "SM", "SM"}));
  table.set("x", std::vector<double>{1000.0, 1004.0, 1010.0, 1020.5});
  table.set("y", std::vector<double>{500.0, 503.0, 500.0, 510.0});
  table.set("z", std::vector<double>{101.0, 102.0, 103.0, 104.0});
  table.set("dbh", std::vector<double>{20.0, 12.5, 30.0, 8.0});
  table.set("h", std::vector<double>{20.0, 9.9, 25.0, 8.0});
  table.set("hcb", std::vector<double>{8.0, 3.0, 9.0, 2.0});
  table.set("cw", std::vector<double>{4.0, 5.0, none, 3.0});
  table.set("h_ols", std::vector<double>{18.0, 10.5, 24.0, 6.0});
  table.set("hcb_ols", std::vector<double>{7.0, 3.5, 8.5, 7.0});
  table.set("cw_ols", std::vector<double>{3.5, 4.5, 4.25, 2.5});
  table.set("M", std::vector<double>{0.25, none, 1.0, 0.0});
  table.set("core", std::vector<double>{1.0, 0.0, 1.0, 1.0});
  return table;
}

ViewOptions coarse() {
  return {.title = "four", .version = "1.2.3", .models_per_preset = 2, .levels = {2, 3}};
}

std::string decoded(const std::string& text) {
  static const std::string digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned value = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    value = value << 6U | static_cast<unsigned>(digits.find(c));
    bits += 6;
    if (bits >= 8) {
      bits -= 8;
      bytes += static_cast<char>(value >> static_cast<unsigned>(bits) & 255U);
    }
  }
  return bytes;
}

/// A scene of two grown trees as a file.
std::string two_trees_glb() {
  const tree::Builder& preset = *catalogue().choose(tree::BuilderKind::kSegment, "SM").builder;
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / "silvafit-view-data-test.glb";
  const auto writer = tree::open_scene(file, tree::SceneFormat::kGlb);
  for (int i = 0; i < 2; ++i) {
    const tree::Morphology morphology{.plot = "1",
                                      .tree = i == 0 ? "7" : "8",
                                      .species = "SM",
                                      .position = {3.0 * i, 4.0, 100.0},
                                      .dbh_cm = 20.0,
                                      .h_m = 15.0 + i,
                                      .hcb_m = 6.0,
                                      .cw_m = 4.0};
    writer->add_tree(tree::grow_tree(morphology, preset, {.mesh = tree::level_of_detail(3)}));
  }
  writer->finish();
  std::string bytes = read_file(file);
  std::filesystem::remove(file);
  return bytes;
}

/// A GLB file with only a JSON part.
std::string glb_of(std::string text) {
  while (text.size() % 4 != 0) text += ' ';
  const auto word = [](std::size_t value) {
    std::string bytes;
    for (std::size_t i = 0; i < 4; ++i) bytes += static_cast<char>(value >> (8 * i) & 255U);
    return bytes;
  };
  return "glTF" + word(2) + word(20 + text.size()) + word(text.size()) + "JSON" + text;
}

}  // namespace

TEST_CASE("marked trees are gone in the variant after thinning") {
  data::Table table = four_trees();
  table.set("thin", std::vector<double>{0.0, 1.0, data::kMissing, 2.0});
  ViewOptions options = coarse();
  options.mark = "thin";
  const View view = view_of_trees(table, catalogue(), options);
  CHECK(view.variants == std::vector<std::string>{"observed", "ols", "thinned"});
  const json data = json::parse(view.data);
  const json& before = data["variants"][0];
  const json& after = data["variants"][2];
  CHECK(after["title"] == "After thinning");
  for (const char* const size : {"h", "hc", "model"}) {
    CHECK(after[size][0] == before[size][0]);
    CHECK(after[size][1].is_null());
    CHECK(after[size][3].is_null());
  }
  // The third tree has no mark, and no crown width.
  CHECK(after["h"][2] == before["h"][2]);
  CHECK(view.notes.back() == "After thinning: 2 of 4 trees are marked in column thin and removed.");
  options.mark = "thinned";
  CHECK_THROWS_WITH(view_of_trees(table, catalogue(), options), Contains("thinned"));
  options.mark = "species";
  CHECK_THROWS_AS(view_of_trees(table, catalogue(), options), InputError);
  CHECK_THROWS_WITH(view_of_scene(two_trees_glb(), nullptr, catalogue(), options),
                    Contains("not of a GLB scene"));
}

TEST_CASE("base64 is that of RFC 4648", "[study][view]") {
  // Test vectors of section 10.
  const std::array<std::pair<const char*, const char*>, 7> vectors{{{"", ""},
                                                                    {"f", "Zg=="},
                                                                    {"fo", "Zm8="},
                                                                    {"foo", "Zm9v"},
                                                                    {"foob", "Zm9vYg=="},
                                                                    {"fooba", "Zm9vYmE="},
                                                                    {"foobar", "Zm9vYmFy"}}};
  for (const auto& [bytes, text] : vectors) CHECK(study::base64(bytes) == text);
  CHECK(study::base64("\xfb\xff\xfe") == "+//+");
}

TEST_CASE("all values of a repeated tree come from its first row that can be drawn",
          "[study][view]") {
  const double none = data::kMissing;
  data::Table table(5);
  table.set("plot", texts({"1", "1", "1", "1", "1"}));
  table.set("tree", texts({"1", "1", "2", "1", "3"}));
  table.set("species", texts({"SM", "SM", "SM", "SM", "SM"}));
  table.set("x", std::vector<double>{0.0, 9.0, 3.0, 6.0, 5.0});
  table.set("y", std::vector<double>{0.0, 9.0, 3.0, 6.0, 0.0});
  table.set("dbh", std::vector<double>{20.0, 40.0, 20.0, 30.0, 20.0});
  table.set("h", std::vector<double>{none, 15.0, 15.0, 14.0, none});
  table.set("hcb", std::vector<double>{5.0, 5.0, 5.0, 5.0, 5.0});
  table.set("cw", std::vector<double>{4.0, 4.0, 4.0, 4.0, 4.0});
  table.set("W", std::vector<double>{0.25, 0.75, 0.5, 1.0, 0.5});
  table.set("core", std::vector<double>{0.0, 1.0, 1.0, 0.0, 1.0});
  table.set_origin("trees.csv", {2, 3, 4, 5, 6});
  const View view = study::view_of_trees(table, catalogue(), coarse());
  const json trees = json::parse(view.data)["trees"];
  CHECK(trees["tree"] == json({"1", "2"}));
  CHECK(trees["x"] == json({9.0, 3.0}));
  CHECK(trees["dbh"] == json({40.0, 20.0}));
  CHECK(trees["W"] == json({0.75, 0.5}));
  CHECK(trees["core"] == json({1, 1}));
  // Every other row is reported: without a height, repeated, without a height.
  std::vector<std::size_t> lines;
  for (const tree::LeftOut& one : view.left_out) lines.push_back(one.place.line.value_or(0));
  CHECK(lines == std::vector<std::size_t>{2, 5, 6});
}

TEST_CASE("a view has each tree once, with its measured and predicted sizes", "[study][view]") {
  const View view = view_of_trees(four_trees(), catalogue(), coarse());
  const json data = json::parse(view.data);
  CHECK(data["schema"] == "silvafit-view/1");
  CHECK(data["silvafit"] == "1.2.3");
  CHECK(view.trees == 4);
  CHECK(view.variants == std::vector<std::string>{"observed", "ols"});
  const json& trees = data["trees"];
  CHECK(trees["tree"] == json({"7", "8", "7", "</script>"}));
  CHECK(data["plots"].size() == 2);
  CHECK(trees["plot"] == json({0, 0, 1, 1}));
  CHECK(data["species"] == json({"SM", "MH"}));
  CHECK(trees["species"] == json({0, 1, 0, 0}));
  CHECK(trees["dbh"] == json({20.0, 12.5, 30.0, 8.0}));
  // Lower below 10 m, middle below 20 m, upper from 20 m.
  CHECK(trees["layer"] == json({2, 0, 2, 0}));
  CHECK(trees["M"] == json({0.25, nullptr, 1.0, 0.0}));
  CHECK(trees["W"] == json({nullptr, nullptr, nullptr, nullptr}));
  CHECK(trees["core"] == json({1.0, 0.0, 1.0, 1.0}));
  CHECK(data["variants"][1]["h"] == json({18.0, 10.5, 24.0, 6.0}));
}

TEST_CASE("a tree without possible sizes is listed, but has no model there", "[study][view]") {
  const View view = view_of_trees(four_trees(), catalogue(), coarse());
  const json data = json::parse(view.data);
  const json& observed = data["variants"][0];
  const json& ols = data["variants"][1];
  CHECK(observed["model"][2].is_null());
  CHECK(observed["hc"][2].is_null());
  CHECK(observed["h"][2] == 25.0);
  CHECK(ols["model"][3].is_null());
  for (const std::size_t i : {0U, 1U, 3U}) CHECK(observed["model"][i].is_number());
  for (const std::size_t i : {0U, 1U, 2U}) CHECK(ols["model"][i].is_number());
  REQUIRE(view.notes.size() == 2);
  CHECK_THAT(view.notes[0], Contains("Observed: 1 of 4 trees"));
  CHECK_THAT(view.notes[1], Contains("OLS: 1 of 4 trees"));
}

TEST_CASE("text instead of one number does not affect other values", "[study][view]") {
  data::Table table = four_trees();
  table.set("h", texts({"20", "9.9", "25?", "8"}));
  const json data = json::parse(view_of_trees(table, catalogue(), coarse()).data);
  CHECK(data["trees"]["h"] == json({20.0, 9.9, nullptr, 8.0}));
  CHECK(data["trees"]["layer"] == json({2, 0, nullptr, 0}));
  CHECK(data["variants"][0]["model"][0].is_number());
}

TEST_CASE("a missing crown width is computed from radii", "[study][view]") {
  data::Table table = four_trees();
  for (const char* name : {"cr_e", "cr_w", "cr_s", "cr_n"}) {
    table.set(name, std::vector<double>{2.0, 2.5, 1.5, 1.0});
  }
  const json data = json::parse(view_of_trees(table, catalogue(), coarse()).data);
  CHECK(data["trees"]["cw"] == json({4.0, 5.0, 3.0, 3.0}));
  CHECK(data["variants"][0]["radii"].is_null());
  table.set("cr_n", std::vector<double>{1.0, 2.5, 1.5, 1.0});
  const json uneven = json::parse(view_of_trees(table, catalogue(), coarse()).data);
  CHECK(uneven["variants"][0]["radii"]["north"] == json({1.0, 2.5, 1.5, 1.0}));
}

TEST_CASE("models are of the tree's preset, at every level, and the ground is below the stems",
          "[study][view]") {
  const View view = view_of_trees(four_trees(), catalogue(), coarse());
  const json data = json::parse(view.data);
  const tree::ReadScene scene = tree::read_glb(decoded(data["models"]["glb"]));
  CHECK(view.models == data["models"]["shapes"].size());
  CHECK(view.models <= std::size_t{2} * 2);
  CHECK(scene.instances.size() == 2 * view.models + 1);
  for (const json& variant : data["variants"]) {
    for (std::size_t i = 0; i < 4; ++i) {
      if (variant["model"][i].is_null()) continue;
      const json& shape = data["models"]["shapes"][variant["model"][i].get<std::size_t>()];
      const json& preset = data["presets"][data["trees"]["preset"][i].get<std::size_t>()];
      CHECK(shape["preset"] == preset["name"]);
    }
  }
  // The ground in the page's frame: y up from the origin, through the feet at 101 to 104 m.
  double low = 1e9;
  double high = -1e9;
  for (const tree::ReadInstance& instance : scene.instances) {
    if (instance.name != "ground") continue;
    const std::vector<float>& points = scene.models[instance.model].parts[0].mesh.positions;
    for (std::size_t i = 0; i < points.size(); i += 3) {
      const double y = instance.moved({points[i], points[i + 1], points[i + 2]})[1];
      low = std::min(low, y);
      high = std::max(high, y);
    }
  }
  const double origin = data["origin"]["z"];
  // Packed in 16 bits over some 30 m: half a millimeter.
  CHECK(low + origin == Approx(101.0).margin(0.001));
  CHECK(high + origin == Approx(104.0).margin(0.001));
}

TEST_CASE("the number of threads does not change a view", "[study][view]") {
  ViewOptions one = coarse();
  one.threads = 1;
  ViewOptions four = coarse();
  four.threads = 4;
  CHECK(view_of_trees(four_trees(), catalogue(), one).data ==
        view_of_trees(four_trees(), catalogue(), four).data);
}

TEST_CASE("plots can be selected, and columns may have other names", "[study][view]") {
  ViewOptions options = coarse();
  options.plots = {"2"};
  CHECK(view_of_trees(four_trees(), catalogue(), options).trees == 2);
  data::Table table = four_trees();
  table.set("height_dm", std::vector<double>{200.0, 99.0, 250.0, 80.0});
  options.plots = {};
  options.columns = {{"h", "height_dm / 10"}};
  const json data = json::parse(view_of_trees(table, catalogue(), options).data);
  CHECK(data["trees"]["h"] == json({20.0, 9.9, 25.0, 8.0}));
}

TEST_CASE("columns are spelled as in the table, and name the observed sizes", "[study][view]") {
  data::Table table = four_trees();
  table.set("Height [m]", texts({"19", "9.5", "n.v.", "7.5"}));
  table.set("BHD [cm]", std::vector<double>{21.0, 13.0, 31.0, 9.0});
  ViewOptions options = coarse();
  options.columns = {{"h", "Height [m]"}, {"dbh", "BHD [cm]"}};
  const json data = json::parse(view_of_trees(table, catalogue(), options).data);
  CHECK(data["trees"]["h"] == json({19.0, 9.5, nullptr, 7.5}));
  CHECK(data["trees"]["dbh"] == json({21.0, 13.0, 31.0, 9.0}));
  // Predictions do not change.
  CHECK(data["variants"][1]["h"] == json({18.0, 10.5, 24.0, 6.0}));
}

TEST_CASE("other columns of the table are there for colors", "[study][view]") {
  data::Table table = four_trees();
  const double none = data::kMissing;
  table.set("origin", texts({"planted", "natural", "natural", "natural"}));
  table.set("constant", std::vector<double>{1.0, 1.0, none, 1.0});
  table.set("site", std::vector<double>{1.0, 2.0, 2.0, none});
  table.set("height_m", std::vector<double>{20.0, 9.9, 25.0, 8.0});
  table.set("area", std::vector<double>{1234567.8, -0.0012345678, 0.0, none});
  ViewOptions options = coarse();
  options.columns = {{"h", "height_m"}};
  const json columns = json::parse(view_of_trees(table, catalogue(), options).data)["columns"];
  std::vector<std::string> names;
  for (const json& column : columns) names.push_back(column["name"]);
  // Without those that have colors of their own, and the one with a single value.
  REQUIRE(names == std::vector<std::string>{"plot", "z", "core", "origin", "site", "area"});
  CHECK(columns[0]["texts"] == json({"1", "2"}));
  CHECK(columns[3]["texts"] == json({"natural", "planted"}));
  CHECK(columns[3]["values"] == json({1.0, 0.0, 0.0, 0.0}));
  CHECK(columns[4]["texts"].is_null());
  CHECK(columns[4]["values"] == json({1.0, 2.0, 2.0, nullptr}));
  // Six digits.
  CHECK(columns[5]["values"] == json({1234570.0, -0.00123457, 0.0, nullptr}));
}

TEST_CASE("errors explain what cannot be shown", "[study][view]") {
  data::Table without(1);
  without.set("plot", texts({"1"}));
  without.set("tree", texts({"1"}));
  without.set("x", std::vector<double>{0.0});
  without.set("y", std::vector<double>{0.0});
  without.set("dbh", std::vector<double>{10.0});
  CHECK_THROWS_AS(view_of_trees(without, catalogue(), coarse()), InputError);
  CHECK_THROWS_WITH(view_of_trees(without, catalogue(), coarse()), Contains("h, hcb and cw"));
  without.set("h", std::vector<double>{1.0});
  without.set("hcb", std::vector<double>{0.5});
  without.set("cw", std::vector<double>{1.0});
  CHECK_THROWS_WITH(view_of_trees(without, catalogue(), coarse()), Contains("no row can be used"));
  ViewOptions options = coarse();
  options.levels = {};
  CHECK_THROWS_AS(view_of_trees(four_trees(), catalogue(), options), UsageError);
  options.levels = {7};
  CHECK_THROWS_AS(view_of_trees(four_trees(), catalogue(), options), UsageError);
}

TEST_CASE("trees are read from a scene of this program", "[study][view]") {
  const std::string glb = two_trees_glb();
  const View view = view_of_scene(glb, nullptr, catalogue(), coarse());
  const json data = json::parse(view.data);
  CHECK(view.trees == 2);
  CHECK(data["models"].is_null());
  // Compressed by zlib (RFC 1950, section 2.2): 0x78, a second byte, and a check of both.
  const std::string scene = decoded(data["scene"]);
  CHECK(scene[0] == 'x');
  CHECK((256 * static_cast<unsigned char>(scene[0]) + static_cast<unsigned char>(scene[1])) % 31 ==
        0);
  CHECK(scene.size() < glb.size() / 2);
  // The model's own height, to 1 cm.
  CHECK(data["trees"]["h"][1].get<double>() == Approx(16.0).margin(0.01));
  CHECK(data["trees"]["x"] == json({0.0, 3.0}));
  CHECK(data["trees"]["y"] == json({4.0, 4.0}));
  CHECK(data["trees"]["z"] == json({100.0, 100.0}));
  CHECK(data["trees"]["node"] == json({0, 1}));
}

TEST_CASE("the trees of a scene get measurements from a table", "[study][view]") {
  data::Table table = four_trees();
  table.set("x", std::vector<double>{0.0, 3.0, 6.0, 9.0});
  table.set("y", std::vector<double>{4.0, 4.0, 4.0, 4.0});
  const View view = view_of_scene(two_trees_glb(), &table, catalogue(), coarse());
  const json data = json::parse(view.data);
  CHECK(data["trees"]["node"] == json({0, 1, nullptr, nullptr}));
  CHECK(data["variants"][1]["h"][0] == 18.0);
  CHECK_THAT(view.notes.back(), Contains("2 of 4 trees of the table are not in the scene"));
  table.set("plot", texts({"9", "9", "9", "9"}));
  table.set("tree", texts({"1", "2", "3", "4"}));
  CHECK_THROWS_WITH(view_of_scene(two_trees_glb(), &table, catalogue(), coarse()),
                    Contains("no tree of the table is in the scene"));
}

TEST_CASE("measurements of trees at other places are never shown", "[study][view]") {
  // The same names, 1000 m away.
  const data::Table table = four_trees();
  CHECK_THROWS_AS(view_of_scene(two_trees_glb(), &table, catalogue(), coarse()), InputError);
  CHECK_THROWS_WITH(view_of_scene(two_trees_glb(), &table, catalogue(), coarse()),
                    Contains("no tree of the table has the position"));
}

TEST_CASE("the position of a tree is that of its parents and its own", "[study][view]") {
  // A quarter turn about the vertical axis takes east, x, to north, -z.
  const std::string glb = glb_of(R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[)"
                                 R"({"translation":[10,2,5],"rotation":[0,0.7071067811865476,0,)"
                                 R"(0.7071067811865476],"children":[1]},{"mesh":0,"translation":)"
                                 R"([3,0,0],"extras":{"tree":1,"dbh":20,"h":12,"hcb":5,"cw":4}}],)"
                                 R"("meshes":[{"primitives":[]}]})");
  const json data = json::parse(view_of_scene(glb, nullptr, catalogue(), coarse()).data);
  REQUIRE(data["trees"]["x"].size() == 1);
  // Positions are written in millimetres.
  CHECK(data["trees"]["x"][0].get<double>() == Approx(10.0).margin(1e-3));
  CHECK(data["trees"]["y"][0].get<double>() == Approx(-2.0).margin(1e-3));
  CHECK(data["trees"]["z"][0].get<double>() == Approx(2.0).margin(1e-3));
}

TEST_CASE("files that are not GLB, or need other files, are errors", "[study][view]") {
  const auto view = [](const std::string& bytes) {
    return view_of_scene(bytes, nullptr, catalogue(), coarse());
  };
  CHECK_THROWS_AS(view(""), InputError);
  CHECK_THROWS_AS(view("glTF and nothing else, but long"), InputError);
  CHECK_THROWS_WITH(view(glb_of("[1,2]")), Contains("not valid JSON"));
  CHECK_THROWS_WITH(view(glb_of(R"({"images":[{"uri":"https://example.org/a.png"}]})")),
                    Contains("a.png"));
  for (const char* const text :
       {R"({"nodes":[{"name":7}],"buffers":[{"uri":3}]})", R"({"buffers":[[1]]})"}) {
    CHECK_THROWS_WITH(view(glb_of(text)), Contains("another type than glTF requires"));
  }
  const auto scene_of = [&](const std::string& more) {
    return glb_of(R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}])" + more + "}");
  };
  CHECK(view(scene_of(R"(,"nodes":[{"extras":{"tree":1,"h":"high"}}])")).trees == 0);
  CHECK(view(scene_of(R"(,"nodes":[{"extras":{"tree":1,"h":12}}])")).trees == 0);
  CHECK(view(scene_of(R"(,"nodes":[{"extras":5}])")).trees == 0);
  // A file that the page could not draw.
  CHECK_THROWS_WITH(
      view(scene_of(R"(,"nodes":[{}],"extensionsRequired":["KHR_draco_mesh_compression"])")),
      Contains("KHR_draco_mesh_compression"));
  CHECK_THROWS_WITH(view(scene_of(R"(,"nodes":[{"mesh":3}])")), Contains("meshes[3]"));
  CHECK_THROWS_WITH(view(scene_of(R"(,"nodes":[{"children":[1]},{"children":[0]}])")),
                    Contains("its own descendant"));
  CHECK_THROWS_WITH(view(scene_of(R"(,"nodes":[{"children":[7]}])")), Contains("nodes[7]"));
  CHECK_THROWS_AS(
      view(scene_of(
          R"(,"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
          R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)"
          R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36}])")),
      InputError);
  const std::string whole = two_trees_glb();
  CHECK_THROWS_WITH(view(whole.substr(0, whole.size() - 100)),
                    Contains("its length differs from the length in its header"));
}
