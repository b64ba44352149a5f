// SPDX-License-Identifier: MIT
#include "silvafit/study/site_index.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/data/json_reader.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::study {
namespace {

SiteCurve read_site_curve(const std::filesystem::path& file) {
  const data::JsonReader json = data::JsonReader::open(file);
  json.allow_only({"schema",
                   "id",
                   "title",
                   "species",
                   "source",
                   "where",
                   "formula",
                   "base_age",
                   "ages",
                   "reference_points"});
  SiteCurve curve{.id = json.at("id").text(),
                  .title = json.at("title").text(),
                  .species = json.at("species").texts(),
                  .source = json.at("source").texts(),
                  .height = json.at("formula").expression(),
                  .base_age = json.at("base_age").positive()};
  // Later definitions use earlier ones.
  auto definitions = json.has("where") ? json.at("where").members()
                                       : std::vector<std::pair<std::string, data::JsonReader>>();
  std::ranges::reverse(definitions);
  for (const auto& [name, value] : definitions) {
    curve.height = curve.height.substitute(name, value.expression());
  }
  for (const std::string& name : curve.height.variables()) {
    if (name == "h" || name == "age" || name == "age2") continue;
    json.at("formula").fail(fmt::format("unknown '{}'; a curve reads h, age and age2", name));
  }
  const std::vector<double> ages = json.at("ages").numbers();
  if (ages.size() != 2 || !(ages[0] < ages[1]))
    json.at("ages").fail("needs the lowest and highest age");
  for (const data::JsonReader& point : json.at("reference_points").items()) {
    curve.reference_points.push_back(
        {point.at("h").positive(), point.at("age").positive(), point.at("site_index").positive()});
  }
  curve.lowest_age = ages[0];
  curve.highest_age = ages[1];
  return curve;
}

}  // namespace

double SiteCurve::height_at(double age2, double h_m, double age) const {
  if (!(h_m > 0.0) || !(age > 0.0)) return data::kMissing;
  return height.value({"h", "age", "age2"}, {h_m, age, age2});
}

std::vector<SiteCurve> load_site_curves(const std::filesystem::path& models) {
  std::vector<SiteCurve> curves;
  for (const auto& file : files_in_folder(models / "site_index", ".json")) {
    curves.push_back(read_site_curve(file));
  }
  return curves;
}

const SiteCurve& site_curve(const std::vector<SiteCurve>& curves, const std::string& id) {
  const auto found = std::ranges::find(curves, id, &SiteCurve::id);
  if (found != curves.end()) return *found;
  std::vector<std::string> names;
  for (const SiteCurve& curve : curves) names.push_back(curve.id + " (" + curve.title + ")");
  throw UsageError(fmt::format("unknown curve {}; available: {}", id, fmt::join(names, ", ")),
                   {.column = "`site_index`"});
}

}  // namespace silvafit::study
