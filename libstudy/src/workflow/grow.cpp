// SPDX-License-Identifier: MIT
#include "silvafit/study/grow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/ordered_rows.hpp"
#include "silvafit/study/tree_table.hpp"
#include "silvafit/tree/coinciding_plots.hpp"
#include "silvafit/tree/lsystem_builder.hpp"
#include "workflow/assumed_sizes.hpp"
#include "workflow/flow.hpp"
#include "workflow/grow_job.hpp"

namespace silvafit::study {
namespace {

/// Writes a CSV file with a row for each tree at each level of detail, in the order of the trees in
/// their file: plot, tree, species, preset, level, file, triangles, bytes.
class GrowManifest {
 public:
  explicit GrowManifest(const std::string& file);

  /// \param line  of the tree
  void add(std::size_t line, const GrownTree& grown);
  void finish();

 private:
  AtomicFile file_;
  data::OrderedRows rows_;
};

GrowManifest::GrowManifest(const std::string& file) : file_(file), rows_(file_.stream(), true) {
  file_.stream() << "plot,tree,species,preset,level,file,triangles,bytes\n";
}

void GrowManifest::add(std::size_t line, const GrownTree& grown) {
  const tree::SceneTree& tree = grown.tree;
  rows_.add(line,
            fmt::format("{},{},{},{},{},{},{},{}\n",
                        data::csv_field(tree.plot),
                        data::csv_field(tree.tree),
                        data::csv_field(tree.species),
                        data::csv_field(tree.preset),
                        grown.level,
                        data::csv_field(grown.file),
                        tree.measured.triangles,
                        grown.bytes));
}

void GrowManifest::finish() {
  rows_.finish();
  file_.commit();
}

/// Trees of a part are in memory with all their measurements, and their names.
constexpr std::size_t kRowsOfPart = 20000;
/// Of the skipped rows of parts; the others are counted.
constexpr std::size_t kMostLeftOut = 20;

std::string source_of(const std::map<std::string, std::string>& columns, const std::string& name) {
  const auto found = columns.find(name);
  return found == columns.end() ? name : found->second;
}

tree::MorphologyTableOptions morphology_options(const GrowJob& job) {
  return {.use = value_of<tree::Use>(job.use, "use"),
          .plots = job.plots,
          .needs_position = !job.scene.empty() || job.resolve_overlaps || job.is_by_plot,
          .only_height = job.is_unfitted,
          .dead_wood = job.dead_wood};
}

/// The trees of each plot as a moment, in the order of the plots' first trees.
/// \param lines  of the trees, gets the same order
std::vector<tree::Moment> plots_of(std::vector<tree::Morphology> trees,
                                   std::vector<std::size_t>& lines) {
  std::vector<tree::Moment> plots;
  std::vector<std::vector<std::size_t>> lines_of_plots;
  std::map<std::string, std::size_t> number_of;
  for (std::size_t i = 0; i < trees.size(); ++i) {
    const auto [plot, is_new] = number_of.try_emplace(trees[i].plot, plots.size());
    if (is_new) {
      plots.push_back({.name = trees[i].plot});
      lines_of_plots.emplace_back();
    }
    if (!lines.empty()) lines_of_plots[plot->second].push_back(lines[i]);
    plots[plot->second].trees.push_back(std::move(trees[i]));
  }
  lines.clear();
  for (const auto& of_plot : lines_of_plots)
    lines.insert(lines.end(), of_plot.begin(), of_plot.end());
  return plots;
}

/// The line of each tree in the file.
std::vector<std::size_t> lines_of(const data::Table& table,
                                  const std::map<std::string, std::string>& columns,
                                  const std::vector<tree::Morphology>& trees) {
  // Trees are in the order of their rows; other rows are skipped.
  const data::TextColumn plots = table.labels(source_of(columns, "plot"));
  const data::TextColumn numbers = table.labels(source_of(columns, "tree"));
  std::vector<std::size_t> lines;
  for (std::size_t row = 0; row < table.rows() && lines.size() < trees.size(); ++row) {
    const tree::Morphology& next = trees[lines.size()];
    if (plots[row] == next.plot && numbers[row] == next.tree) lines.push_back(table.line(row));
  }
  return lines;
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

/// The number of trees, each counted once for all its measurements.
std::size_t tree_count(const std::vector<tree::Morphology>& trees,
                       const std::vector<std::size_t>& numbers) {
  std::set<std::pair<std::string_view, std::string_view>> names;
  for (const std::size_t i : numbers) names.emplace(trees[i].plot, trees[i].tree);
  return names.size();
}

/// Grows the trees of a table, or of its parts one after another.
class Growth {
 public:
  Growth(const tree::BuilderCatalogue& catalogue,
         const GrowJob& job,
         const tree::Builder* for_all,
         GrowManifest* manifest)
      : catalogue_(catalogue), job_(job), for_all_(for_all), manifest_(manifest) {}

  GrowResult run(const data::TableSource& trees);

 private:
  /// The trees of each moment or plot, else all together.
  struct Trees {
    tree::Moments moments{};
    std::vector<std::size_t> lines{};  ///< for the manifest
  };

  std::string plot_column(const std::vector<std::string>& header) const;
  bool choose_plots(const data::Table& table, tree::MorphologyTableOptions& options);
  void refuse_unknown_plots() const;
  Trees read(const data::TableSource& rows);
  void grow(const Trees& trees);
  void add(GrowResult&& part);

  const tree::BuilderCatalogue& catalogue_;
  const GrowJob& job_;
  const tree::Builder* for_all_;
  GrowManifest* manifest_;
  ReadingState state_{};
  std::vector<std::string> recognized_{};
  std::unordered_set<std::string> plots_found_{};
  std::vector<tree::LeftOut> left_out_{};  ///< in parts, the first of them
  std::size_t left_out_count_ = 0;
  AssumedSizes assumed_{};
  GrowResult result_{};
};

std::string Growth::plot_column(const std::vector<std::string>& header) const {
  const auto columns = stand::parse_column_mappings(job_.reading.columns);
  if (!stand::fields_of("plot", header, columns, job_.file).empty()) return "plot";
  throw UsageError("a table without a column plot has no parts; omit `stream`",
                   {.file = job_.file, .column = "`stream`"});
}

/// The wanted plots that are in a part; false if there are none.
bool Growth::choose_plots(const data::Table& table, tree::MorphologyTableOptions& options) {
  if (job_.plots.empty() || !job_.stream) return true;
  const data::TextColumn plots = table.labels(source_of(options.columns, "plot"));
  options.plots.clear();
  for (const std::string& plot : job_.plots) {
    if (plots.code_of(plot) == data::TextColumn::kMissingCode) continue;
    options.plots.push_back(plot);
    plots_found_.insert(plot);
  }
  return !options.plots.empty();
}

void Growth::refuse_unknown_plots() const {
  for (const std::string& plot : job_.plots) {
    if (plots_found_.contains(plot)) continue;
    throw InputError(fmt::format("no trees in plot {}", plot), {.file = job_.file});
  }
}

void Growth::add(GrowResult&& part) {
  result_.counts.trees += part.counts.trees;
  result_.counts.with_guesses += part.counts.with_guesses;
  for (const auto& [name, count] : part.counts.guesses) result_.counts.guesses[name] += count;
  result_.counts.crossing += part.counts.crossing;
  result_.counts.overlaps += part.counts.overlaps;
  const bool is_same_folder = !job_.is_by_plot && !result_.files.empty();
  for (std::size_t i = 0; i < part.files.size(); ++i) {
    if (!is_same_folder) {
      result_.files.push_back(std::move(part.files[i]));
      continue;
    }
    result_.files[i].bytes += part.files[i].bytes;
    result_.files[i].trees += part.files[i].trees;
    result_.files[i].triangles += part.files[i].triangles;
  }
}

Growth::Trees Growth::read(const data::TableSource& rows) {
  tree::MorphologyTableOptions options = morphology_options(job_);
  ReadTable table = read_tree_table(rows,
                                    job_.reading,
                                    job_.by,
                                    options.columns,
                                    job_.stream ? NoteCallback() : job_.callbacks.note,
                                    job_.stream ? &state_ : nullptr,
                                    job_.dead_wood);
  recognized_ = table.recognized;
  job_.state->reads_codes = table.has_fia_species;
  if (!job_.stream) assume_labels(table.table, options.columns);
  if (options.use == tree::Use::kObserved && !options.only_height) {
    assume_sizes(table.table, options.columns, assumed_);
    const std::string unused = note_on_predictions(table.table);
    if (!job_.stream && !unused.empty()) give_notes(std::vector{unused}, job_.callbacks.note);
  }
  if (!job_.by.empty()) return {.moments = tree::read_moments(table.table, job_.by, options)};
  if (!choose_plots(table.table, options)) return {};
  tree::MorphologyTable read = tree::read_morphologies(table.table, options);
  Trees trees{.moments = {.left_out = std::move(read.left_out)}};
  if (read.morphologies.empty()) return trees;
  if (manifest_ != nullptr) {
    trees.lines = lines_of(table.table, options.columns, read.morphologies);
  }
  if (job_.is_by_plot) {
    trees.moments.moments = plots_of(std::move(read.morphologies), trees.lines);
  } else {
    trees.moments.moments.push_back({.trees = std::move(read.morphologies)});
  }
  return trees;
}

void Growth::grow(const Trees& trees) {
  const std::vector<tree::Moment>& moments = trees.moments.moments;
  if (manifest_ != nullptr) {
    job_.state->each_tree = [&](std::size_t tree, const GrownTree& grown) {
      manifest_->add(trees.lines[tree], grown);
    };
  }
  GrowResult part = grow_moments(job_, moments, catalogue_, for_all_);
  if (job_.stream) return add(std::move(part));
  result_ = std::move(part);
  result_.moments = job_.is_by_plot ? 1 : moments.size();
}

GrowResult Growth::run(const data::TableSource& trees) {
  TableFlow flow(
      trees,
      job_.reading,
      {.is_in_parts = job_.stream, .rows = kRowsOfPart, .threads = job_.threads},
      [this](const std::vector<std::string>& header) { return plot_column(header); },
      job_.callbacks.note);
  result_.moments = 1;
  std::optional<ResultFolder> folder;
  while (const auto rows = flow.next()) {
    Trees part = read(*rows);
    left_out_count_ += part.moments.left_out.size();
    for (tree::LeftOut& row : part.moments.left_out) {
      if (!job_.stream || left_out_.size() < kMostLeftOut) left_out_.push_back(std::move(row));
    }
    if (!job_.stream) {
      give_notes(notes_on(left_out_), job_.callbacks.note);
      const std::string coinciding = note_on_coinciding_plots(job_, part.moments.moments);
      if (!coinciding.empty() && job_.callbacks.note) job_.callbacks.note(coinciding);
    }
    if (part.moments.moments.empty()) continue;
    if (!job_.out.empty() && !folder) folder.emplace(job_.out);
    grow(part);
  }
  const std::string assumed = note_on(assumed_);
  if (!assumed.empty() && job_.callbacks.note) job_.callbacks.note(assumed);
  if (job_.stream) refuse_unknown_plots();
  if (result_.files.empty() && !job_.is_part) {
    throw InputError("no row can be used to grow a tree", {.file = job_.file});
  }
  if (job_.stream) {
    give_notes(recognized_, job_.callbacks.note);
    give_notes(notes_on(left_out_, left_out_count_), job_.callbacks.note);
  }
  result_.left_out = std::move(left_out_);
  return std::move(result_);
}

}  // namespace

GrowResult grow_moments(const GrowJob& job,
                        const std::vector<tree::Moment>& moments,
                        const tree::BuilderCatalogue& catalogue,
                        const tree::Builder* for_all) {
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
      GrowJob one = job.is_by_plot   ? of_plot(job, moment.name)
                    : job.by.empty() ? job
                                     : of_moment(job, moment);
      one.first_tree = before;
      // The file of a plot has its own origin and ground.
      append(
          grow_trees(one, moment.trees, job.is_by_plot ? moment.trees : stand, catalogue, for_all),
          job.is_by_plot ? "" : moment.name,
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
  const auto start = Clock::now();
  GrowJob job = grow_job(settings, data::file_of(trees), callbacks);
  GrowState state;
  job.state = &state;
  std::optional<GrowManifest> manifest;
  if (!job.manifest.empty()) manifest.emplace(job.manifest);
  const std::unique_ptr<const tree::Builder> with_grammar = builder_with_grammar(catalogue, job);
  GrowManifest* const rows = manifest ? &*manifest : nullptr;
  GrowResult result = Growth(catalogue, job, with_grammar.get(), rows).run(trees);
  give_notes(state.species.texts(), job.callbacks.note);
  if (manifest) manifest->finish();
  // A builder with a grammar is gone.
  for (tree::SharedModel& model : result.shared.models) model.builder = nullptr;
  result.settings = job;
  result.seconds = seconds_since(start);
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
