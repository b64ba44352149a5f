// SPDX-License-Identifier: MIT
#include "silvafit/study/analyses.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "fronts/call.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/base/near_names.hpp"
#include "silvafit/study/analysis_setting_list.hpp"

namespace silvafit::study {
namespace {

using data::JsonReader;
using nlohmann::ordered_json;

/// Puts texts, and lists of texts, into words.
void put_words(ordered_json& json, Front front) {
  if (json.is_string()) json = with_setting_names(json.get_ref<const std::string&>(), front);
  if (json.is_array()) {
    for (ordered_json& item : json) put_words(item, front);
  }
}

void put_sentences(ordered_json& json, Front front) {
  static constexpr std::array<std::string_view, 4> kSentences{
      "verdict", "doubts", "reason", "sentences"};
  if (!json.is_structured()) return;
  for (auto& [key, value] : json.items()) {
    const bool is_sentence =
        json.is_object() && std::ranges::find(kSentences, key) != kSentences.end();
    is_sentence ? put_words(value, front) : put_sentences(value, front);
  }
}

/// An argument is named as a setting is, by the key without the places within its value.
[[noreturn]] void refuse_argument(const Error& error) {
  const std::string& key = error.place().column;
  throw UsageError(error.message(), {.column = "`" + key.substr(0, key.find_first_of(".[")) + "`"});
}

using Read = AnalysisWork (*)(AnalysisCall&);

const std::map<std::string_view, Read, std::less<>>& reads() {
  static const std::map<std::string_view, Read, std::less<>> all{
      {"structural_units", &structural_units_work},
      {"stand_summary", &stand_summary_work},
      {"stand_growth", &stand_growth_work},
      {"impute", &impute_work},
      {"predict_library", &predict_library_work},
      {"study", &study_work},
      {"grow", &grow_work},
      {"view", &view_work},
      {"fit", &fit_work},
      {"predict", &predict_work},
      {"intervals", &intervals_work},
      {"bootstrap", &bootstrap_work},
      {"cross_validate", &cross_validate_work},
      {"compare", &compare_work},
      {"simulate", &simulate_work},
      {"residuals", &residuals_work},
      {"covariance", &covariance_work},
      {"term_tests", &term_tests_work},
      {"calibrate", &calibrate_work}};
  return all;
}

}  // namespace

AnalysisCall::AnalysisCall(AnalysisInput input)
    : input_(std::move(input)),
      reader_(SettingsReader::of_call(JsonReader::parse(input_.arguments, ""))) {}

std::size_t AnalysisCall::count(const JsonReader& json) {
  constexpr double kLargest = 0x1p53;  // larger whole numbers are no exact doubles
  const double value = json.number_between(0.0, kLargest);
  if (value != std::floor(value)) json.fail("must be a whole number of 0 or more");
  return static_cast<std::size_t>(value);
}

std::string AnalysisCall::text(std::string_view key) {
  const auto json = find(key);
  return json ? json->any_text() : std::string();
}

bool AnalysisCall::truth(std::string_view key) {
  const auto json = find(key);
  return json && json->boolean();
}

void AnalysisCall::read_names(std::string_view key, std::vector<std::string>& names) {
  if (const auto json = find(key)) {
    names = json->is_list() ? json->texts() : std::vector{json->any_text()};
  }
}

std::size_t AnalysisCall::number(std::string_view key, std::size_t otherwise) {
  const auto json = find(key);
  return json ? count(*json) : otherwise;
}

void AnalysisCall::complete(UnitSettings& units) {
  const auto windows = find("windows");
  if (!windows) return;
  data::TextColumn wkt;
  for (const std::string& text : windows->at("wkt").texts()) wkt.append(text);
  auto table = std::make_shared<data::Table>(wkt.size());
  table->set("wkt", std::move(wkt));
  if (const auto plots = windows->find("plot")) {
    data::TextColumn labels;
    for (const JsonReader& plot : plots->items()) {
      plot.is_null() ? labels.append_missing() : labels.append(plot.label());
    }
    table->set("plot", std::move(labels));
  }
  units.windows = stand::windows_of_table(std::shared_ptr<const data::Table>(std::move(table)));
}

void AnalysisCall::complete(SamplingSettings& sampling) const {
  if (!input_.plots) return;
  sampling.plots = input_.plots;
  auto* const table = std::get_if<std::shared_ptr<const data::Table>>(&*sampling.plots);
  if (table == nullptr) return;
  // Fronts name rows of data without a file by the index of the trees.
  auto named = std::make_shared<data::Table>(**table);
  named->set_origin("plots", {});
  *table = std::move(named);
}

UnitSettings AnalysisCall::units() {
  auto settings = read<UnitSettings>();
  complete(settings);
  return settings;
}

SamplingSettings AnalysisCall::sampling() {
  auto settings = read<SamplingSettings>();
  complete(settings);
  return settings;
}

EquationSettings AnalysisCall::equations() {
  auto settings = read<EquationSettings>();
  settings.models = input_.data_folder / "models";
  return settings;
}

const data::TableSource& AnalysisCall::table() const { return input_.table.value(); }

const fit::FittedModel& AnalysisCall::fit() const { return *input_.fits.at(0); }

std::shared_ptr<const Catalogue> AnalysisCall::catalogue() const {
  if (input_.catalogue != nullptr) return {std::shared_ptr<const Catalogue>(), input_.catalogue};
  return std::make_shared<const Catalogue>(Catalogue::load(input_.data_folder / "models"));
}

void AnalysisCall::finish() const {
  // The front passes others itself.
  std::set<std::string, std::less<>> known(others_.begin(), others_.end());
  known.insert(reader_.keys().begin(), reader_.keys().end());
  for (const auto& [name, value] : JsonReader::parse(input_.arguments, "").members()) {
    if (known.contains(name)) continue;
    std::vector<std::string> shown = reader_.keys();
    for (const char* const own : {"threads", "seed"}) {
      if (std::ranges::find(others_, own) != others_.end()) shown.emplace_back(own);
    }
    throw UsageError("unknown argument" + did_you_mean(name, shown), {.column = name});
  }
}

std::string in_words(ordered_json json, Front front) {
  put_sentences(json, front);
  return json_text(json);
}

AnalysisWork prepare_analysis(std::string_view name, AnalysisInput input) {
  AnalysisCall call(std::move(input));
  try {
    AnalysisWork work = reads().at(name)(call);
    call.finish();
    return work;
  } catch (const InputError& error) {
    // Files name themselves; what is left are arguments.
    if (!error.place().file.empty()) throw;
    refuse_argument(error);
  }
}

}  // namespace silvafit::study
