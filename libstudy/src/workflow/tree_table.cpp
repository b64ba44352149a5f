// SPDX-License-Identifier: MIT
#include "silvafit/study/tree_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/prepared_table.hpp"
#include "silvafit/stand/similar_plots.hpp"
#include "silvafit/stand/species_spellings.hpp"
#include "silvafit/stand/tree_status.hpp"
#include "silvafit/stand/unread_columns.hpp"
#include "silvafit/study/table_checks.hpp"
#include "workflow/recurring_groups.hpp"
#include "workflow/repeated_rows.hpp"
#include "workflow/table_sizes.hpp"
#include "workflow/terrain.hpp"

namespace silvafit::study {
namespace {

using Names = std::vector<std::string>;
using Mappings = std::vector<stand::ColumnMapping>;

bool contains(const Names& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

/// The treatment of rows with the plot and tree of an earlier row.
enum class RepeatedRows {
  kAll,            ///< all rows are kept
  kObservations,   ///< copies are found
  kOneOfEachTree,  ///< copies and later times are removed; other trees get their own numbers
};

/// Settings for converting a file to a table.
struct Wishes : ModelColumns {
  stand::InventoryOptions options{};  ///< the columns that it maps are not added
  bool wants_all = false;             ///< all of our columns, instead of `wanted`
  bool leaves_out_dead = false;
  bool dead_wood = false;  ///< a column tells what is left of trees
  RepeatedRows repeated = RepeatedRows::kObservations;

  bool is_wanted(const std::string& name) const {
    const bool is_label = name == "plot" || name == "tree";
    return wants_all || contains(wanted, name) || (is_label && !wanted.empty());
  }
};

/// Reads one source; its functions share their data as members.
class TableReader {
 public:
  TableReader(const data::TableSource& source, const Wishes& wishes)
      : wishes_(wishes),
        prepared_(stand::prepared_table(source, wishes.options, wishes.state != nullptr)),
        reader_(prepared_.table, wishes.options.missing),
        state_(wishes.state == nullptr ? own_state_ : *wishes.state) {
    result_.mapped = wishes.options.columns;
  }

  struct Result : ObservedTable {
    Mappings mapped{};  ///< columns in other units are expressions
    Mappings usual{};   ///< columns that were added under our names
  };
  Result read();

 private:
  void find_columns();
  void separate_joined_labels();
  void read_table();
  void find_missing_values(const std::string& name, const std::string& source, bool is_own);
  void add_column(const stand::ColumnMapping& column);
  void unify_spellings();
  void find_missing_species();
  void leave_out_sums();
  void describe_unread();
  Names columns_of_labels() const;
  void leave_out_remains();
  void read_status();
  void describe_labels();
  /// The column of the table for one of our columns.
  std::string column_of(const std::string& name) const {
    const stand::ColumnMapping* const mapping = stand::mapping_to(name, result_.mapped);
    return mapping == nullptr ? name : mapping->source;
  }
  void resolve_repeated_rows(RepeatedRows rule);
  void note(std::string text) {
    if (!text.empty()) result_.recognized.push_back(std::move(text));
  }

  const Wishes& wishes_;
  stand::PreparedTable prepared_;
  data::CsvReader reader_;
  Mappings usual_{};
  Mappings joined_{};     ///< labels of several columns, by the settings
  Mappings converted_{};  ///< mapped columns that have another unit than ours
  ReadingState own_state_{};
  ReadingState& state_;
  Result result_{};
};

/// Labels that are joined of several columns become columns under our names.
void TableReader::separate_joined_labels() {
  std::erase_if(result_.mapped, [this](const stand::ColumnMapping& mapping) {
    const bool is_joined = contains(wishes_.names, mapping.name) &&
                           !stand::joined_columns(mapping.source, reader_.header()).empty();
    if (is_joined) joined_.push_back(mapping);
    return is_joined;
  });
}

void TableReader::find_columns() {
  separate_joined_labels();
  const auto& header = reader_.header();
  const auto& units = reader_.layout().units;
  for (stand::ColumnMapping& mapping : result_.mapped) {
    stand::ColumnMapping ours = stand::in_our_unit(mapping, header, units);
    if (ours.source == mapping.source) continue;
    converted_.push_back(ours);
    mapping = std::move(ours);
  }
  const auto is_looked_for = [this](const std::string& name) {
    return wishes_.is_wanted(name) && stand::mapping_to(name, result_.mapped) == nullptr &&
           stand::mapping_to(name, joined_) == nullptr;
  };
  usual_ =
      stand::usual_columns(header, is_looked_for, reader_.file(), units, false, result_.mapped);
  usual_.insert(usual_.end(), joined_.begin(), joined_.end());
}

void TableReader::read_table() {
  // Plot 07 is not plot 7 for any name of the column.
  Names texts = wishes_.names;
  for (const Mappings* const mappings : {&result_.mapped, &usual_}) {
    for (const stand::ColumnMapping& mapping : *mappings) {
      if (!contains(wishes_.names, mapping.name)) continue;
      const Names parts = stand::joined_columns(mapping.source, reader_.header());
      texts.insert(texts.end(), parts.begin(), parts.end());
      if (parts.empty()) texts.push_back(mapping.source);
    }
  }
  const std::vector<std::size_t> fields =
      stand::filled_fields(wishes_.options, reader_.header(), reader_.file());
  for (const std::size_t field : fields) reader_.fill_down(field);
  result_.table = data::read_csv_table(
      reader_,
      {.text_columns = std::move(texts), .missing = wishes_.options.missing, .fill_down = fields},
      &state_.codes);
}

/// Treats numbers such as -999, and impossible values of 0, as missing values in the sources of our
/// columns.
/// \param is_own  the source is the column itself, not an expression of the user
void TableReader::find_missing_values(const std::string& name,
                                      const std::string& source,
                                      bool is_own) {
  const data::ColumnReference reference =
      data::column_reference(name, source, result_.table.names(), reader_.file());
  stand::take_missing_codes(name,
                            reference.columns(),
                            is_own,
                            result_.table,
                            [this](const std::string& column, const std::string& code) {
                              state_.codes.add(column, code);
                            });
}

/// Adds a column under our name; the source column remains.
void TableReader::add_column(const stand::ColumnMapping& column) {
  data::Table& table = result_.table;
  const Names parts = stand::joined_columns(column.source, reader_.header());
  const bool is_text = stand::is_label(column.name) || contains(wishes_.names, column.name);
  if (is_text && !parts.empty()) {
    table.set(column.name, stand::joined_labels(table, parts));
  } else if (!table.has(column.source)) {
    std::vector<data::TextCell> cells;
    const auto reference =
        data::column_reference(column.name, column.source, table.names(), reader_.file());
    std::vector<double> numbers = data::numbers_of(table, reference, cells);
    // A column of labels, such as that of subplots, may have numbers, too.
    if (!cells.empty()) require_numbers(table, reference.expression->variables());
    table.set(column.name, std::move(numbers));
  } else {
    data::copy_column(column.name, table, column.source, table);
  }
}

/// Species such as `-` and `?` are missing in models, as they are in stands.
void TableReader::find_missing_species() {
  if (wishes_.wants_all || wishes_.keeps_sums) return;
  const auto fields =
      stand::fields_of("species", reader_.header(), wishes_.options.columns, reader_.file());
  if (fields.size() != 1) return;
  const std::string& name = reader_.header()[fields.front()];
  for (const std::string& column : {name, std::string("species")}) {
    if (!result_.table.has(column) || result_.table.is_numeric(column)) continue;
    const data::TextColumn& read = result_.table.text(column);
    if (std::ranges::none_of(read.levels(), data::is_missing_number)) continue;
    data::TextColumn species;
    std::size_t missing = 0;
    for (std::size_t row = 0; row < read.size(); ++row) {
      const bool is_code = !read.is_missing(row) && data::is_missing_number(read[row]);
      if (is_code) ++missing;
      read.is_missing(row) || is_code ? species.append_missing() : species.append(read[row]);
    }
    result_.table.set(column, std::move(species));
    if (column != name || missing == 0) continue;
    note(fmt::format("{} no {}: the label is a code of a missing one",
                     counted(missing, "row has", "rows have"),
                     name));
  }
}

void TableReader::unify_spellings() {
  const std::string name = column_of("species");
  data::Table& table = result_.table;
  if (wishes_.options.case_sensitive || !table.has(name) || table.is_numeric(name)) return;
  data::TextColumn species = table.text(name);
  state_.spellings.know(wishes_.species);
  state_.spellings.unify(species);
  table.set(name, std::move(species));
  note(state_.spellings.note());
}

/// Texts of tree::MorphologyTableOptions::dead_wood.
std::string_view remains_of(stand::TreeStatus status) {
  if (status == stand::TreeStatus::kDead) return "snag";
  if (status == stand::TreeStatus::kGone) return "stump";
  return status == stand::TreeStatus::kFallen ? "log" : "living";
}

/// Trees of which a column says that only a snag, a stump or a log is left are not drawn as living.
void TableReader::leave_out_remains() {
  data::Table& table = result_.table;
  const bool is_read = wishes_.wants_all && wishes_.leaves_out_dead && table.has("remains") &&
                       !table.is_numeric("remains");
  if (!is_read || wishes_.options.dead == stand::DeadTrees::kInclude) return;
  const data::TextColumn& remains = table.text("remains");
  std::vector<std::size_t> living;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (remains.is_missing(row) || in_lower_case(remains[row]) == "living") living.push_back(row);
  }
  if (living.size() == table.rows()) return;
  note(fmt::format("{} by the column remains and {} skipped",
                   counted(table.rows() - living.size(),
                           "row is a snag, a stump or a log",
                           "rows are snags, stumps or logs"),
                   table.rows() - living.size() == 1 ? "is" : "are"));
  table = table.select(living);
}

/// Excludes the trees that are dead or cut, or notes that they are used.
void TableReader::read_status() {
  const stand::StatusCodes& codes = wishes_.options.status_codes;
  const auto column = stand::status_column(
      reader_.header(), result_.mapped, codes, wishes_.options.dead, reader_.file());
  if (!column || !result_.table.has(*column)) return;
  if (!state_.status) state_.status.emplace(*column, codes, reader_.header());
  stand::StatusColumn& status = *state_.status;
  const data::TextColumn values = result_.table.labels(*column);
  const bool includes = wishes_.options.dead == stand::DeadTrees::kInclude;
  const bool are_drawn = wishes_.dead_wood && !includes;
  const bool are_left_out = wishes_.leaves_out_dead && !includes;
  const bool are_found = wishes_.finds_dead && !includes;
  std::vector<std::size_t> used;
  std::vector<char> is_dead;
  data::TextColumn remains;
  for (const std::string& value : values.levels()) status.learn(value);
  for (std::size_t row = 0; row < values.size(); ++row) {
    const stand::TreeStatus found = status.read(values[row]);
    const bool is_alive = found == stand::TreeStatus::kAlive;
    if (found == stand::TreeStatus::kNotInSample || (are_left_out && !is_alive)) continue;
    used.push_back(row);
    is_dead.push_back(is_alive ? 0 : 1);
    remains.append(remains_of(found));
  }
  status.require_one_meaning(reader_.file());
  if (status.dead() + status.gone() + status.not_in_sample() == 0 && status.remarks().empty()) {
    return;
  }
  note(fmt::format(
      "the status of trees is read from column {}: {} dead, {} cut or gone, {}{}",
      *column,
      status.dead(),
      status.gone(),
      are_left_out ? "which are skipped; `dead=include` uses them"
      : are_found  ? "which models do not use and whose values are not filled in; `dead=include` "
                     "treats them as living"
      : are_drawn  ? "which are drawn as snags, stumps and logs"
                   : "which are used as living trees",
      status.remarks()));
  if (used.size() < values.size()) result_.table = result_.table.select(used);
  if (are_drawn) result_.table.set("remains", std::move(remains));
  const bool has_dead = std::ranges::find(is_dead, 1) != is_dead.end();
  if (are_found && has_dead) result_.is_dead = std::move(is_dead);
}

/// Rows of sums or means below a table are no trees: they are left out, or not used where the rows
/// of the file stay.
void TableReader::leave_out_sums() {
  if (wishes_.keeps_sums) return;
  data::Table& table = result_.table;
  std::vector<char> is_sum(table.rows(), 0);
  std::set<std::string, std::less<>> plots;
  for (const char* const name : {"plot", "tree", "species"}) {
    const auto fields =
        stand::fields_of(name, reader_.header(), wishes_.options.columns, reader_.file());
    if (fields.size() != 1) continue;
    const std::string& column = reader_.header()[fields.front()];
    if (!table.has(column) || table.is_numeric(column)) continue;
    const data::TextColumn& labels = table.text(column);
    const bool is_code = std::string_view(name) == "species";
    if (std::string_view(name) == "plot")
      plots.insert(labels.levels().begin(), labels.levels().end());
    const auto is_plot = [&plots](std::string_view text) { return plots.contains(text); };
    std::vector<char> is_word;
    for (const std::string& label : labels.levels()) {
      const bool is_sum_label =
          is_code ? stand::is_summary_label(label, true) : stand::is_summary_label(label, is_plot);
      is_word.push_back(is_sum_label ? 1 : 0);
    }
    for (std::size_t row = 0; row < labels.size(); ++row) {
      if (labels.is_missing(row) || is_word[labels.code(row)] == 0 || is_sum[row] != 0) continue;
      is_sum[row] = 1;
      if (state_.sums++ > 0) continue;
      state_.first_sum = describe(data::place_of(table, row, column), std::string(labels[row]));
    }
  }
  if (state_.sums == 0) return;
  note(fmt::format("{} of sums or means and {} {}, the first: {}",
                   counted(state_.sums, "row is", "rows are"),
                   state_.sums == 1 ? "is" : "are",
                   wishes_.finds_dead ? "neither used nor filled in" : "skipped",
                   state_.first_sum));
  if (wishes_.finds_dead) {
    result_.is_dead.resize(table.rows(), 0);
    std::ranges::transform(is_sum, result_.is_dead, result_.is_dead.begin(), std::bit_or<>());
    return;
  }
  std::vector<std::size_t> used;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (is_sum[row] == 0) used.push_back(row);
  }
  if (used.size() < table.rows()) table = table.select(used);
}

/// Builders read whole tables, so that a reader is told what they may have missed.
void TableReader::describe_unread() {
  if (!wishes_.wants_all || wishes_.state != nullptr) return;
  const auto& header = reader_.header();
  const auto& mapped = wishes_.options.columns;
  note(stand::describe_unread_columns(header, mapped, reader_.file()));
  const auto status = stand::status_column(
      header, result_.mapped, wishes_.options.status_codes, wishes_.options.dead, reader_.file());
  if (status) return;
  const Names read = columns_of_labels();
  for (const std::string& column : header) {
    const data::Table& table = result_.table;
    // A text in a measure is reported where it is read.
    const bool is_read = contains(read, column) || stand::is_measure(column) || column == "remains";
    if (!table.has(column) || table.is_numeric(column) || is_read) continue;
    stand::StatusWords words(column);
    words.add(table.text(column));
    note(words.note());
  }
}

/// The columns of plots, trees and units of plots, which are names.
Names TableReader::columns_of_labels() const {
  const auto& header = reader_.header();
  std::vector<std::size_t> fields = stand::fields_of_units(header);
  for (const char* const name : {"plot", "tree"}) {
    const auto own = stand::fields_of(name, header, wishes_.options.columns, reader_.file());
    fields.insert(fields.end(), own.begin(), own.end());
  }
  Names names;
  for (const std::size_t field : fields) names.push_back(header[field]);
  return names;
}

/// The rule for rows of one tree (docs/inventory.md), if it is the one of this reading.
void TableReader::resolve_repeated_rows(RepeatedRows rule) {
  if (wishes_.repeated != rule) return;
  data::Table& table = result_.table;
  const std::string plot = column_of("plot");
  const std::string tree = column_of("tree");
  if (!table.has(plot) || !table.has(tree)) return;
  if (rule == RepeatedRows::kObservations) {
    find_copies(plot, tree, result_, state_.repeated);
    for (std::string& text : state_.repeated.notes()) note(std::move(text));
  } else {
    const auto measure = [&](const std::string& name) -> std::vector<double> {
      const std::string column = column_of(name);
      const bool is_mapped = stand::mapping_to(name, result_.mapped) != nullptr;
      if (!is_mapped && !table.has(column)) return {};
      return stand::numbers_from(table, name, column);
    };
    const std::string species = column_of("species");
    keep_one_row_per_tree(table,
                          plot,
                          tree,
                          table.has(species) ? std::optional(species) : std::nullopt,
                          measure,
                          wishes_.options.trust_units,
                          state_.repeated_trees);
    for (std::string& text : state_.repeated_trees.notes()) note(std::move(text));
  }
}

/// As numbers, 001 and 1 are the same. Spellings of species are unified elsewhere, and numbers of
/// trees are compared within plots.
void TableReader::describe_labels() {
  if (wishes_.state != nullptr) return;
  const data::Table& table = result_.table;
  for (const std::string& name : wishes_.names) {
    const bool is_compared = name != "tree" && (name != "species" || wishes_.keeps_spellings);
    if (!is_compared || !table.has(name) || table.is_numeric(name)) continue;
    note(stand::describe_similar_labels(table.text(name), name));
  }
}

TableReader::Result TableReader::read() {
  find_columns();
  read_table();
  result_.has_fia_species = stand::may_have_fia_species(reader_.header());
  note(data::describe_layout(reader_.layout()));
  note(prepared_.note);
  Mappings renamed = usual_;
  renamed.insert(renamed.end(), converted_.begin(), converted_.end());
  note(stand::describe_usual_columns(renamed, reader_.header()));
  for (const stand::TreeColumn& column : stand::tree_columns()) {
    const std::string name(column.name);
    const stand::ColumnMapping* source = stand::mapping_to(name, renamed);
    const bool is_known = source != nullptr;
    if (!column.is_measure() || (!is_known && !wishes_.is_wanted(name))) continue;
    if (source == nullptr) source = stand::mapping_to(name, result_.mapped);
    if (source != nullptr) {
      find_missing_values(name, source->source, is_known || result_.table.has(source->source));
    } else if (contains(reader_.header(), name)) {
      find_missing_values(name, name, true);
    }
  }
  data::take_missing_codes(result_.table, state_.codes);
  note(state_.codes.note());
  if (const stand::ColumnMapping* const x = stand::mapping_to("x", usual_)) {
    stand::check_polar_positions(result_.table,
                                 x->source,
                                 reader_.header(),
                                 reader_.layout().units,
                                 wishes_.options.columns);
  }
  for (const stand::ColumnMapping& column : usual_) add_column(column);
  for (const char* const name : {"plot", "tree", "species"}) {
    const std::string column = column_of(name);
    if (!result_.table.has(column) || result_.table.is_numeric(column)) continue;
    stand::refuse_unusable_labels(result_.table.text(column), name, column, reader_.file());
  }
  result_.usual = usual_;
  for (const Mappings* const mappings : {&usual_, &result_.mapped}) {
    for (const auto& [name, source] : *mappings) {
      if (contains(reader_.header(), source)) result_.columns.emplace(name, source);
    }
  }
  find_missing_species();
  if (!wishes_.keeps_spellings) unify_spellings();
  // The last visit of a plot may have found dead trees only.
  resolve_repeated_rows(RepeatedRows::kOneOfEachTree);
  leave_out_remains();
  read_status();
  leave_out_sums();
  describe_unread();
  describe_labels();
  if (!wishes_.random.empty() && wishes_.state == nullptr) {
    for (std::string& text : describe_recurring_groups(
             result_.table, reader_.header(), wishes_.options.columns, wishes_.random)) {
      note(std::move(text));
    }
  }
  resolve_repeated_rows(RepeatedRows::kObservations);
  return std::move(result_);
}

}  // namespace

std::map<std::string, std::string> column_map(const std::vector<std::string>& entries) {
  std::map<std::string, std::string> map;
  for (stand::ColumnMapping& mapping : stand::parse_column_mappings(entries)) {
    map.emplace(std::move(mapping.name), std::move(mapping.source));
  }
  return map;
}

ReadTable read_tree_table(const data::TableSource& source,
                          const ReadingSettings& settings,
                          const std::string& by,
                          std::map<std::string, std::string>& columns,
                          const NoteCallback& note,
                          ReadingState* state,
                          bool dead_wood) {
  columns = column_map(settings.columns);
  Wishes wishes{{.names = {"plot", "tree", "species"}, .state = state},
                inventory_options(settings),
                true,
                !dead_wood,
                dead_wood,
                by.empty() ? RepeatedRows::kOneOfEachTree : RepeatedRows::kAll};
  std::ranges::sort(wishes.options.columns, {}, &stand::ColumnMapping::name);
  TableReader::Result result = TableReader(source, wishes).read();
  // Joined labels are columns of our names now.
  std::erase_if(columns, [&result](const auto& entry) {
    return stand::mapping_to(entry.first, result.mapped) == nullptr;
  });
  for (const stand::ColumnMapping& mapping : result.mapped) columns[mapping.name] = mapping.source;
  ReadingState own;
  ReadingState& of_parts = state == nullptr ? own : *state;
  check_sizes(result.table,
              sizes_in(result.table, result.mapped, result.usual, false),
              settings.trust_units,
              of_parts,
              result.recognized);
  if (settings.terrain) {
    set_elevations(*settings.terrain,
                   result.table,
                   columns,
                   state == nullptr,
                   of_parts.off_terrain,
                   result.recognized);
  }
  // The status does not affect a tree's shape, and these are positions now.
  for (const char* const read : {"status", "azimuth", "distance", "x0", "y0"}) columns.erase(read);
  give_notes(result.recognized, note);
  return static_cast<ReadTable&&>(result);
}

ObservedTable read_model_table(const data::TableSource& source,
                               const ReadingSettings& settings,
                               const ModelColumns& columns,
                               const NoteCallback& note) {
  const Wishes wishes{columns, inventory_options(settings)};
  TableReader::Result result = TableReader(source, wishes).read();
  const Names computed = add_columns(result.mapped, result.table, columns.units);
  ReadingState own;
  ReadingState& state = columns.state == nullptr ? own : *columns.state;
  for (const std::string& text : computed) ++state.computed[text];
  for (const auto& [text, parts] : state.computed) result.recognized.push_back(text);
  TableSizes sizes = sizes_in(result.table, result.mapped, result.usual, true);
  // Sums are larger than any tree.
  for (std::vector<double>& values : sizes.values) {
    for (std::size_t row = 0; row < result.is_dead.size(); ++row) {
      if (result.is_dead[row] != 0) values[row] = data::kMissing;
    }
  }
  check_sizes(result.table, sizes, settings.trust_units, state, result.recognized);
  give_notes(result.recognized, note);
  return static_cast<ObservedTable&&>(result);
}

}  // namespace silvafit::study
