// SPDX-License-Identifier: MIT
#include "silvafit/study/grow.hpp"

#include <fmt/format.h>

#include <chrono>
#include <optional>
#include <utility>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/study/tree_table.hpp"
#include "silvafit/tree/coinciding_plots.hpp"
#include "silvafit/tree/lsystem_builder.hpp"
#include "workflow/grow_job.hpp"

namespace silvafit::study {
namespace {

/// All trees of the table at one time, or the trees of each moment.
tree::Moments read_trees(const data::TableSource& trees, const GrowJob& job) {
  tree::MorphologyTableOptions options{.use = tree::use_from_text(job.use),
                                       .plots = job.plots,
                                       .needs_position = !job.scene.empty() || job.resolve_overlaps,
                                       .only_height = job.is_unfitted};
  const data::Table table =
      read_tree_table(trees, job.reading, job.by, options.columns, job.callbacks.note).table;
  if (!job.by.empty()) return tree::read_moments(table, job.by, options);
  tree::MorphologyTable read = tree::read_morphologies(table, options);
  tree::Moments one{.left_out = std::move(read.left_out)};
  if (!read.morphologies.empty()) one.moments.push_back({.trees = std::move(read.morphologies)});
  return one;
}

/// The preset of the L-system builder with the user's grammar; null if none is given.
std::unique_ptr<const tree::Builder> builder_with_grammar(const tree::BuilderCatalogue& catalogue,
                                                          const GrowJob& job) {
  if (job.grammar.empty()) return nullptr;
  const tree::Builder& looks = job.preset.empty() ? catalogue.fallback(job.builder)
                                                  : catalogue.named(job.builder, job.preset);
  return dynamic_cast<const tree::LsystemBuilder&>(looks).with_grammar(
      tree::Grammar::load(job.grammar));
}

/// A note on plots that cover each other at one of the moments; empty if none do.
std::string note_on_coinciding_plots(const GrowJob& job, const std::vector<tree::Moment>& moments) {
  if (job.scene.empty() && !job.resolve_overlaps) return {};
  for (const tree::Moment& moment : moments) {
    const auto plots = tree::coinciding_plots(moment.trees);
    if (!plots) continue;
    return fmt::format(
        "plots {0} and {1} cover each other, probably because each has its own "
        "coordinate system; grow one plot at a time (--plot {0}), or give x and y "
        "of all plots in one system",
        plots->first,
        plots->second);
  }
  return {};
}

void append(GrowResult&& part, const std::string& moment, std::size_t before, GrowResult& all) {
  for (GrownTree& tree : part.trees) {
    tree.moment = moment;
    all.trees.push_back(std::move(tree));
  }
  for (tree::PairOverlap& pair : part.pairs) {
    pair.weaker += before;
    pair.stronger += before;
    all.pairs.push_back(pair);
  }
  all.presets.insert(all.presets.end(), part.presets.begin(), part.presets.end());
  all.files.insert(all.files.end(), part.files.begin(), part.files.end());
  all.shared = std::move(part.shared);
  for (const std::size_t tree : part.with_guesses) all.with_guesses.push_back(before + tree);
  for (const std::size_t tree : part.crossing) all.crossing.push_back(before + tree);
}

GrowResult grow_moments(const GrowJob& job,
                        const std::vector<tree::Moment>& moments,
                        const tree::BuilderCatalogue& catalogue) {
  std::vector<tree::Morphology> stand;
  for (const tree::Moment& moment : moments) {
    stand.insert(stand.end(), moment.trees.begin(), moment.trees.end());
  }
  const std::unique_ptr<const tree::Builder> with_grammar = builder_with_grammar(catalogue, job);
  if (job.animate) {
    GrowResult all = write_animation(job, moments, stand, catalogue, with_grammar.get());
    all.morphologies = std::move(stand);
    return all;
  }
  GrowResult all;
  std::size_t before = 0;
  for (const tree::Moment& moment : moments) {
    GrowJob one = job.by.empty() ? job : of_moment(job, moment);
    // Notes about species would be repeated.
    if (before > 0) one.callbacks.note = {};
    append(grow_trees(one, moment.trees, stand, catalogue, with_grammar.get()),
           moment.name,
           before,
           all);
    before += moment.trees.size();
  }
  all.morphologies = std::move(stand);
  return all;
}

}  // namespace

GrowResult grow(const data::TableSource& trees,
                const tree::BuilderCatalogue& catalogue,
                const GrowSettings& settings,
                const Callbacks& callbacks) {
  const auto start = std::chrono::steady_clock::now();
  const GrowJob job = grow_job(settings, data::file_of(trees), callbacks);
  tree::Moments table = read_trees(trees, job);
  give_notes(notes_on(table.left_out), callbacks.note);
  if (table.moments.empty()) {
    if (job.is_part) return {.settings = job, .left_out = std::move(table.left_out)};
    throw InputError("no row can be used to grow a tree", {.file = job.file});
  }
  const std::string coinciding = note_on_coinciding_plots(job, table.moments);
  if (!coinciding.empty() && callbacks.note) callbacks.note(coinciding);
  std::optional<ResultFolder> folder;
  if (!job.out.empty()) folder.emplace(job.out);
  GrowResult result = grow_moments(job, table.moments, catalogue);
  // A builder with a grammar is gone.
  for (tree::SharedModel& model : result.shared.models) model.builder = nullptr;
  result.settings = job;
  result.moments = table.moments.size();
  result.left_out = std::move(table.left_out);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  result.seconds = seconds.count();
  return result;
}

std::vector<std::string> notes_on(const std::vector<tree::LeftOut>& left_out) {
  constexpr std::size_t kShown = 20;
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < left_out.size() && i < kShown; ++i) {
    notes.push_back(describe(left_out[i].place, left_out[i].reason + "; the row is skipped"));
  }
  if (left_out.size() > kShown) {
    notes.push_back(fmt::format("... and {} skipped",
                                counted(left_out.size() - kShown, "more row is", "more rows are")));
  }
  return notes;
}

}  // namespace silvafit::study
