// SPDX-License-Identifier: MIT
#include "workflow/tile_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>
#include <utility>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/fingerprint.hpp"
#include "silvafit/base/io_error.hpp"
#include "silvafit/data/table_parts.hpp"

namespace silvafit::study {
namespace {

namespace fs = std::filesystem;

constexpr char kResultMark[] = "# silvafit tile";

/// A number at the beginning of a text, and what follows it and a separator.
std::pair<std::size_t, std::string_view> take_number(std::string_view text) {
  std::size_t value = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  const auto used = static_cast<std::size_t>(end - text.data());
  return {value, text.substr(std::min(used + 1, text.size()))};
}

/// Adds a file to a fingerprint; false if it cannot be read.
bool add_file_to(Fingerprint& hash, const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::vector<char> block(std::size_t{1} << 20U);
  while (stream) {
    stream.read(block.data(), static_cast<std::streamsize>(block.size()));
    hash.add({block.data(), static_cast<std::size_t>(stream.gcount())});
  }
  return stream.eof();
}

/// The fingerprint of the rows of a result, its tile, and its files; nothing if one cannot be read.
std::optional<std::string> fingerprint_of_content(const fs::path& result,
                                                  std::string_view rows,
                                                  const std::vector<std::string>& files) {
  Fingerprint hash;
  hash.add(rows);
  hash.add(result.stem().string());
  for (const std::string& name : files) {
    if (!add_file_to(hash, result.parent_path() / name)) return std::nullopt;
  }
  return hash.text();
}

/// The names of a result's files: its second line, which is empty for a result without files.
std::vector<std::string> files_in(std::string_view line) {
  std::vector<std::string> names;
  while (!line.empty()) {
    const std::size_t end = std::min(line.find('\t'), line.size());
    names.emplace_back(line.substr(0, end));
    line.remove_prefix(std::min(end + 1, line.size()));
  }
  return names;
}

/// Takes a line from the beginning of a text, without its end.
std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

}  // namespace

fs::path plan_file(const fs::path& folder) { return folder / "plan.json"; }

fs::path tile_file(const fs::path& folder, const Tile& tile) {
  return folder / "tiles" / (tile.name() + ".csv");
}

fs::path result_file(const fs::path& folder, const std::string& command, const Tile& tile) {
  return folder / command / (tile.name() + ".csv");
}

std::string tile_header(const data::TableHead& head, char separator) {
  std::vector<std::string_view> names{"line", "own"};
  names.insert(names.end(), head.header.begin(), head.header.end());
  std::string record;
  data::append_record(names, separator, record);
  return record;
}

bool TileRows::is_own(std::size_t line) const { return std::ranges::binary_search(own, line); }

TileRows read_tile(const fs::path& folder, const TilePlan& plan, std::size_t tile, bool only_own) {
  const fs::path file = tile_file(folder, plan.tiles[tile]);
  std::string bytes = read_file(file, kAnySize);
  const std::string header = tile_header(plan.head, plan.separator);
  if (!bytes.starts_with(header)) {
    throw InputError("the columns are not those of the plan; cut the inventory again",
                     {.file = file.string()});
  }
  auto whole = std::make_shared<data::TableText>();
  auto head = std::make_shared<data::TableHead>();
  head->header = {"line", "own"};
  for (std::size_t i = 0; i < plan.head.header.size(); ++i) {
    head->header.push_back("column" + std::to_string(i));
  }
  if (fingerprint(std::string_view(bytes).substr(header.size())) != plan.tiles[tile].fingerprint) {
    throw InputError("the rows are not those of the plan; cut the inventory again",
                     {.file = file.string()});
  }
  whole->name = file.string();
  whole->separator = plan.separator;
  whole->text = bytes.substr(header.size());
  whole->head = head;
  // The reader needs the line of each record; there are not more records than line ends.
  whole->lines.resize(static_cast<std::size_t>(std::ranges::count(whole->text, '\n')) + 1);
  bytes = {};
  TileRows rows;
  auto table = std::make_shared<data::TableText>();
  table->name = plan.inventory;
  table->separator = plan.separator;
  table->head = std::make_shared<data::TableHead>(plan.head);
  data::CsvReader reader{data::TableSource(std::shared_ptr<const data::TableText>(whole))};
  std::vector<std::string_view> fields;
  while (reader.next(fields)) {
    const std::size_t line = take_number(fields[0]).first;
    const bool is_own = fields[1] == "1";
    if (is_own) rows.own.push_back(line);
    if (only_own && !is_own) continue;
    table->lines.push_back(line);
    fields.erase(fields.begin(), fields.begin() + 2);
    data::append_record(fields, plan.separator, table->text);
  }
  rows.table = std::move(table);
  return rows;
}

std::string ResultHead::text() const {
  return fmt::format("{} {} {} {} {} {}\n", kResultMark, key, trees, marked, halo_m, content);
}

std::optional<ResultHead> read_result_head(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string line;
  if (!std::getline(stream, line) || !line.starts_with(kResultMark)) return std::nullopt;
  std::istringstream words(line.substr(sizeof kResultMark));
  ResultHead head;
  std::string halo;
  words >> head.key >> head.trees >> head.marked >> halo >> head.content;
  if (!words || !data::parse_number(halo, head.halo_m)) return std::nullopt;
  return head;
}

bool is_whole_result(const fs::path& file, const ResultHead& head) {
  const std::string bytes = read_file(file, kAnySize);
  std::string_view rest = bytes;
  take_line(rest);
  const std::string_view content = rest;
  return fingerprint_of_content(file, content, files_in(take_line(rest))) == head.content;
}

void ResultRows::append(std::size_t line, std::string_view record, char mark) {
  rows_ += std::to_string(line);
  rows_ += mark;
  rows_ += std::to_string(record.size());
  rows_ += ' ';
  rows_ += record;
  ++head_.trees;
}

void ResultRows::add(std::size_t line, std::string_view record) { append(line, record, ' '); }

void ResultRows::add_marked(std::size_t line, std::string_view record) {
  append(line, record, '*');
  ++head_.marked;
}

void ResultRows::need_halo(double width_m) { head_.halo_m = std::max(head_.halo_m, width_m); }

TileResult ResultRows::write(const fs::path& file, const std::string& key) const {
  ResultHead head = head_;
  head.key = key;
  std::string content;
  for (const std::string& name : files_) content += (content.empty() ? "" : "\t") + name;
  content += '\n' + header_ + rows_;
  const auto hash = fingerprint_of_content(file, content, files_);
  if (!hash) throw IoError("a file of the tile was removed", {.file = file.string()});
  head.content = *hash;
  write_file(file, head.text() + content);
  return {.file = file.string(), .trees = head.trees, .marked = head.marked, .halo_m = head.halo_m};
}

void read_result(
    const fs::path& file,
    const std::function<void(std::size_t line, bool is_marked, std::string_view record)>& sink) {
  const std::string bytes = read_file(file, kAnySize);
  std::string_view rest = bytes;
  take_line(rest);
  take_line(rest);
  const std::size_t header = rest.find('\n') + 1;
  sink(0, false, rest.substr(0, header));
  rest.remove_prefix(header);
  while (!rest.empty()) {
    const auto [line, after_line] = take_number(rest);
    const bool is_marked = *(after_line.data() - 1) == '*';
    const auto [size, record] = take_number(after_line);
    if (record.size() < size) {
      throw InputError("the file is damaged; delete it and run its tile again",
                       {.file = file.string()});
    }
    sink(line, is_marked, record.substr(0, size));
    rest = record.substr(size);
  }
}

}  // namespace silvafit::study
