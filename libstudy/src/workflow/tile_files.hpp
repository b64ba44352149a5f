// SPDX-License-Identifier: MIT
// The files of tiles: their rows, and results with a first line that identifies them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/study/tiles.hpp"

namespace silvafit::study {

std::filesystem::path plan_file(const std::filesystem::path& folder);
std::filesystem::path tile_file(const std::filesystem::path& folder, const Tile& tile);
std::filesystem::path result_file(const std::filesystem::path& folder,
                                  const std::string& command,
                                  const Tile& tile);

/// The header of a tile's file: two columns, then those of the inventory.
std::string tile_header(const data::TableHead& head, char separator);

/// The rows of a tile, with their lines in the inventory.
struct TileRows {
  std::shared_ptr<const data::TableText> table{};
  std::vector<std::size_t> own{};  ///< lines of the tile's own rows, ascending

  bool is_own(std::size_t line) const;
};

/// \param only_own  leaves out the rows of the halo
/// \throws InputError if the file cannot be read or is not that of the plan
TileRows read_tile(const std::filesystem::path& folder,
                   const TilePlan& plan,
                   std::size_t tile,
                   bool only_own);

/// The content of a result's first line.
struct ResultHead {
  std::string key{};  ///< fingerprint of plan, command and settings
  std::size_t trees = 0;
  std::size_t marked = 0;
  double halo_m = 0.0;
  std::string content{};  ///< fingerprint of the rest of the file, and of its scenes

  std::string text() const;
};

/// The first line of a result; none if there is no such file, or it is no result.
std::optional<ResultHead> read_result_head(const std::filesystem::path& file);

/// Whether the rest of a result, and the scenes in its folder that it names, are as its head says.
bool is_whole_result(const std::filesystem::path& file, const ResultHead& head);

/// Collects the rows of a result and writes them.
class ResultRows {
 public:
  void set_header(std::string_view header) { header_ = header; }
  void add(std::size_t line, std::string_view record);
  /// A row whose values are unknown.
  void add_marked(std::size_t line, std::string_view record);
  void need_halo(double width_m);
  /// The number of trees, where it is not that of the rows.
  void set_trees(std::size_t trees) { head_.trees = trees; }
  /// A file of the result in its folder, by its name.
  void add_file(const std::string& name) { files_.push_back(name); }

  TileResult write(const std::filesystem::path& file, const std::string& key) const;

 private:
  void append(std::size_t line, std::string_view record, char mark);

  std::string header_{};
  std::string rows_{};
  std::vector<std::string> files_{};
  ResultHead head_{};
};

/// Yields the rows of a result: header (line 0), then all in their order.
void read_result(
    const std::filesystem::path& file,
    const std::function<void(std::size_t line, bool is_marked, std::string_view record)>& sink);

}  // namespace silvafit::study
