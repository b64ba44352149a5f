// SPDX-License-Identifier: MIT
// Growing the trees of tables larger than memory, in parts of whole plots.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <unordered_set>
#include <utility>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/read_ahead.hpp"
#include "silvafit/data/table_parts.hpp"
#include "silvafit/study/tree_table.hpp"
#include "workflow/assumed_sizes.hpp"
#include "workflow/grow_job.hpp"
#include "workflow/parts_of_files.hpp"

namespace silvafit::study {
namespace {

/// Trees of a part are in memory with all their measurements, and their names.
constexpr std::size_t kRowsOfPart = 20000;
/// Of the skipped rows; the others are counted.
constexpr std::size_t kMostLeftOut = 20;

std::string source_of(const std::map<std::string, std::string>& columns, const std::string& name) {
  const auto found = columns.find(name);
  return found == columns.end() ? name : found->second;
}

class GrowthOfParts {
 public:
  GrowthOfParts(const data::TableSource& trees,
                const tree::BuilderCatalogue& catalogue,
                const GrowJob& job,
                const tree::Builder* for_all,
                const std::function<void(std::size_t line, const GrownTree&)>& each_tree)
      : catalogue_(catalogue),
        job_(job),
        for_all_(for_all),
        each_tree_(each_tree),
        parts_(table_parts(
            trees,
            job.reading,
            [this](const std::vector<std::string>& header) { return plot_column(header); },
            kRowsOfPart)) {}

  GrowResult run();

 private:
  std::string plot_column(const std::vector<std::string>& header) const;
  bool choose_plots(const data::Table& table, tree::MorphologyTableOptions& options);
  void refuse_unknown_plots() const;
  void grow_part(const data::TableSource& part);
  void add(GrowResult&& part);

  const tree::BuilderCatalogue& catalogue_;
  const GrowJob& job_;
  const tree::Builder* for_all_;
  const std::function<void(std::size_t line, const GrownTree&)>& each_tree_;
  data::TableParts parts_;
  ReadingState state_{};
  std::vector<std::string> recognized_{};
  std::unordered_set<std::string> plots_found_{};
  std::size_t left_out_ = 0;
  bool has_assumed_ = false;
  GrowResult result_{};
};

std::string GrowthOfParts::plot_column(const std::vector<std::string>& header) const {
  if (field_of("plot", header, job_.reading, job_.file)) return "plot";
  throw UsageError("a table without a column plot has no parts; omit `stream`",
                   {.file = job_.file, .column = "`stream`"});
}

/// The wanted plots that are in a part; false if there are none.
bool GrowthOfParts::choose_plots(const data::Table& table, tree::MorphologyTableOptions& options) {
  if (job_.plots.empty()) return true;
  const data::TextColumn plots = table.labels(source_of(options.columns, "plot"));
  options.plots.clear();
  for (const std::string& plot : job_.plots) {
    if (plots.code_of(plot) == data::TextColumn::kMissingCode) continue;
    options.plots.push_back(plot);
    plots_found_.insert(plot);
  }
  return !options.plots.empty();
}

void GrowthOfParts::refuse_unknown_plots() const {
  for (const std::string& plot : job_.plots) {
    if (plots_found_.contains(plot)) continue;
    throw InputError(fmt::format("no trees in plot {}", plot), {.file = job_.file});
  }
}

void GrowthOfParts::add(GrowResult&& part) {
  result_.counts.trees += part.counts.trees;
  result_.counts.with_guesses += part.counts.with_guesses;
  for (const auto& [name, count] : part.counts.guesses) result_.counts.guesses[name] += count;
  result_.counts.crossing += part.counts.crossing;
  result_.counts.overlaps += part.counts.overlaps;
  const bool is_same_folder = job_.per == "tree" && !result_.files.empty();
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

void GrowthOfParts::grow_part(const data::TableSource& part) {
  tree::MorphologyTableOptions options = morphology_options(job_);
  ReadTable read = read_tree_table(part, job_.reading, job_.by, options.columns, {}, &state_);
  recognized_ = std::move(read.recognized);
  if (!choose_plots(read.table, options)) return;
  if (options.use == tree::Use::kObserved && !options.only_height) {
    const std::string note = assume_sizes(read.table, options.columns);
    const bool is_new = !note.empty() && !std::exchange(has_assumed_, true);
    if (is_new && job_.callbacks.note) {
      job_.callbacks.note("in the first part with such trees " + note);
    }
  }
  tree::MorphologyTable trees = tree::read_morphologies(read.table, options);
  left_out_ += trees.left_out.size();
  for (tree::LeftOut& row : trees.left_out) {
    if (result_.left_out.size() < kMostLeftOut) result_.left_out.push_back(std::move(row));
  }
  if (trees.morphologies.empty()) return;
  std::vector<std::size_t> lines = lines_of(read.table, options.columns, trees.morphologies);
  read = {};
  std::vector<tree::Moment> moments;
  if (job_.per == "plot") {
    moments = plots_of(std::move(trees.morphologies), lines);
  } else {
    moments.push_back({.trees = std::move(trees.morphologies)});
  }
  job_.state->each_tree = [&](std::size_t tree, const GrownTree& grown) {
    each_tree_(lines[tree], grown);
  };
  add(grow_moments(job_, moments, catalogue_, for_all_));
}

GrowResult GrowthOfParts::run() {
  const ResultFolder folder(job_.out);
  if (parts_.is_sorted() && job_.callbacks.note) job_.callbacks.note(kSortedNote);
  ReadAhead<std::shared_ptr<const data::TableText>> ahead([this] { return parts_.next(); },
                                                          job_.threads);
  while (const auto part = ahead.next()) grow_part(part);
  refuse_unknown_plots();
  if (result_.files.empty()) {
    throw InputError("no row can be used to grow a tree", {.file = job_.file});
  }
  give_notes(recognized_, job_.callbacks.note);
  give_notes(notes_on(result_.left_out, left_out_), job_.callbacks.note);
  result_.moments = 1;
  return std::move(result_);
}

}  // namespace

tree::MorphologyTableOptions morphology_options(const GrowJob& job) {
  const bool is_by_plot = job.per == "plot";
  return {.use = tree::use_from_text(job.use),
          .plots = job.plots,
          .needs_position = !job.scene.empty() || job.resolve_overlaps || is_by_plot,
          .only_height = job.is_unfitted};
}

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

GrowResult grow_in_parts(const data::TableSource& trees,
                         const tree::BuilderCatalogue& catalogue,
                         const GrowJob& job,
                         const tree::Builder* for_all,
                         const std::function<void(std::size_t line, const GrownTree&)>& each_tree) {
  return GrowthOfParts(trees, catalogue, job, for_all, each_tree).run();
}

}  // namespace silvafit::study
