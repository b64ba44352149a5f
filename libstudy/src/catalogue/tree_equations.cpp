// SPDX-License-Identifier: MIT
#include "silvafit/study/tree_equations.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/data/json_reader.hpp"

namespace silvafit::study {
namespace {

using data::JsonReader;

struct UnitFactor {
  std::string_view name;
  double factor;  ///< converts a value in this unit to ours
};

constexpr std::array<UnitFactor, 4> kDiameterUnits{
    {{"cm", 1.0}, {"mm", 0.1}, {"m", 100.0}, {"in", 2.54}}};
constexpr std::array<UnitFactor, 4> kLengthUnits{
    {{"m", 1.0}, {"cm", 0.01}, {"dm", 0.1}, {"ft", 0.3048}}};
constexpr std::array<UnitFactor, 4> kVolumeUnits{
    {{"m3", 1.0}, {"dm3", 0.001}, {"L", 0.001}, {"ft3", 0.028316846592}}};
constexpr std::array<UnitFactor, 4> kMassUnits{
    {{"kg", 1.0}, {"g", 0.001}, {"Mg", 1000.0}, {"lb", 0.45359237}}};

template <std::size_t Size>
std::optional<double> factor_of(const std::array<UnitFactor, Size>& units, std::string_view name) {
  const auto found = std::ranges::find(units, name, &UnitFactor::name);
  return found == units.end() ? std::nullopt : std::optional(found->factor);
}

bool is_length(const std::string& column) {
  return column == "h" || column == "hcb" || column == "cw";
}

/// The factor of a column's unit; 1 for columns that are not ours.
double column_factor(const JsonReader& json, const std::string& column) {
  const std::string unit = json.text();
  std::optional<double> factor = 1.0;
  if (column == "dbh") factor = factor_of(kDiameterUnits, unit);
  if (is_length(column)) factor = factor_of(kLengthUnits, unit);
  if (!factor) {
    json.fail(column == "dbh" ? "must be one of cm, mm, m, in" : "must be one of m, cm, dm, ft");
  }
  return *factor;
}

class EntryReader {
 public:
  EntryReader(const JsonReader& json, const JsonReader& set) : json_(json), set_(set) {}

  TreeEquation read();

 private:
  void read_units();
  void read_value();
  void read_domain();
  void read_points();
  double factor_of_column(const std::string& column) const {
    const auto found = column_factors_.find(column);
    return found == column_factors_.end() ? 1.0 : found->second;
  }

  const JsonReader& json_;
  const JsonReader& set_;
  std::map<std::string, double> column_factors_{};
  double value_factor_ = 1.0;
  TreeEquation equation_{};
};

void EntryReader::read_units() {
  const auto units = json_.has("units") ? json_.find("units") : set_.find("units");
  if (units) {
    for (const auto& [column, unit] : units->members()) {
      column_factors_[column] = column_factor(unit, column);
    }
  }
  const JsonReader unit = json_.at("unit");
  const std::string name = unit.text();
  if (const auto volume = factor_of(kVolumeUnits, name)) {
    equation_.unit = "m3";
    value_factor_ = *volume;
  } else if (const auto mass = factor_of(kMassUnits, name)) {
    equation_.unit = "kg";
    value_factor_ = *mass;
  } else {
    unit.fail("must be one of m3, dm3, L, ft3, kg, g, Mg, lb");
  }
}

void EntryReader::read_value() {
  const JsonReader formula = json_.at("formula");
  equation_.formula = formula.text();
  data::Expression value = formula.expression();
  if (const auto parameters = json_.find("parameters")) {
    for (const auto& [name, number] : parameters->members()) {
      value = value.substitute(name, data::Expression::constant(number.number()));
    }
  }
  for (const std::string& column : value.variables()) {
    const double factor = factor_of_column(column);
    if (factor == 1.0) continue;
    value = value.substitute(column, (1.0 / factor) * data::Expression::variable(column));
  }
  if (value.variables().empty()) formula.fail("uses no column, such as dbh");
  equation_.value = value_factor_ == 1.0 ? value : value_factor_ * value;
}

void EntryReader::read_domain() {
  const auto domain = json_.find("domain");
  if (!domain) return;
  for (const auto& [column, range] : domain->members()) {
    const std::vector<double> limits = range.numbers();
    if (limits.size() != 2 || limits[0] >= limits[1]) range.fail("must be [lowest, highest]");
    const double factor = factor_of_column(column);
    equation_.domain.push_back({column, limits[0] * factor, limits[1] * factor});
  }
}

void EntryReader::read_points() {
  const auto points = json_.find("reference_points");
  if (!points) return;
  for (const JsonReader& point : points->items()) {
    point.allow_only({"arguments", "value"});
    EquationPoint result{.arguments = point.at("arguments").numbers_by_name(),
                         .value = point.at("value").number() * value_factor_};
    for (auto& [column, value] : result.arguments) value *= factor_of_column(column);
    equation_.reference_points.push_back(std::move(result));
  }
}

TreeEquation EntryReader::read() {
  json_.allow_only({"id",
                    "title",
                    "quantity",
                    "unit",
                    "formula",
                    "parameters",
                    "units",
                    "species",
                    "region",
                    "domain",
                    "source",
                    "notes",
                    "reference_points"});
  equation_.id = json_.at("id").text();
  if (equation_.id == "taper" || equation_.id.find_first_of("=,") != std::string::npos) {
    json_.at("id").fail("must not be 'taper' and have no '=' or ','");
  }
  equation_.quantity = json_.at("quantity").text();
  const auto is_letter = [](unsigned char c) { return std::islower(c) != 0 || c == '_'; };
  if (!std::ranges::all_of(equation_.quantity, is_letter)) {
    json_.at("quantity").fail("must have small letters and _ only, such as stem_biomass");
  }
  if (const auto title = json_.find("title")) equation_.title = title->text();
  if (const auto species = json_.find("species")) equation_.species = species->texts();
  if (const auto region = json_.find("region")) equation_.region = region->text();
  if (const auto notes = json_.find("notes")) equation_.notes = notes->text();
  const auto source = json_.has("source") ? json_.find("source") : set_.find("source");
  if (!source) json_.fail("needs a source: author, year, journal, table");
  equation_.source = source->texts();
  equation_.file = json_.file();
  read_units();
  read_value();
  read_domain();
  read_points();
  return std::move(equation_);
}

}  // namespace

TreeEquations TreeEquations::load(const std::filesystem::path& models) {
  TreeEquations result;
  for (const auto& file : files_in_folder(models / "equations", ".json")) result.add(file);
  return result;
}

void TreeEquations::add(const std::filesystem::path& file) {
  const JsonReader json = JsonReader::open(file);
  json.allow_only({"schema", "title", "source", "units", "equations"});
  if (json.at("schema").text() != "silvafit-tree-equations/1") {
    json.at("schema").fail("must be silvafit-tree-equations/1");
  }
  for (const JsonReader& entry : json.at("equations").items()) {
    TreeEquation equation = EntryReader(entry, json).read();
    const auto found = std::ranges::find(equations_, equation.id, &TreeEquation::id);
    if (found != equations_.end()) {
      if (found->file == equation.file) entry.at("id").fail("is used twice");
      *found = std::move(equation);
    } else {
      equations_.push_back(std::move(equation));
    }
  }
}

const TreeEquation& TreeEquations::find(std::string_view id) const {
  const auto found = std::ranges::find(equations_, id, &TreeEquation::id);
  if (found != equations_.end()) return *found;
  std::vector<std::string> names{"taper"};
  for (const TreeEquation& equation : equations_) names.push_back(equation.id);
  throw UsageError(fmt::format("unknown equation '{}'; available: {}", id, data::list_of(names)),
                   {.column = "`equations`"});
}

}  // namespace silvafit::study
