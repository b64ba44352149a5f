// SPDX-License-Identifier: MIT
// `silvafit render`: images of models and stands, without a graphics card.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "command.hpp"
#include "output_files.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/render/forest_floor.hpp"
#include "silvafit/render/models.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

using nlohmann::ordered_json;

struct RenderArguments {
  CommonOptions common{};
  std::vector<std::string> models{};
  std::string out{};
  std::string size = "1280x720";
  std::string sun = "135,45";
  std::string date{};
  std::string place{};
  std::string camera = "200,12";
  std::string target{};
  std::string eye{};
  std::string look{};
  std::string path{};
  bool is_bare = false;
  std::size_t turntable = 0;
  std::size_t columns = 0;
  bool without_ground = false;
  render::RenderOptions options{};
};

/// Two numbers of a text such as `200,12` or `1280x720`.
std::array<double, 2> pair_of(const std::string& text, char separator, const std::string& option) {
  const std::size_t middle = text.find(separator);
  std::array<double, 2> values{};
  const bool is_pair = middle != std::string::npos &&
                       data::parse_number(text.substr(0, middle), values[0]) &&
                       data::parse_number(text.substr(middle + 1), values[1]);
  if (!is_pair) {
    throw UsageError(fmt::format("{} needs two numbers, A{}B, not '{}'", option, separator, text));
  }
  return values;
}

/// A point of a text such as `3,-2.5,8` (east, north, up) in the axes of the ray tracer.
render::Vector point_of(const std::string& text, const std::string& option) {
  std::array<double, 3> values{};
  std::istringstream words(text);
  std::size_t count = 0;
  bool is_point = true;
  for (std::string word; std::getline(words, word, ','); ++count) {
    is_point = is_point && count < values.size() && data::parse_number(word, values[count]);
  }
  is_point = is_point && count == values.size();
  if (!is_point) {
    throw UsageError(fmt::format("{} needs three numbers, EAST,NORTH,UP, not '{}'", option, text));
  }
  return {values[0], values[2], -values[1]};
}

/// The height of the eyes of a standing person [m].
constexpr double kEyeHeight = 1.7;
/// Wider than the default, as one looks around in a forest [degrees].
constexpr double kWalkingView = 60.0;

/// Heights of the eyes are still those above the ground.
render::Standpoint standpoint_of(const RenderArguments& arguments) {
  const bool has_height = std::ranges::count(arguments.eye, ',') == 2;
  render::Standpoint result;
  if (has_height) {
    result.eye = point_of(arguments.eye, "--eye");
  } else {
    const auto [east, north] = pair_of(arguments.eye, ',', "--eye");
    result.eye = {east, kEyeHeight, -north};
  }
  if (arguments.look.empty()) return result;
  const bool has_elevation = arguments.look.find(',') != std::string::npos;
  const std::string both = has_elevation ? arguments.look : arguments.look + ",0";
  const auto [azimuth, elevation] = pair_of(both, ',', "--look");
  result.azimuth_deg = azimuth;
  result.elevation_deg = elevation;
  return result;
}

/// The frames of a walk: a row each.
std::vector<render::Standpoint> walk_of(const std::string& file) {
  const data::Table table = data::read_csv_table(file);
  constexpr std::string_view kColumns = "east north azimuth up elevation";
  for (const std::string& name : table.names()) {
    if (has_word(kColumns, name)) continue;
    throw InputError(
        "the frames of a walk have no such column, only east, north, azimuth, up and "
        "elevation",
        {.file = file, .column = name});
  }
  const auto values = [&](const char* name, double otherwise) -> std::vector<double> {
    if (table.has(name)) {
      const auto known = table.numbers(name);
      return {known.begin(), known.end()};
    }
    if (std::isnan(otherwise)) {
      throw InputError(
          "the frames of a walk need the columns east, north and azimuth; up (default "
          "1.7, above the ground) and elevation (default 0) may be there",
          {.file = file, .column = name});
    }
    return std::vector<double>(table.rows(), otherwise);
  };
  const auto east = values("east", data::kMissing);
  const auto north = values("north", data::kMissing);
  const auto azimuth = values("azimuth", data::kMissing);
  const auto up = values("up", kEyeHeight);
  const auto elevation = values("elevation", 0.0);
  std::vector<render::Standpoint> result;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    for (const double value : {east[row], north[row], azimuth[row], up[row], elevation[row]}) {
      if (!std::isfinite(value)) {
        throw InputError("a value of this frame is missing",
                         {.file = file, .line = table.line(row)});
      }
    }
    result.push_back({.eye = {east[row], up[row], -north[row]},
                      .azimuth_deg = azimuth[row],
                      .elevation_deg = elevation[row]});
  }
  if (result.empty()) throw InputError("there is no frame", {.file = file});
  return result;
}

/// Empty without a place of the eye.
std::vector<render::Standpoint> standpoints_of(const RenderArguments& arguments) {
  if (!arguments.path.empty()) return walk_of(arguments.path);
  if (!arguments.eye.empty()) return {standpoint_of(arguments)};
  return {};
}

/// Puts the eyes above the ground, and scenery on it.
void prepare_walk(const RenderArguments& arguments,
                  std::vector<render::Standpoint>& standpoints,
                  render::Scene& scene) {
  if (standpoints.empty()) return;
  const auto [low, high] = render::GroundHeight(scene).bounds();
  // An eye outside of the plot stands on the extended ground.
  render::extend_ground(scene);
  const render::GroundHeight ground(scene);
  std::vector<render::Vector> places;
  for (render::Standpoint& one : standpoints) {
    const auto is_on_earth = [](double meters) { return std::abs(meters) <= 1e9; };
    if (!std::ranges::all_of(one.eye, is_on_earth)) {
      throw UsageError("the place of the eye must be three numbers of meters within 1e9");
    }
    const bool is_inside = one.eye[0] >= low[0] && one.eye[0] <= high[0] && one.eye[2] >= low[2] &&
                           one.eye[2] <= high[2];
    if (!is_inside) {
      say(arguments.common,
          fmt::format(
              "note: the place {:.1f},{:.1f} is outside of the scene, which reaches from {:.1f} "
              "to {:.1f} m east and from {:.1f} to {:.1f} m north of its origin",
              one.eye[0],
              -one.eye[2],
              low[0],
              high[0],
              -high[2],
              -low[2]));
    }
    if (one.eye[1] < 0.0) {
      throw UsageError(
          fmt::format("the height of the eye is {:g} m below the ground; UP is the "
                      "height above it",
                      -one.eye[1]));
    }
    one.eye[1] += ground.at(one.eye[0], one.eye[2]);
    places.push_back(one.eye);
  }
  if (!arguments.is_bare) {
    render::add_forest_floor(scene, ground, places, arguments.common.seed);
  }
}

std::size_t side_of(double value) {
  return value >= 1.0 && value <= 16384.0 ? static_cast<std::size_t>(value) : 0;
}

/// The image would be black.
void require_day(const render::SunPosition& sun, const std::string& option) {
  if (sun.elevation_deg >= 0.0) return;
  throw UsageError(fmt::format("the sun is {:.1f} degrees below the horizon, so the image would be "
                               "black; choose another time, or a sun above 0 degrees",
                               -sun.elevation_deg),
                   {.column = option});
}

render::SunPosition sun_of(const RenderArguments& arguments) {
  if (arguments.date.empty()) {
    const auto [azimuth, elevation] = pair_of(arguments.sun, ',', "--sun");
    const render::SunPosition sun{.azimuth_deg = azimuth, .elevation_deg = elevation};
    require_day(sun, "--sun");
    return sun;
  }
  if (arguments.place.empty()) {
    throw UsageError("--date needs --place LATITUDE,LONGITUDE to compute the position of the sun");
  }
  const auto [latitude, longitude] = pair_of(arguments.place, ',', "--place");
  const render::SunPosition sun =
      render::sun_over(latitude, longitude, render::parse_moment(arguments.date));
  require_day(sun, "--date");
  return sun;
}

render::RenderOptions options_of(const RenderArguments& arguments) {
  render::RenderOptions options = arguments.options;
  const auto [width, height] = pair_of(arguments.size, 'x', "--size");
  options.width = side_of(width);
  options.height = side_of(height);
  const auto [azimuth, elevation] = pair_of(arguments.camera, ',', "--camera");
  options.camera.azimuth_deg = azimuth;
  options.camera.elevation_deg = elevation;
  if (!arguments.target.empty()) options.camera.target = point_of(arguments.target, "--target");
  options.sun = sun_of(arguments);
  options.seed = arguments.common.seed;
  options.threads = arguments.common.threads;
  return options;
}

/// Refuses images that take days, and prints a note if an image takes minutes.
void check_work(const RenderArguments& arguments,
                const render::RenderOptions& options,
                std::size_t frames) {
  constexpr double kMostRays = 1e11;
  constexpr double kManyRays = 1e9;
  const std::size_t images = frames * arguments.models.size();
  const double rays = static_cast<double>(options.width) * static_cast<double>(options.height) *
                      static_cast<double>(options.samples) * static_cast<double>(images);
  if (rays > kMostRays) {
    throw UsageError(
        fmt::format("{} of {} x {} pixels with {} rays per pixel {} {:.2g} rays, and at most "
                    "{:.0g} can be traced in a day or so; reduce --size or --samples",
                    counted(images, "image", "images"),
                    options.width,
                    options.height,
                    options.samples,
                    images == 1 ? "needs" : "need",
                    rays,
                    kMostRays),
        {.column = "--samples"});
  }
  if (rays < kManyRays) return;
  say(arguments.common,
      fmt::format("note: {:.2g} rays are traced, about {:.0f} times as many as for an image of the "
                  "default size and samples; this may take minutes to hours",
                  rays,
                  rays / (1280.0 * 720.0 * 16.0)));
}

struct Drawn {
  std::vector<std::string> files{};
  std::size_t triangles = 0;
};

/// picture.png as picture-007.png.
std::string numbered(const std::string& out, std::size_t number) {
  const std::filesystem::path path(out);
  return (path.parent_path() /
          fmt::format("{}-{:03}{}", path.stem().string(), number, path.extension().string()))
      .string();
}

bool has_own_ground(const tree::ReadScene& scene) {
  return std::ranges::any_of(scene.models, [](const tree::ReadModel& model) {
    return std::ranges::any_of(model.parts,
                               [](const tree::ReadPart& part) { return part.part == "ground"; });
  });
}

Drawn draw(const RenderArguments& arguments) {
  render::RenderOptions options = options_of(arguments);
  const std::vector<render::Standpoint> standpoints = standpoints_of(arguments);
  const std::size_t frames = std::max(
      {std::size_t{1}, arguments.turntable, arguments.path.empty() ? 0 : standpoints.size()});
  const bool has_frames = arguments.turntable > 0 || !arguments.path.empty();
  check_work(arguments, options, frames);
  Progress progress(arguments.common);
  Drawn drawn;
  std::vector<render::Picture> pictures;
  const double first_azimuth = options.camera.azimuth_deg;
  for (const std::string& model : arguments.models) {
    const tree::ReadScene read = tree::read_scene(model);
    options.has_ground =
        !arguments.without_ground && !options.is_transparent && !has_own_ground(read);
    render::Scene scene = render::scene_of(read);
    std::vector<render::Standpoint> eyes = standpoints;
    prepare_walk(arguments, eyes, scene);
    const render::RayTracer tracer(scene);
    drawn.triangles += tracer.triangle_count();
    options.progress = [&](std::size_t done, std::size_t total) {
      progress.show(std::filesystem::path(model).filename().string(), done, total);
    };
    for (std::size_t frame = 0; frame < frames; ++frame) {
      options.camera.azimuth_deg =
          first_azimuth + 360.0 * static_cast<double>(frame) / static_cast<double>(frames);
      if (!eyes.empty()) options.camera.standpoint = eyes[eyes.size() > 1 ? frame : 0];
      const render::Picture picture = tracer.picture(options);
      if (has_frames) {
        drawn.files.push_back(numbered(arguments.out, frame));
        render::write_png(picture, drawn.files.back());
      } else {
        pictures.push_back(picture);
      }
    }
  }
  if (pictures.empty()) return drawn;
  const std::size_t columns = arguments.columns > 0 ? arguments.columns : pictures.size();
  render::write_png(render::contact_sheet(pictures, columns), arguments.out);
  drawn.files.push_back(arguments.out);
  return drawn;
}

void run(const RenderArguments& arguments) {
  if (arguments.turntable > 0 && arguments.models.size() > 1) {
    throw UsageError("--turntable needs a single model");
  }
  if (!arguments.path.empty() && arguments.models.size() > 1) {
    throw UsageError("--path needs a single model");
  }
  if (arguments.columns > 0 && arguments.models.size() < 2) {
    throw UsageError("--columns needs several models (contact sheet)");
  }
  const std::string ending = std::filesystem::path(arguments.out).extension().string();
  if (!ending.empty() && ending != ".png" && ending != ".PNG") {
    throw UsageError("--out must end in .png");
  }
  refuse_same_files(all_of("MODEL.glb", arguments.models), {{"--out", arguments.out}});
  const Drawn drawn = draw(arguments);
  if (arguments.common.json) {
    print_json_value({{"schema", "silvafit-render/1"},
                      {"silvafit", version()},
                      {"files", drawn.files},
                      {"triangles", drawn.triangles}});
  } else {
    say(arguments.common,
        fmt::format("{} triangles: {}", drawn.triangles, fmt::join(drawn.files, ", ")));
  }
}

void add_picture_options(CLI::App& command, RenderArguments& arguments) {
  command
      .add_option(
          "models", arguments.models, "GLB or glTF files; several files make a contact sheet")
      ->type_name("MODEL.glb")
      ->required();
  command.add_option("--out", arguments.out, "PNG file to write")
      ->type_name("FILE.png")
      ->required();
  command.add_option("--size", arguments.size, "Width and height of each image in pixels")
      ->type_name("WIDTHxHEIGHT")
      ->capture_default_str();
  command
      .add_option("--samples",
                  arguments.options.samples,
                  "Rays per pixel: more rays give less noise but take longer")
      ->capture_default_str();
  command
      .add_option("--turntable",
                  arguments.turntable,
                  "Number of images around the model: FILE-000.png, FILE-001.png, ...")
      ->check(CLI::Range(1, 10000))
      ->type_name("N");
  command
      .add_option("--columns", arguments.columns, "Columns of a contact sheet (default: one row)")
      ->check(CLI::Range(1, 10000))
      ->type_name("N");
  command.add_flag("--no-ground",
                   arguments.without_ground,
                   "No ground plane below models without a ground of their own");
  command.add_flag("--transparent",
                   arguments.options.is_transparent,
                   "No sky and no ground plane: the background of the image is transparent");
}

void add_camera_options(CLI::App& command, RenderArguments& arguments) {
  command
      .add_option("--camera",
                  arguments.camera,
                  "Position of the camera: azimuth from north, clockwise, and elevation [degrees]")
      ->type_name("AZIMUTH,ELEVATION")
      ->capture_default_str();
  command
      .add_option("--target",
                  arguments.target,
                  "Point in the middle of the image, in the model's coordinates [m]; by default "
                  "the model fills the image")
      ->type_name("EAST,NORTH,UP");
  command.add_option("--view",
                     arguments.options.camera.view_deg,
                     "Vertical field of view (35; walking 60) [degrees]");
  command
      .add_option("--zoom", arguments.options.camera.zoom, "Zoom factor; 2 is half the distance")
      ->capture_default_str();
}

/// \param command  with the other options, some of which do nothing on a walk
void add_walk_options(CLI::App& command, RenderArguments& arguments) {
  CLI::Option* const eye =
      command
          .add_option("--eye",
                      arguments.eye,
                      "Place of the eye, in the model's coordinates, and its height above the "
                      "ground there (default: 1.7) [m]: the view of a person who stands in the "
                      "forest, with a forest floor to the horizon and clouds")
          ->type_name("EAST,NORTH[,UP]");
  command
      .add_option("--look",
                  arguments.look,
                  "Azimuth of the view from there, clockwise from north, and elevation [degrees]")
      ->type_name("AZIMUTH[,ELEVATION]")
      ->needs(eye);
  CLI::Option* const path =
      command
          .add_option("--path",
                      arguments.path,
                      "Frames of a walk, FILE-000.png, FILE-001.png, ...: a table with the columns "
                      "east, north, azimuth, and up and elevation if wanted")
          ->type_name("VIEWS.csv")
          ->excludes(eye);
  command.add_flag("--bare",
                   arguments.is_bare,
                   "With --eye or --path: no litter, grass, herbs and fallen branches");
  for (const char* const other :
       {"--camera", "--target", "--zoom", "--turntable", "--no-ground", "--transparent"}) {
    command.get_option(other)->excludes(eye)->excludes(path);
  }
}

void add_sun_options(CLI::App& command, RenderArguments& arguments) {
  CLI::Option* const sun =
      command.add_option("--sun", arguments.sun, "Azimuth and elevation of the sun [degrees]")
          ->type_name("AZIMUTH,ELEVATION")
          ->capture_default_str();
  CLI::Option* const date = command
                                .add_option("--date",
                                            arguments.date,
                                            "Time for the position of the sun at --place, instead "
                                            "of --sun; UTC unless an offset is given")
                                ->type_name("2023-06-21T15:00+08:00")
                                ->excludes(sun);
  command.add_option("--place", arguments.place, "Latitude (north) and longitude (east) [degrees]")
      ->type_name("LATITUDE,LONGITUDE")
      ->needs(date);
}

}  // namespace

void add_render_command(CLI::App& program) {
  const auto arguments = std::make_shared<RenderArguments>();
  CLI::App& command =
      *program.add_subcommand("render", "Render images of models and stands by ray tracing");
  add_picture_options(command, *arguments);
  add_camera_options(command, *arguments);
  add_walk_options(command, *arguments);
  add_sun_options(command, *arguments);
  add_common_options(command, arguments->common);
  add_example(command, "silvafit render stand.glb --out stand.png --sun 240,30");
  command.callback([arguments, &command] {
    const bool walks = command.count("--eye") + command.count("--path") > 0;
    refuse_idle(command, "--bare", walks, "--eye or --path");
    if (walks && command.count("--view") == 0) arguments->options.camera.view_deg = kWalkingView;
    run(*arguments);
  });
}

}  // namespace silvafit::cli
