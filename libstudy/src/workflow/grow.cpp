// SPDX-License-Identifier: MIT
#include "silvafit/study/grow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/study/tree_table.hpp"
#include "silvafit/tree/coinciding_plots.hpp"
#include "silvafit/tree/lsystem_builder.hpp"
#include "workflow/assumed_sizes.hpp"
#include "workflow/grow_job.hpp"
#include "workflow/grow_manifest.hpp"

namespace silvafit::study {
namespace {

struct ReadTrees {
  tree::Moments moments{};
  std::vector<std::size_t> lines{};  ///< of the trees, without moments
};

/// All trees of the table at one time, or the trees of each moment or plot.
ReadTrees read_trees(const data::TableSource& trees, const GrowJob& job) {
  tree::MorphologyTableOptions options = morphology_options(job);
  data::Table table =
      read_tree_table(trees, job.reading, job.by, options.columns, job.callbacks.note).table;
  assume_labels(table, options.columns);
  if (options.use == tree::Use::kObserved && !options.only_height) {
    const std::string note = assume_sizes(table, options.columns);
    if (!note.empty() && job.callbacks.note) job.callbacks.note(note);
  }
  if (!job.by.empty()) return {.moments = tree::read_moments(table, job.by, options)};
  tree::MorphologyTable read = tree::read_morphologies(table, options);
  ReadTrees result{.moments = {.left_out = std::move(read.left_out)}};
  if (read.morphologies.empty()) return result;
  if (!job.manifest.empty()) result.lines = lines_of(table, options.columns, read.morphologies);
  if (job.per == "plot") {
    result.moments.moments = plots_of(std::move(read.morphologies), result.lines);
  } else {
    result.moments.moments.push_back({.trees = std::move(read.morphologies)});
  }
  return result;
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
        "coordinate system; grow one plot at a time, such as {0}, or give x and y "
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
  for (const auto& [name, count] : part.counts.guesses) all.counts.guesses[name] += count;
  for (const std::size_t tree : part.with_guesses) all.with_guesses.push_back(before + tree);
  for (const std::size_t tree : part.crossing) all.crossing.push_back(before + tree);
}

std::string quoted(const std::set<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "\"" : ", \"") + name + '"';
  return list;
}

void note_unknown_species(const GrowJob& job, const tree::BuilderCatalogue& catalogue) {
  const std::set<std::string>& unknown = job.state->unknown_species;
  if (unknown.empty() || !job.callbacks.note) return;
  job.callbacks.note(
      fmt::format("No preset lists the species {}; preset {} is used (see `preset`).",
                  quoted(unknown),
                  catalogue.fallback(job.builder).name()));
}

/// The number of trees, each counted once for all its measurements.
std::size_t tree_count(const std::vector<tree::Morphology>& trees,
                       const std::vector<std::size_t>& numbers) {
  std::set<std::pair<std::string_view, std::string_view>> names;
  for (const std::size_t i : numbers) names.emplace(trees[i].plot, trees[i].tree);
  return names.size();
}

GrowResult grow_whole(const data::TableSource& trees,
                      const tree::BuilderCatalogue& catalogue,
                      const GrowJob& job,
                      const tree::Builder* for_all,
                      GrowManifest* manifest) {
  ReadTrees read = read_trees(trees, job);
  tree::Moments& table = read.moments;
  give_notes(notes_on(table.left_out), job.callbacks.note);
  if (table.moments.empty()) {
    if (job.is_part) return {.left_out = std::move(table.left_out)};
    throw InputError("no row can be used to grow a tree", {.file = job.file});
  }
  const std::string coinciding = note_on_coinciding_plots(job, table.moments);
  if (!coinciding.empty() && job.callbacks.note) job.callbacks.note(coinciding);
  std::optional<ResultFolder> folder;
  if (!job.out.empty()) folder.emplace(job.out);
  if (manifest != nullptr) {
    job.state->each_tree = [&](std::size_t tree, const GrownTree& grown) {
      manifest->add(read.lines[tree], grown);
    };
  }
  GrowResult result = grow_moments(job, table.moments, catalogue, for_all);
  result.moments = job.per == "plot" ? 1 : table.moments.size();
  result.left_out = std::move(table.left_out);
  return result;
}

}  // namespace

GrowResult grow_moments(const GrowJob& job,
                        const std::vector<tree::Moment>& moments,
                        const tree::BuilderCatalogue& catalogue,
                        const tree::Builder* for_all) {
  const bool is_by_plot = job.per == "plot";
  std::vector<tree::Morphology> stand;
  for (const tree::Moment& moment : moments) {
    stand.insert(stand.end(), moment.trees.begin(), moment.trees.end());
  }
  GrowResult all;
  if (job.animate) {
    all = write_animation(job, moments, stand, catalogue, for_all);
  } else {
    std::size_t before = 0;
    for (const tree::Moment& moment : moments) {
      GrowJob one = is_by_plot       ? of_plot(job, moment.name)
                    : job.by.empty() ? job
                                     : of_moment(job, moment);
      one.first_tree = before;
      // The file of a plot has its own origin and ground.
      append(grow_trees(one, moment.trees, is_by_plot ? moment.trees : stand, catalogue, for_all),
             is_by_plot ? "" : moment.name,
             before,
             all);
      before += moment.trees.size();
    }
  }
  std::vector<std::size_t> numbers(stand.size());
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  all.counts = {.trees = tree_count(stand, numbers),
                .with_guesses = tree_count(stand, all.with_guesses),
                .guesses = std::move(all.counts.guesses),
                .crossing = tree_count(stand, all.crossing),
                .overlaps = all.pairs.size()};
  all.morphologies = std::move(stand);
  return all;
}

GrowResult grow(const data::TableSource& trees,
                const tree::BuilderCatalogue& catalogue,
                const GrowSettings& settings,
                const Callbacks& callbacks) {
  const auto start = std::chrono::steady_clock::now();
  GrowJob job = grow_job(settings, data::file_of(trees), callbacks);
  GrowState state;
  job.state = &state;
  std::optional<GrowManifest> manifest;
  if (!job.manifest.empty()) manifest.emplace(job.manifest);
  const std::unique_ptr<const tree::Builder> with_grammar = builder_with_grammar(catalogue, job);
  GrowResult result;
  if (job.stream) {
    const auto add = [&manifest](std::size_t line, const GrownTree& grown) {
      if (manifest) manifest->add(line, grown);
    };
    result = grow_in_parts(trees, catalogue, job, with_grammar.get(), add);
  } else {
    result = grow_whole(trees, catalogue, job, with_grammar.get(), manifest ? &*manifest : nullptr);
  }
  note_unknown_species(job, catalogue);
  if (manifest) manifest->finish();
  // A builder with a grammar is gone.
  for (tree::SharedModel& model : result.shared.models) model.builder = nullptr;
  result.settings = job;
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  result.seconds = seconds.count();
  return result;
}

std::vector<std::string> notes_on(const std::vector<tree::LeftOut>& left_out, std::size_t count) {
  constexpr std::size_t kShown = 20;
  count = std::max(count, left_out.size());
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < left_out.size() && i < kShown; ++i) {
    notes.push_back(describe(left_out[i].place, left_out[i].reason + "; the row is skipped"));
  }
  if (count > kShown) {
    notes.push_back(
        fmt::format("... and {} skipped", counted(count - kShown, "more row is", "more rows are")));
  }
  return notes;
}

}  // namespace silvafit::study
