// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "silvafit/stand/tree_columns.hpp"
#include "view/view_stand.hpp"

namespace silvafit::study {
namespace {

using tree::Use;

struct Kind {
  Use use;
  const char* suffix;
  const char* title;
};
constexpr std::array kKinds{
    Kind{Use::kObserved, "", "Observed"},
    Kind{Use::kOls, "_ols", "OLS"},
    Kind{Use::kPopulation, "_population", "NLME, population"},
    Kind{Use::kConditional, "_conditional", "NLME, plot"},
};

/// Columns with our names, for any names in the table.
class Columns {
 public:
  Columns(const data::Table& table, const ViewOptions& options)
      : table_(table), columns_(options.columns) {}

  std::string name_of(const std::string& ours) const {
    const auto mapped = columns_.find(ours);
    return mapped == columns_.end() ? ours : mapped->second;
  }
  bool has(const std::string& ours) const { return columns_.contains(ours) || table_.has(ours); }

  /// NaN if a value, or the column, is missing or not a number, which the reading of rows reports.
  std::vector<double> numbers(const std::string& ours) const {
    if (!has(ours)) return std::vector<double>(table_.rows(), data::kMissing);
    return stand::numbers_from(table_, ours, name_of(ours));
  }

  /// The key of a tree: plot and tree, separated by a character that no text contains.
  std::vector<std::string> keys() const {
    const data::TextColumn plots = table_.labels(name_of("plot"));
    const data::TextColumn trees = table_.labels(name_of("tree"));
    std::vector<std::string> keys(table_.rows());
    for (std::size_t row = 0; row < keys.size(); ++row) {
      keys[row] = key(std::string(plots[row]), std::string(trees[row]));
    }
    return keys;
  }
  static std::string key(const std::string& plot, const std::string& tree) {
    return plot + '\0' + tree;
  }

 private:
  const data::Table& table_;
  const std::map<std::string, std::string>& columns_;
};

bool has_sizes(const Columns& columns, const Kind& kind) {
  const std::string suffix = kind.suffix;
  if (!columns.has("h" + suffix) || !columns.has("hcb" + suffix)) return false;
  const bool has_radii = kind.use == Use::kObserved && columns.has("cr_e") && columns.has("cr_w") &&
                         columns.has("cr_s") && columns.has("cr_n");
  return has_radii || columns.has("cw" + suffix);
}

/// The trees of a variant that can be drawn, by key.
using Drawable = std::unordered_map<std::string, tree::Morphology>;

struct ReadVariant {
  const Kind* kind = nullptr;
  Drawable trees{};
  std::unordered_map<std::string, std::size_t> rows{};  ///< of these trees, by key
  std::vector<tree::LeftOut> left_out{};
};

/// The mappings of a variant: a mapping of h is for the observed height, not the predicted ones.
std::map<std::string, std::string> columns_of(const Kind& kind, const ViewOptions& options) {
  std::map<std::string, std::string> columns = options.columns;
  if (kind.use == Use::kObserved) return columns;
  for (const char* name : {"h", "hcb", "cw"}) columns.erase(name);
  return columns;
}

/// The first row with a tree's key that was not skipped.
void find_rows(const data::Table& table,
               const std::vector<std::string>& keys,
               ReadVariant& variant) {
  std::set<std::size_t> left_out;
  for (const tree::LeftOut& one : variant.left_out) left_out.insert(one.place.line.value_or(0));
  for (std::size_t row = 0; row < keys.size(); ++row) {
    const std::size_t line = table.line(row);
    const bool is_left_out = line > 0 && left_out.contains(line);
    if (!is_left_out && variant.trees.contains(keys[row])) variant.rows.emplace(keys[row], row);
  }
}

ReadVariant read_variant(const data::Table& table, const Kind& kind, const ViewOptions& options) {
  tree::MorphologyTable read = tree::read_morphologies(table,
                                                       {.use = kind.use,
                                                        .columns = columns_of(kind, options),
                                                        .plots = options.plots,
                                                        .needs_position = true});
  ReadVariant variant{.kind = &kind, .left_out = std::move(read.left_out)};
  for (tree::Morphology& tree : read.morphologies) {
    std::string key = Columns::key(tree.plot, tree.tree);
    variant.trees.emplace(std::move(key), std::move(tree));
  }
  return variant;
}

/// The sizes of a tree that can be drawn. Its crown width may be computed from its radii.
ViewSizes sizes_of(const tree::Morphology& tree, const ViewSizes& table) {
  const bool has_width = !std::isnan(table.cw_m);
  const double radii_width = tree.radii ? tree.radii->width_m() : data::kMissing;
  return {tree.h_m, tree.hcb_m, has_width ? table.cw_m : tree.cw_m.value_or(radii_width)};
}

class StandReader {
 public:
  StandReader(const data::Table& table,
              const tree::BuilderCatalogue& catalogue,
              const ViewOptions& options)
      : table_(table), catalogue_(catalogue), options_(options), columns_(table, options) {}

  ViewStand read() {
    check_places();
    for (const Kind& kind : kKinds) {
      if (has_sizes(columns_, kind)) variants_.push_back(read_variant(table_, kind, options_));
    }
    if (variants_.empty()) {
      throw InputError(
          "trees need the columns h, hcb and cw, or predictions such as h_ols, hcb_ols and cw_ols",
          {.file = table_.file(), .line = 1});
    }
    choose_rows();
    add_trees();
    for (const ReadVariant& variant : variants_) add_variant(variant);
    stand_.columns = color_columns(table_, options_.columns, rows_);
    note_missing_values();
    if (!options_.mark.empty()) add_thinned();
    return std::move(stand_);
  }

 private:
  void check_places() const {
    for (const char* name : {"x", "y"}) {
      if (columns_.has(name)) continue;
      throw InputError(
          "a page needs the positions of the trees: the columns x (east) and y (north) in meters, "
          "or `columns=x=...,y=...` if they have other names",
          {.file = table_.file(), .line = 1, .column = name});
    }
  }

  /// A row for each tree: that of the first variant that can draw it.
  void choose_rows() {
    const std::vector<std::string> keys = columns_.keys();
    for (ReadVariant& variant : variants_) find_rows(table_, keys, variant);
    for (std::size_t row = 0; row < keys.size(); ++row) {
      const auto first = std::ranges::find_if(
          variants_, [&](const ReadVariant& variant) { return variant.trees.contains(keys[row]); });
      if (first == variants_.end() || first->rows.at(keys[row]) != row) continue;
      rows_.push_back(row);
      keys_.push_back(keys[row]);
    }
    if (rows_.empty()) {
      stand_.left_out = variants_.front().left_out;
      const std::string why =
          stand_.left_out.empty() ? "" : "; the first row: " + stand_.left_out.front().reason;
      throw InputError("no row can be used to show a tree" + why, {.file = table_.file()});
    }
  }

  const tree::Morphology& any_version(const std::string& key) const {
    for (const ReadVariant& variant : variants_) {
      const auto found = variant.trees.find(key);
      if (found != variant.trees.end()) return found->second;
    }
    throw UsageError("the tree has no sizes");
  }

  void add_trees() {
    const std::vector<double> h = columns_.numbers("h");
    const std::vector<double> hcb = columns_.numbers("hcb");
    const std::vector<double> cw = columns_.numbers("cw");
    const std::vector<double> core = columns_.numbers("core");
    const std::array indices{
        columns_.numbers("W"), columns_.numbers("M"), columns_.numbers("U"), columns_.numbers("C")};
    tree::SpeciesNotes species;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const std::size_t row = rows_[i];
      const tree::Morphology& version = any_version(keys_[i]);
      const tree::PresetChoice choice =
          catalogue_.choose(tree::BuilderKind::kSegment, version.species, options_.reads_codes);
      ViewTree tree{.plot = version.plot,
                    .tree = version.tree,
                    .species = version.species,
                    .preset = choice.builder,
                    .position = version.position,
                    .dbh_cm = version.dbh_cm,
                    .observed = {h[row], hcb[row], cw[row]},
                    .core = core[row]};
      for (std::size_t k = 0; k < indices.size(); ++k) tree.indices.at(k) = indices.at(k)[row];
      const auto observed = variants_.front().trees.find(keys_[i]);
      if (variants_.front().kind->use == Use::kObserved &&
          observed != variants_.front().trees.end()) {
        tree.observed = sizes_of(observed->second, tree.observed);
      }
      species.add(version.species, choice);
      stand_.trees.push_back(std::move(tree));
    }
    for (std::string& note : species.texts()) stand_.notes.push_back(std::move(note));
  }

  void add_variant(const ReadVariant& read) {
    const std::string suffix = read.kind->suffix;
    const std::vector<double> h = columns_.numbers("h" + suffix);
    const std::vector<double> hcb = columns_.numbers("hcb" + suffix);
    const std::vector<double> cw = columns_.numbers("cw" + suffix);
    ViewVariant variant{.name = word_of(read.kind->use), .title = read.kind->title};
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      ViewVersion version{.sizes = {h[rows_[i]], hcb[rows_[i]], cw[rows_[i]]}};
      const auto found = read.trees.find(keys_[i]);
      // The other row of a repeated tree is not the row shown.
      if (found != read.trees.end() && read.rows.at(keys_[i]) == rows_[i]) {
        version.shape = stand_.trees[i].preset->shape_of(found->second);
        version.sizes = sizes_of(found->second, version.sizes);
      }
      variant.trees.push_back(std::move(version));
    }
    stand_.variants.push_back(std::move(variant));
  }

  /// The first variant without the trees that are marked.
  void add_thinned() {
    const std::string column = columns_.name_of(options_.mark);
    if (!table_.has(column)) {
      throw InputError(data::no_such_column(column, table_.names()),
                       {.file = table_.file(), .column = "`mark`"});
    }
    data::require_numeric(table_, {column});
    const auto marks = table_.numbers(column);
    ViewVariant thinned = stand_.variants.front();
    thinned.name = "thinned";
    thinned.title = "After thinning";
    std::size_t removed = 0;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const double mark = marks[rows_[i]];
      if (std::isnan(mark) || mark == 0.0) continue;
      thinned.trees[i] = {};
      ++removed;
    }
    stand_.notes.push_back(fmt::format("After thinning: {} of {} marked in column {} and removed.",
                                       removed,
                                       counted(rows_.size(), "tree is", "trees are"),
                                       column));
    stand_.variants.push_back(std::move(thinned));
  }

  void note_missing_values() {
    for (const ViewVariant& variant : stand_.variants) {
      note_missing_values(variant);
    }
    std::set<std::size_t> lines;
    for (const std::size_t row : rows_) lines.insert(table_.line(row));
    const std::set<std::string> keys(keys_.begin(), keys_.end());
    for (const tree::LeftOut& one : variants_.front().left_out) {
      // Tables that were not read from a file have no lines.
      const std::size_t line = one.place.line.value_or(0);
      const bool is_shown = line > 0 ? lines.contains(line)
                                     : keys.contains(Columns::key(one.place.plot, one.place.tree));
      if (!is_shown) stand_.left_out.push_back(one);
    }
  }

  void note_missing_values(const ViewVariant& variant) {
    const auto is_unknown = [](const ViewSizes& sizes) {
      return std::isnan(sizes.h_m) && std::isnan(sizes.hcb_m) && std::isnan(sizes.cw_m);
    };
    const bool is_observed = variant.name == word_of(kKinds.front().use);
    const auto count = [&](bool unknown) {
      return std::ranges::count_if(variant.trees, [&](const ViewVersion& tree) {
        return !tree.shape && is_unknown(tree.sizes) == unknown;
      });
    };
    const auto say = [&](std::ptrdiff_t missing, const char* what) {
      if (missing == 0) return;
      stand_.notes.push_back(fmt::format(
          "{}: {} of {} no {} and {} not drawn.",
          variant.title,
          missing,
          counted(variant.trees.size(), "tree", "trees") + (missing == 1 ? " has" : " have"),
          what,
          missing == 1 ? "is" : "are"));
    };
    say(count(true), is_observed ? "measurements" : "predictions");
    say(count(false), "possible sizes");
  }

  const data::Table& table_;
  const tree::BuilderCatalogue& catalogue_;
  const ViewOptions& options_;
  Columns columns_;
  std::vector<ReadVariant> variants_{};
  std::vector<std::size_t> rows_{};
  std::vector<std::string> keys_{};
  ViewStand stand_{};
};

}  // namespace

const tree::Builder& builder_of(const std::string& species,
                                const tree::BuilderCatalogue& catalogue) {
  return *catalogue.choose(tree::BuilderKind::kSegment, species).builder;
}

ViewStand read_view_stand(const data::Table& table,
                          const tree::BuilderCatalogue& catalogue,
                          const ViewOptions& options) {
  return StandReader(table, catalogue, options).read();
}

}  // namespace silvafit::study
