// SPDX-License-Identifier: MIT
#include "inventory_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::cli {
namespace {

double number_in(std::string_view text, const std::string& option, std::string_view what) {
  double value = 0.0;
  if (data::parse_number(data::trimmed(text), value)) return value;
  throw UsageError(fmt::format("'{}' is not {}", text, what), {.column = option});
}

void set_limit_angles(const std::vector<std::string>& alpha,
                      stand::StructuralUnitOptions& options) {
  constexpr std::string_view kWhat = "an angle in degrees, or SPECIES=ANGLE";
  for (const std::string& part : alpha) {
    const std::size_t sign = part.rfind('=');
    if (sign == std::string::npos) {
      options.alpha0_deg = number_in(part, "--alpha", kWhat);
    } else {
      options.alpha0_deg_of_species.emplace_back(
          part.substr(0, sign), number_in(part.substr(sign + 1), "--alpha", kWhat));
    }
  }
}

/// A circle that every plot has, in its own coordinates.
stand::NamedWindow circle_of_every_plot(const std::string& text) {
  constexpr std::string_view kWhat = "X,Y,RADIUS in m, such as 0,0,12.62";
  std::vector<double> numbers;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    numbers.push_back(
        number_in(std::string_view(text).substr(begin, end - begin), "--circle", kWhat));
    begin = end + 1;
  }
  if (numbers.size() != 3) {
    throw UsageError(fmt::format("'{}' is not {}", text, kWhat), {.column = "--circle"});
  }
  return {.plot = stand::kEveryPlot,
          .window = stand::Window::circle({numbers[0], numbers[1]}, numbers[2])};
}

void add_window_options(CLI::App& command, UnitArguments& arguments) {
  command
      .add_option("--edge",
                  arguments.edge,
                  "Edge correction: buffer (trees near the boundary are neighbors only), hanisch "
                  "(core trees are those whose neighbors are nearer than the boundary, with "
                  "weights), torus (opposite sides are joined) or none")
      ->check(CLI::IsMember({"buffer", "hanisch", "torus", "none"}))
      ->capture_default_str();
  command.add_option("--buffer", arguments.buffer_m, "Width of the buffer in m")
      ->capture_default_str();
  CLI::Option* window =
      command
          .add_option(
              "--window",
              arguments.window,
              "Area of the inventory in m: GeoJSON, WKT, or CSV with plot and wkt, or plot, "
              "x, y and radius (default: the convex hull of the trees)")
          ->type_name("FILE");
  command
      .add_option("--circle",
                  arguments.circle,
                  "The boundary of every plot is this circle, in coordinates of the plot, such as "
                  "0,0,12.62")
      ->type_name("X,Y,RADIUS")
      ->excludes(window);
  command
      .add_option("--per", arguments.per, "Search neighbors within each plot or the whole stand")
      ->check(CLI::IsMember({"plot", "stand"}))
      ->capture_default_str();
}

}  // namespace

void add_inventory_options(CLI::App& command, InventoryArguments& arguments) {
  command.add_option("inventory", arguments.path, "Inventory: a CSV file with one row per tree")
      ->type_name("INVENTORY.csv")
      ->required();
  command
      .add_option("--columns",
                  arguments.columns,
                  "Names or formulas of the columns, such as dbh=DBH_cm,h=Height,x=xk/10")
      ->type_name("NAME=COLUMN,...")
      ->allow_extra_args(false);
  add_trust_units_option(command, arguments.trust_units);
  add_sheet_options(command, arguments.sheet);
  add_dead_option(command, arguments.sheet);
}

void add_unit_options(CLI::App& command, UnitArguments& arguments) {
  command
      .add_option("--neighbors", arguments.neighbors, "Number of neighbors in a structural unit")
      ->capture_default_str();
  command
      .add_option(
          "--alpha",
          arguments.alpha,
          "Limit angle of W in degrees (default: 360 / (neighbors + 1)), for single species "
          "as in 72,SM=60")
      ->delimiter(',')
      ->type_name("ANGLE,SPECIES=ANGLE,...");
  add_window_options(command, arguments);
  command.add_option("--dominance", arguments.dominance, "Size that U and T compare: dbh, h or cw")
      ->check(CLI::IsMember({"dbh", "h", "cw"}))
      ->capture_default_str();
  command
      .add_option("--crowding",
                  arguments.crowding,
                  "Crowns in C: mean (half of cw) or facing (radii towards each other)")
      ->check(CLI::IsMember({"mean", "facing"}))
      ->capture_default_str();
  command
      .add_option(
          "--further",
          arguments.further,
          "Further indices: CO crown overlap, T size differentiation, Hegyi, BAL basal area "
          "of larger trees, CCF crown competition factor; or all")
      ->delimiter(',')
      ->type_name("INDEX,...");
  command
      .add_option("--competition-radius",
                  arguments.competition_radius_m,
                  "Hegyi: competitors are the trees within this radius in m (default: the "
                  "neighbors)")
      ->type_name("M");
  command
      .add_option("--open-grown",
                  arguments.open_grown,
                  "CCF: crown width in m of an open-grown tree, such as \"0.9 + 0.22*dbh\"")
      ->type_name("EXPRESSION");
}

std::vector<stand::FurtherIndex> further_indices(const UnitArguments& arguments) {
  std::vector<stand::FurtherIndex> indices;
  for (const std::string& name : arguments.further) {
    if (name == "all") {
      for (const stand::FurtherIndex index : stand::all_further_indices()) {
        const bool needs_crowns = index == stand::FurtherIndex::kCrownCompetition;
        if (!needs_crowns || !arguments.open_grown.empty()) indices.push_back(index);
      }
      continue;
    }
    const std::optional<stand::FurtherIndex> index = stand::further_index_named(name);
    if (!index) {
      throw UsageError(fmt::format("'{}' is not one of CO, T, Hegyi, BAL, CCF, all", name),
                       {.column = "--further"});
    }
    indices.push_back(*index);
  }
  return indices;
}

void refuse_idle_unit_options(const CLI::App& command,
                              const UnitArguments& arguments,
                              const std::vector<stand::FurtherIndex>& further) {
  const auto is_made = [&further](stand::FurtherIndex index) {
    return std::ranges::find(further, index) != further.end();
  };
  refuse_idle(command, "--buffer", arguments.edge == "buffer", "--edge buffer");
  refuse_idle(
      command, "--competition-radius", is_made(stand::FurtherIndex::kHegyi), "--further Hegyi");
  refuse_idle(
      command, "--open-grown", is_made(stand::FurtherIndex::kCrownCompetition), "--further CCF");
}

stand::InventoryOptions reading_options(const InventoryArguments& arguments,
                                        stand::InventoryOptions options) {
  options.columns =
      stand::parse_column_mappings(fmt::format("{}", fmt::join(arguments.columns, ",")));
  options.trust_units = arguments.trust_units;
  options.missing = arguments.sheet.missing;
  options.fill_down = arguments.sheet.fill_down;
  options.dead = dead_trees(arguments.sheet);
  options.case_sensitive = arguments.sheet.case_sensitive;
  return options;
}

stand::CheckedInventory read_inventory(const InventoryArguments& arguments,
                                       stand::InventoryOptions options,
                                       const CommonOptions& common) {
  stand::CheckedInventory checked =
      stand::read_inventory(arguments.path, reading_options(arguments, std::move(options)));
  for (const std::string& note : checked.notes) say(common, "note: " + note);
  const std::string excluded = stand::describe_excluded(checked);
  if (!excluded.empty()) say(common, "note: " + excluded);
  return checked;
}

std::vector<stand::NamedWindow> given_windows(const UnitArguments& arguments) {
  if (!arguments.circle.empty()) return {circle_of_every_plot(arguments.circle)};
  if (!arguments.window.empty()) return stand::read_windows(arguments.window);
  return {};
}

UnitArguments unit_arguments(const study::UnitSettings& settings) {
  UnitArguments arguments;
  const auto take = [](const auto& said, auto& value) {
    if (said) value = *said;
  };
  take(settings.per, arguments.per);
  take(settings.neighbors, arguments.neighbors);
  take(settings.alpha, arguments.alpha);
  take(settings.dominance, arguments.dominance);
  take(settings.crowding, arguments.crowding);
  take(settings.competition_radius_m, arguments.competition_radius_m);
  take(settings.open_grown, arguments.open_grown);
  return arguments;
}

stand::StructuralUnitOptions unit_options(const UnitArguments& arguments,
                                          const CommonOptions& common) {
  static const std::map<std::string, stand::EdgeCorrection> kEdges{
      {"buffer", stand::EdgeCorrection::kBuffer},
      {"hanisch", stand::EdgeCorrection::kHanisch},
      {"torus", stand::EdgeCorrection::kTorus},
      {"none", stand::EdgeCorrection::kNone}};
  static const std::map<std::string, stand::SizeMeasure> kSizes{
      {"dbh", stand::SizeMeasure::kDbh},
      {"h", stand::SizeMeasure::kHeight},
      {"cw", stand::SizeMeasure::kCrownWidth}};
  stand::StructuralUnitOptions options{
      .neighbors = arguments.neighbors,
      .edge = kEdges.at(arguments.edge),
      .buffer_m = arguments.buffer_m,
      .scope = arguments.per == "stand" ? stand::SearchScope::kStand : stand::SearchScope::kPlot,
      .windows = given_windows(arguments),
      .size = kSizes.at(arguments.dominance),
      .reach = arguments.crowding == "facing" ? stand::CrownReach::kFacingRadii
                                              : stand::CrownReach::kMeanWidth,
      .further = further_indices(arguments),
      .competition_radius_m = arguments.competition_radius_m,
      .open_grown_crown = arguments.open_grown,
      .threads = common.threads};
  set_limit_angles(arguments.alpha, options);
  return options;
}

}  // namespace silvafit::cli
