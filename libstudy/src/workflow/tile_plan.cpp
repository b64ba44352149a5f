// SPDX-License-Identifier: MIT
// Cutting of an inventory into tiles.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/external_sort.hpp"
#include "silvafit/base/fingerprint.hpp"
#include "silvafit/data/json_reader.hpp"
#include "silvafit/data/table_parts.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/prepared_table.hpp"
#include "silvafit/stand/species_spellings.hpp"
#include "silvafit/study/setting_list.hpp"
#include "study/settings_json.hpp"
#include "workflow/tile_files.hpp"

namespace silvafit::study {
namespace {

constexpr const char* kSchema = "silvafit-tiles/1";

using nlohmann::ordered_json;

/// Numbers of tiles are unsigned 32-bit values with column and row 0 in the middle.
constexpr std::int64_t kMiddleCell = std::int64_t{1} << 31;

std::uint64_t number_of(std::int64_t column, std::int64_t row) {
  return (static_cast<std::uint64_t>(row + kMiddleCell) << 32U) |
         static_cast<std::uint64_t>(column + kMiddleCell);
}

std::uint64_t hash_of(std::string_view text) {
  Fingerprint hash;
  hash.add(text);
  return hash.value();
}

/// The convex hull of points that are added in parts; few are stored.
class GrowingHull {
 public:
  void add(stand::Point point) {
    constexpr std::size_t kMost = 100000;
    points_.push_back(point);
    if (points_.size() >= most_) {
      reduce();
      most_ = points_.size() + kMost;
    }
  }

  std::vector<stand::Point> vertices() { return reduce() ? points_ : std::vector<stand::Point>(); }

 private:
  /// False if all points are on one line.
  bool reduce() {
    const auto hull = stand::Window::convex_hull(points_);
    if (!hull) return false;
    points_ = hull->outline().front().outer;
    return true;
  }

  std::vector<stand::Point> points_{};
  std::size_t most_ = 100000;
};

/// Finds repeated ids of trees.
class TreeIds {
 public:
  void add(std::string_view plot, std::string_view tree, std::size_t line) {
    const std::uint64_t place = line;
    ids_.add({hash_of(tree), hash_of(plot)}, {reinterpret_cast<const char*>(&place), sizeof place});
  }

  /// Whether trees of several plots have one id.
  /// \throws InputError if trees of one plot do
  bool repeat(const std::string& file) {
    ExternalSort::Key key;
    ExternalSort::Key before;
    std::string record;
    std::uint64_t line = 0;
    bool repeats = false;
    for (bool is_first = true; ids_.next(key, record); is_first = false) {
      std::uint64_t own = 0;
      record.copy(reinterpret_cast<char*>(&own), sizeof own);
      if (!is_first && key == before) {
        throw InputError(
            fmt::format(
                "the tree is on line {}, too; tiles need numbers of trees that are unique in "
                "a plot, and one measurement of each tree",
                line),
            {.file = file, .line = own});
      }
      repeats = repeats || (!is_first && key.first == before.first);
      before = key;
      line = own;
    }
    return repeats;
  }

 private:
  ExternalSort ids_{};
};

/// The fingerprint of the content of a plan.
std::string fingerprint_of_plan(TilePlan plan) {
  plan.fingerprint = {};
  return fingerprint(json_of(plan).dump());
}

class Planner {
 public:
  Planner(const std::filesystem::path& inventory,
          const TileSettings& settings,
          const std::filesystem::path& folder,
          const Callbacks& callbacks)
      : inventory_(inventory), folder_(folder), callbacks_(callbacks) {
    check(settings);
    plan_.inventory = inventory.string();
    plan_.settings = settings;
  }

  TilePlan run() {
    const ResultFolder result(folder_);
    remove_earlier_plan();
    read();
    write_tiles();
    // Both were applied to the whole inventory.
    plan_.settings.reading.trust_units = true;
    plan_.where = std::exchange(plan_.settings.reading.rows.where, {});
    plan_.version = SILVAFIT_VERSION;
    plan_.fingerprint = fingerprint_of_plan(plan_);
    write_file(plan_file(folder_), json_of(plan_).dump(2) + "\n");
    return std::move(plan_);
  }

 private:
  static void check(const TileSettings& settings) {
    if (!(settings.size_m > 0.0) || !std::isfinite(settings.size_m)) {
      throw UsageError("the size of a tile must be positive", {.column = "`size`"});
    }
    // A tree is copied to (2 halo / size + 1)^2 tiles, here 441.
    constexpr double kMostTimes = 10.0;
    if (!(settings.halo_m >= 0.0) || !(settings.halo_m <= kMostTimes * settings.size_m)) {
      throw UsageError(
          fmt::format("the halo must be from 0 to {} times the size of a tile, as each "
                      "tree is copied to all tiles whose halo it is in",
                      kMostTimes),
          {.column = "`halo`"});
    }
  }

  std::int64_t cell(double coordinate) const {
    const double number = std::floor(coordinate / plan_.settings.size_m);
    constexpr double kMost = 2e9;
    if (std::abs(number) > kMost) {
      throw UsageError("there are too many tiles between the trees; make larger ones",
                       {.column = "`size`"});
    }
    return static_cast<std::int64_t>(number);
  }

  /// The existence of a plan implies that of all its tiles, and of no others.
  void remove_earlier_plan() const {
    if (!std::filesystem::exists(plan_file(folder_))) return;
    for (const Tile& tile : read_tile_plan(folder_).tiles) {
      std::filesystem::remove(tile_file(folder_, tile));
    }
    std::filesystem::remove(plan_file(folder_));
  }

  void read();
  void add_tree(const stand::Inventory& trees,
                std::size_t tree,
                std::size_t line,
                std::string_view record);
  void add_row(std::uint64_t tile, std::size_t line, bool is_own, std::string_view record);
  void write_tiles();
  void unify(const stand::Inventory& part);
  std::vector<std::size_t> chosen_lines(const std::shared_ptr<const data::TableText>& rows) const;
  void add_batch(const std::shared_ptr<const data::TableText>& rows, const stand::Inventory& trees);

  const std::filesystem::path& inventory_;
  const std::filesystem::path& folder_;
  const Callbacks& callbacks_;
  TilePlan plan_{};
  ExternalSort rows_{};
  GrowingHull hull_{};
  TreeIds ids_{};
  stand::SpeciesSpellings spellings_{};
  std::string first_plot_{};
  std::optional<std::uint64_t> last_{};                         ///< tile of the last tree
  std::vector<std::pair<std::size_t, std::string>> waiting_{};  ///< rows above the first tree
};

void Planner::add_row(std::uint64_t tile, std::size_t line, bool is_own, std::string_view record) {
  const char separator = plan_.separator;
  rows_.add({tile, line},
            fmt::format("{}{}{}{}{}", line, separator, is_own ? 1 : 0, separator, record));
}

void Planner::add_tree(const stand::Inventory& trees,
                       std::size_t tree,
                       std::size_t line,
                       std::string_view record) {
  const stand::Point at{trees.x[tree], trees.y[tree]};
  if (plan_.trees++ == 0) {
    plan_.low = plan_.high = at;
    first_plot_ = trees.plot[tree];
  }
  plan_.low = {std::min(plan_.low.x, at.x), std::min(plan_.low.y, at.y)};
  plan_.high = {std::max(plan_.high.x, at.x), std::max(plan_.high.y, at.y)};
  plan_.has_plots = plan_.has_plots || trees.plot[tree] != first_plot_;
  hull_.add(at);
  ids_.add(trees.plot[tree], trees.tree[tree], line);
  const double halo_m = plan_.settings.halo_m;
  const std::uint64_t own = number_of(cell(at.x), cell(at.y));
  for (std::int64_t row = cell(at.y - halo_m); row <= cell(at.y + halo_m); ++row) {
    for (std::int64_t column = cell(at.x - halo_m); column <= cell(at.x + halo_m); ++column) {
      const std::uint64_t tile = number_of(column, row);
      add_row(tile, line, tile == own, record);
    }
  }
}

void Planner::read() {
  const ReadingSettings& reading = plan_.settings.reading;
  stand::InventoryBatches batches(inventory_,
                                  inventory_options(reading, {.needs_coordinates = true}),
                                  data::TablePartsOptions{}.rows,
                                  stand::BatchOf::kRows,
                                  1,
                                  callbacks_.note);
  if (!batches.has_numbers()) {
    throw InputError("tiles need a column with numbers of trees, such as `columns=tree=ID`",
                     {.file = plan_.inventory});
  }
  const std::size_t rows = batches.row_count();
  std::size_t done = 0;
  while (const auto batch = batches.next()) {
    plan_.separator = batches.rows()->separator;
    plan_.head = *batches.rows()->head;
    unify(batch->inventory);
    add_batch(batches.rows(), batch->inventory);
    done += batches.rows()->lines.size();
    if (callbacks_.progress) callbacks_.progress("cutting", done, rows);
  }
  plan_.ids_repeat = ids_.repeat(plan_.inventory);
  plan_.hull = hull_.vertices();
}

/// The lines of the rows that satisfy the condition for rows.
std::vector<std::size_t> Planner::chosen_lines(
    const std::shared_ptr<const data::TableText>& rows) const {
  const ReadingSettings& reading = plan_.settings.reading;
  if (reading.rows.where.empty()) return rows->lines;
  const auto chosen = stand::prepared_table(rows, inventory_options(reading), true).table;
  return std::get<std::shared_ptr<const data::TableText>>(chosen)->lines;
}

/// Rows without a usable tree are in the tile of the tree above them.
void Planner::add_batch(const std::shared_ptr<const data::TableText>& rows,
                        const stand::Inventory& trees) {
  data::CsvReader reader{data::TableSource(rows)};
  const std::vector<std::size_t> chosen = chosen_lines(rows);
  plan_.rows += chosen.size();
  std::vector<std::string_view> fields;
  std::string record;
  std::size_t tree = 0;
  auto next = chosen.begin();
  while (reader.next(fields)) {
    const std::size_t line = reader.line();
    if (next == chosen.end() || *next != line) continue;
    ++next;
    record.clear();
    data::append_record(fields, plan_.separator, record);
    if (tree < trees.size() && trees.lines[tree] == line) {
      last_ = number_of(cell(trees.x[tree]), cell(trees.y[tree]));
      for (const auto& [number, above] : waiting_) add_row(*last_, number, true, above);
      waiting_.clear();
      add_tree(trees, tree++, line, record);
    } else if (last_) {
      add_row(*last_, line, true, record);
    } else {
      waiting_.emplace_back(line, record);
    }
  }
}

/// Spellings are unified in the whole inventory, which is unknown to a tile.
void Planner::unify(const stand::Inventory& part) {
  if (plan_.settings.reading.case_sensitive) return;
  data::TextColumn species = part.species;
  spellings_.unify(species);
  const std::string note = spellings_.note();
  if (note.empty()) return;
  throw InputError(note + "; tiles need one spelling for each species",
                   {.file = plan_.inventory, .column = "species"});
}

void Planner::write_tiles() {
  ExternalSort::Key key;
  std::string record;
  std::optional<AtomicFile> file;
  std::uint64_t open = 0;
  Fingerprint rows;
  const std::string header = tile_header(plan_.head, plan_.separator);
  const std::string own_mark{plan_.separator, '1', plan_.separator};
  const auto finish = [&] {
    if (!file) return;
    file->commit();
    file.reset();
    plan_.tiles.back().fingerprint = rows.text();
    rows = {};
    // A tile with a halo only has nothing to compute.
    if (plan_.tiles.back().trees > 0) return;
    std::filesystem::remove(tile_file(folder_, plan_.tiles.back()));
    plan_.tiles.pop_back();
  };
  while (rows_.next(key, record)) {
    if (!file || key.first != open) {
      finish();
      open = key.first;
      plan_.tiles.push_back({.column = static_cast<std::int64_t>(open & 0xffffffffU) - kMiddleCell,
                             .row = static_cast<std::int64_t>(open >> 32U) - kMiddleCell});
      file.emplace(tile_file(folder_, plan_.tiles.back()));
      file->stream() << header;
    }
    const bool is_own = record.compare(record.find(plan_.separator), 3, own_mark) == 0;
    ++(is_own ? plan_.tiles.back().trees : plan_.tiles.back().neighbors);
    file->stream() << record;
    rows.add(record);
  }
  finish();
}

std::vector<std::string> texts_of(const nlohmann::json& list) {
  return list.get<std::vector<std::string>>();
}

/// The head of the inventory; none if it is not one that json_of writes.
std::optional<data::TableHead> head_in(const nlohmann::json& json) {
  data::TableHead head;
  head.header = texts_of(json.at("header"));
  head.layout.units = texts_of(json.at("units"));
  for (const int kind : json.at("kinds")) {
    if (kind < 0 || kind > static_cast<int>(data::ColumnKind::kText)) return std::nullopt;
    head.kinds.push_back(static_cast<data::ColumnKind>(kind));
  }
  if (head.kinds.size() != head.header.size()) return std::nullopt;
  return head;
}

/// Reads the plan of a file; false if it is not one that json_of writes.
/// \throws nlohmann::json::exception likewise
bool read_plan(const nlohmann::json& json, TilePlan& plan) {
  const auto point = [](const nlohmann::json& pair) {
    return stand::Point{pair.at(0).get<double>(), pair.at(1).get<double>()};
  };
  const auto head = head_in(json);
  const std::string separator = json.at("separator");
  if (json.at("schema") != kSchema || !head || separator.size() != 1) return false;
  plan.inventory = json.at("inventory");
  plan.head = *head;
  plan.separator = separator.front();
  plan.version = json.at("silvafit");
  plan.settings.size_m = json.at("size_m");
  plan.settings.halo_m = json.at("halo_m");
  each_setting(plan.settings.reading,
               SettingsReader(data::JsonReader::parse(json.at("reading").dump(), ""), {}));
  plan.where = json.at("where");
  plan.rows = json.at("rows");
  plan.trees = json.at("trees");
  plan.has_plots = json.at("has_plots");
  plan.ids_repeat = json.at("ids_repeat");
  plan.low = point(json.at("low"));
  plan.high = point(json.at("high"));
  for (const nlohmann::json& vertex : json.at("hull")) plan.hull.push_back(point(vertex));
  for (const nlohmann::json& tile : json.at("tiles")) {
    plan.tiles.push_back({.column = tile.at("column"),
                          .row = tile.at("row"),
                          .trees = tile.at("trees"),
                          .neighbors = tile.at("halo"),
                          .fingerprint = tile.at("fingerprint")});
  }
  plan.fingerprint = json.at("fingerprint");
  return true;
}

}  // namespace

std::string Tile::name() const {
  const auto side = [](char positive, char negative, std::int64_t number) {
    return fmt::format("{}{}", number < 0 ? negative : positive, number < 0 ? -number : number);
  };
  return side('e', 'w', column) + side('n', 's', row);
}

TilePlan plan_tiles(const std::filesystem::path& inventory,
                    const TileSettings& settings,
                    const std::filesystem::path& folder,
                    const Callbacks& callbacks) {
  return Planner(inventory, settings, folder, callbacks).run();
}

ordered_json json_of(const TilePlan& plan) {
  ordered_json kinds = ordered_json::array();
  for (const data::ColumnKind kind : plan.head.kinds) kinds.push_back(static_cast<int>(kind));
  ordered_json hull = ordered_json::array();
  for (const stand::Point& point : plan.hull) hull.push_back({point.x, point.y});
  ordered_json tiles = ordered_json::array();
  for (const Tile& tile : plan.tiles) {
    tiles.push_back({{"name", tile.name()},
                     {"column", tile.column},
                     {"row", tile.row},
                     {"trees", tile.trees},
                     {"halo", tile.neighbors},
                     {"fingerprint", tile.fingerprint}});
  }
  return {{"schema", kSchema},
          {"silvafit", plan.version},
          {"inventory", plan.inventory},
          {"size_m", plan.settings.size_m},
          {"halo_m", plan.settings.halo_m},
          {"reading", settings_json(plan.settings.reading)},
          {"where", plan.where},
          {"header", plan.head.header},
          {"units", plan.head.layout.units},
          {"kinds", std::move(kinds)},
          {"separator", std::string(1, plan.separator)},
          {"rows", plan.rows},
          {"trees", plan.trees},
          {"has_plots", plan.has_plots},
          {"ids_repeat", plan.ids_repeat},
          {"low", {plan.low.x, plan.low.y}},
          {"high", {plan.high.x, plan.high.y}},
          {"hull", std::move(hull)},
          {"tiles", std::move(tiles)},
          {"fingerprint", plan.fingerprint}};
}

TilePlan read_tile_plan(const std::filesystem::path& folder) {
  const std::filesystem::path file = plan_file(folder);
  if (!std::filesystem::exists(file)) {
    throw InputError("no plan of tiles; make one with `silvafit tiles plan`",
                     {.file = file.string()});
  }
  TilePlan plan;
  bool is_plan = false;
  try {
    is_plan = read_plan(nlohmann::json::parse(read_file(file, kAnySize)), plan);
  } catch (const std::exception&) {
    is_plan = false;
  }
  if (!is_plan || plan.fingerprint != fingerprint_of_plan(plan)) {
    throw InputError("is not a plan of tiles, or is damaged; cut the inventory again",
                     {.file = file.string()});
  }
  return plan;
}

}  // namespace silvafit::study
