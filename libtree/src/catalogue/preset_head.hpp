// SPDX-License-Identifier: MIT
// The common fields of the files of models/. Errors name file and field.
#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <variant>
#include <vector>

#include "silvafit/data/json_reader.hpp"
#include "silvafit/tree/builder.hpp"

namespace silvafit::tree {

/// An entry of the catalogue with that schema.
data::JsonReader open_entry(const std::filesystem::path& file, std::string_view schema);

/// Reads the fields of all presets.
/// \param models  the folder with taper/ and bark/
void read_head(const std::filesystem::path& models,
               const data::JsonReader& entry,
               PresetHead& head);

/// The same if a file may have no fields but these and the builder's own.
/// \param others  the names of the builder's own fields
void read_head(const std::filesystem::path& models,
               const data::JsonReader& entry,
               std::vector<std::string_view> others,
               PresetHead& head);

/// The same with the fields of freely grown trees but the leaves.
/// \param models  with shoots/, too
void read_head(const std::filesystem::path& models,
               const data::JsonReader& entry,
               std::vector<std::string_view> others,
               FreePreset& preset);

/// Three numbers in [0, 1].
Color color_of(const data::JsonReader& entry);

/// An integer in [low, high].
int whole_number(const data::JsonReader& entry, int low, int high);

/// A number with its range, and where it goes; an int takes whole numbers only.
struct PresetNumber {
  std::string_view key{};
  std::variant<double*, int*> into{};
  double low = 0.0;
  double high = 0.0;
};

/// Reads the numbers of an object that has no keys but theirs and `others`.
void read_numbers(const data::JsonReader& entry,
                  const std::vector<PresetNumber>& numbers,
                  const std::vector<std::string_view>& others = {});

/// The same for numbers that may be absent.
void read_given_numbers(const data::JsonReader& entry,
                        const std::vector<PresetNumber>& numbers,
                        const std::vector<std::string_view>& others);

/// A leaf without an image: form (five-polygons or needle-fan), aspect, color, color_variation and
/// optionally outline.
/// \throws InputError naming file and field
LeafLook leaf_look_of(const data::JsonReader& entry);

template <std::size_t N>
std::array<double, N> numbers_of(const data::JsonReader& entry) {
  const std::vector<double> values = entry.numbers();
  if (values.size() != N) entry.fail("must have " + std::to_string(N) + " numbers");
  std::array<double, N> result{};
  std::ranges::copy(values, result.begin());
  return result;
}

/// A list of lists of N numbers.
template <std::size_t N>
std::vector<std::array<double, N>> rows_of(const data::JsonReader& entry) {
  std::vector<std::array<double, N>> rows;
  for (const data::JsonReader& row : entry.items()) rows.push_back(numbers_of<N>(row));
  return rows;
}

}  // namespace silvafit::tree
