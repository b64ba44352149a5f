// SPDX-License-Identifier: MIT
// Structural units as CSV.
#include <cmath>
#include <ostream>
#include <string>

#include "silvafit/data/csv.hpp"
#include "silvafit/stand/structural_units.hpp"

namespace silvafit::stand {
namespace {

void append_number(std::string& out, double value) {
  out += ',';
  if (!std::isnan(value)) out += data::shortest(value);
}

/// Writes rows, with the labels of neighbors.
class UnitWriter {
 public:
  UnitWriter(const Inventory& inventory,
             const StructuralUnits& units,
             std::optional<bool> ids_repeat)
      : inventory_(inventory),
        units_(units),
        needs_plot_(units.scope == SearchScope::kStand &&
                    ids_repeat.value_or(inventory.tree.levels().size() < inventory.size())) {}

  void append_row(std::string& out, std::size_t row) const;

 private:
  void append_neighbor(std::string& out, std::uint32_t neighbor) const;

  const Inventory& inventory_;
  const StructuralUnits& units_;
  bool needs_plot_;
};

void UnitWriter::append_neighbor(std::string& out, std::uint32_t neighbor) const {
  out += ',';
  if (neighbor == kNoTree) return;
  std::string name(inventory_.tree[neighbor]);
  if (needs_plot_) name = std::string(inventory_.plot[neighbor]) + "-" + name;
  out += data::csv_field(name);
}

void UnitWriter::append_row(std::string& out, std::size_t row) const {
  out += data::csv_field(inventory_.plot[row]);
  out += ',' + data::csv_field(inventory_.tree[row]);
  out += ',' + data::csv_field(inventory_.species[row]);
  out += units_.core[row] != 0 ? ",1" : ",0";
  append_number(out, units_.W[row]);
  append_number(out, units_.M[row]);
  append_number(out, units_.U[row]);
  append_number(out, units_.C.empty() ? data::kMissing : units_.C[row]);
  const std::size_t first = row * units_.neighbors;
  for (std::size_t i = 0; i < units_.neighbors; ++i)
    append_neighbor(out, units_.nearest[first + i]);
  for (std::size_t i = 0; i < units_.neighbors; ++i) {
    append_number(out, units_.distance_m[first + i]);
  }
  if (!units_.weight.empty()) append_number(out, units_.weight_of(row));
  for (const FurtherValues& further : units_.further) append_number(out, further.values[row]);
  out += '\n';
}

}  // namespace

std::string header_of_units(const StructuralUnits& units) {
  std::string header = "plot,tree,species,core,W,M,U,C";
  for (const char* prefix : {",nn", ",d"}) {
    for (std::size_t i = 1; i <= units.neighbors; ++i) header += prefix + std::to_string(i);
  }
  if (!units.weight.empty()) header += ",weight";
  for (const FurtherValues& further : units.further) header += "," + word_of(further.index);
  return header + '\n';
}

void write_structural_units(const Inventory& inventory,
                            const StructuralUnits& units,
                            const UnitRowSink& sink,
                            std::optional<bool> ids_repeat) {
  const UnitWriter writer(inventory, units, ids_repeat);
  std::string out;
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    out.clear();
    writer.append_row(out, row);
    sink(row, out);
  }
}

void write_structural_units(const Inventory& inventory,
                            const StructuralUnits& units,
                            std::ostream& stream,
                            bool with_header) {
  if (with_header) stream << header_of_units(units);
  write_structural_units(
      inventory, units, [&stream](std::size_t /*tree*/, std::string_view row) { stream << row; });
}

}  // namespace silvafit::stand
