// SPDX-License-Identifier: MIT
#include "silvafit/study/indices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/stand/stand_json.hpp"
#include "silvafit/study/setting_list.hpp"
#include "silvafit/study/study_files.hpp"
#include "study/settings_json.hpp"
#include "workflow/flow.hpp"

namespace silvafit::study {
namespace {

using nlohmann::ordered_json;
/// Computes the units of an inventory or of its batches, and collects notes and counts.
class IndicesRun {
 public:
  IndicesRun(const data::TableSource& source,
             const IndicesOptions& options,
             const UnitSink& sink,
             const Callbacks& callbacks)
      : source_(source),
        settings_(options),
        options_(unit_options(options.units, options.threads)),
        design_(sampling_design(options.sampling)),
        sink_(sink),
        callbacks_(callbacks) {
    result_.inventory = data::file_of(source);
    result_.settings = options.units;
    result_.further = options_.further;
    std::ranges::sort(result_.further);
    // Not std::ranges::unique, because clang 14 does not support structured bindings of its result.
    result_.further.erase(std::unique(result_.further.begin(), result_.further.end()),
                          result_.further.end());
  }

  IndicesSummary run() {
    const auto start = Clock::now();
    read();
    note(stand::notes_of(findings_, options_, result_.inventory));
    note_on_core_trees();
    result_.seconds = seconds_since(start);
    return std::move(result_);
  }

 private:
  void note(const std::vector<std::string>& notes) {
    result_.notes.insert(result_.notes.end(), notes.begin(), notes.end());
    give_notes(notes, callbacks_.note);
  }

  /// Passes the units of one inventory or batch to the callback, and sums them up.
  void take(stand::CheckedInventory& checked) {
    result_.excluded_trees += checked.excluded_tree_count;
    stand::StructuralUnits units;
    if (checked.inventory.size() > 0) {
      const auto start = Clock::now();
      units = units_of(checked.inventory);
      result_.seconds_units += seconds_since(start);
      findings_.add(units.findings);
      result_.alpha0_deg = units.alpha0_deg;
      result_.summaries.add(checked.inventory, units);
    }
    sink_(checked, units);
  }

  stand::StructuralUnits units_of(const stand::Inventory& inventory) {
    const stand::SamplingDesign design =
        options_.windows.empty() ? stand::design_for(inventory, design_) : design_;
    if (!design.is_given()) return stand::structural_units(inventory, options_);
    const stand::DesignedSample sample = stand::sample_of(inventory, design);
    note(sample.notes);
    // For the notes on the units.
    options_.sampled = sample.areas;
    return stand::structural_units_of_sample(inventory, sample, options_);
  }

  void read() {
    const bool is_in_parts = settings_.stream;
    if (is_in_parts && design_.is_given()) {
      throw UsageError("`stream` cannot be combined with a sampling design; omit one of them",
                       {.column = "`stream`"});
    }
    if (is_in_parts && options_.scope == stand::SearchScope::kStand) {
      throw UsageError("`stream` cannot search neighbors across plots; use `per=plot`",
                       {.column = "`stream`"});
    }
    stand::InventoryBatches flow =
        inventory_flow(source_,
                       settings_.reading,
                       {.keep = columns_of(settings_.sampling),
                        .needs_coordinates = true,
                        .has_expansion = !settings_.sampling.expansion.empty(),
                        .keeps_expansion = !is_in_parts},
                       {.is_in_parts = is_in_parts, .threads = settings_.threads},
                       callbacks_.note);
    options_.is_part = is_in_parts;
    std::size_t trees = 0;
    while (auto part = flow.next()) {
      trees += part->inventory.size();
      take(*part);
      if (is_in_parts && callbacks_.progress) {
        callbacks_.progress(fmt::format("{} trees", trees), 0, 1);
      }
    }
    const std::vector<std::string> notes = flow.notes();
    result_.notes.insert(result_.notes.begin(), notes.begin(), notes.end());
    result_.recognized = flow.recognized();
    std::vector<std::string> species;
    for (const auto& summary : result_.summaries.by_species()) species.push_back(summary.species);
    std::erase(species, "");
    stand::check_species_of_angles(options_, species, result_.inventory);
  }

  void note_on_core_trees() const {
    const stand::UnitSummary all = result_.summaries.all();
    if (all.core_trees == all.trees || !callbacks_.note) return;
    callbacks_.note(fmt::format(
        "{} of {} trees are core trees; {} are near the boundary or have no structural unit",
        all.core_trees,
        all.trees,
        all.trees - all.core_trees));
  }

  const data::TableSource& source_;
  const IndicesOptions& settings_;
  stand::StructuralUnitOptions options_;
  stand::SamplingDesign design_;
  const UnitSink& sink_;
  const Callbacks& callbacks_;
  /// Of all parts of the inventory; its notes are made at the end.
  stand::UnitFindings findings_{};
  IndicesSummary result_{};
};

}  // namespace

ordered_json json_of(const IndicesSummary& summary) {
  ordered_json species = ordered_json::object();
  for (const auto& one : summary.summaries.by_species()) {
    species[one.species] = stand::json_of(one, summary.further);
  }
  const UnitSettings& settings = summary.settings;
  const ordered_json words = settings_json(settings);
  return {{"schema", "silvafit-indices/1"},
          {"silvafit", SILVAFIT_VERSION},
          {"inventory", summary.inventory},
          {"excluded", summary.excluded_trees},
          {"neighbors", settings.neighbors},
          {"alpha_deg", summary.alpha0_deg},
          {"edge", words["edge"]},
          {"buffer_m",
           settings.edge == stand::EdgeCorrection::kBuffer ? ordered_json(settings.buffer_m)
                                                           : ordered_json(nullptr)},
          {"per", words["per"]},
          {"all", stand::json_of(summary.summaries.all(), summary.further)},
          {"species", std::move(species)},
          {"recognized", summary.recognized},
          {"notes", summary.notes},
          {"seconds", summary.seconds},
          {"seconds_units", summary.seconds_units}};
}

IndicesSummary compute_indices(const data::TableSource& inventory,
                               const IndicesOptions& options,
                               const UnitSink& sink,
                               const Callbacks& callbacks) {
  refuse_idle(options);
  return IndicesRun(inventory, options, sink, callbacks).run();
}

void refuse_idle(const IndicesOptions& options, const GivenName& given_name) {
  refuse_idle_settings(options.units, given_name);
  refuse_idle_settings(options.sampling, given_name);
}

data::Table TreeIndices::table() const { return inventory_table(inventory.inventory, units); }

TreeIndices tree_indices(const data::TableSource& inventory,
                         const IndicesOptions& options,
                         const Callbacks& callbacks) {
  if (options.stream) {
    throw UsageError("this function needs all trees in memory; use compute_indices",
                     {.column = "`stream`"});
  }
  TreeIndices result;
  const UnitSink sink = [&result](stand::CheckedInventory& trees, stand::StructuralUnits& units) {
    result.inventory = std::move(trees);
    result.units = std::move(units);
  };
  result.summary = compute_indices(inventory, options, sink, callbacks);
  return result;
}

stand::CheckedInventory read_inventory(const data::TableSource& inventory,
                                       const ReadingSettings& settings,
                                       const stand::InventoryOptions& options,
                                       const NoteCallback& note) {
  return std::move(*inventory_flow(inventory, settings, options, {}, note).next());
}

}  // namespace silvafit::study
