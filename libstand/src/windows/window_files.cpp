// SPDX-License-Identifier: MIT
// Detects the format of a window file; functions shared by all formats.
#include "windows/window_files.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <string_view>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/words.hpp"

namespace silvafit::stand {
namespace {

constexpr char kTwoWindows[] =
    "this plot already has a window; a circle cannot be combined with another window";

}  // namespace

std::string text_of(const std::filesystem::path& path) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  std::string text = read_file(path);
  if (text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
  return text;
}

WindowCollector::Owner& WindowCollector::owner(const std::optional<std::string>& plot) {
  const auto [entry, is_new] = number_of_.try_emplace(plot, owners_.size());
  if (is_new) owners_.push_back({.plot = plot});
  return owners_[entry->second];
}

void WindowCollector::add(const std::optional<std::string>& plot,
                          const std::vector<Polygon>& polygons) {
  for (const Polygon& polygon : polygons) Window({polygon});
  Owner& target = owner(plot);
  if (target.circle) throw GeometryError(kTwoWindows);
  std::ranges::copy(polygons, std::back_inserter(target.polygons));
}

void WindowCollector::add_circle(const std::optional<std::string>& plot,
                                 Point center,
                                 double radius_m) {
  Owner& target = owner(plot);
  if (target.circle || !target.polygons.empty()) throw GeometryError(kTwoWindows);
  target.circle = Window::circle(center, radius_m);
}

std::vector<NamedWindow> WindowCollector::windows(const std::string& file) const {
  if (owners_.empty()) throw InputError("the file contains no window", {.file = file});
  std::vector<NamedWindow> windows;
  for (const Owner& source : owners_) {
    windows.push_back(
        {.plot = source.plot, .window = source.circle ? *source.circle : Window(source.polygons)});
  }
  return windows;
}

std::vector<NamedWindow> read_windows(const std::filesystem::path& path) {
  const std::string ending = in_lower_case(path.extension().string());
  if (ending == ".csv") return read_csv_windows(path);
  if (ending == ".wkt") return read_wkt_windows(path);
  // For any file ending: JSON begins with a brace, well-known text with a word.
  const std::string text = text_of(path);
  const auto first =
      std::ranges::find_if(text, [](unsigned char c) { return std::isspace(c) == 0; });
  const bool is_word = first != text.end() && std::isalpha(static_cast<unsigned char>(*first)) != 0;
  return is_word ? read_wkt_windows(path) : read_geojson_windows(path);
}

}  // namespace silvafit::stand
