// SPDX-License-Identifier: MIT
// `silvafit grow`: trees and stands as GLB, glTF, OBJ or PLY.
#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "grow_command.hpp"
#include "output_files.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/tree/lsystem_builder.hpp"
#include "tree_table.hpp"

namespace silvafit::cli {
namespace {

tree::MorphologyTableOptions table_options(const GrowCommand& command) {
  return {.use = tree::use_from_text(command.use),
          .columns = column_map(command.columns),
          .plots = command.plots,
          .needs_position = !command.scene.empty() || command.resolve_overlaps};
}

/// All trees of the table at one time, or the trees of each moment.
tree::Moments read_trees(const GrowCommand& command) {
  tree::MorphologyTableOptions options = table_options(command);
  const data::Table table =
      read_tree_table(command.file, options.columns, command.sheet, command.common).table;
  if (!command.by.empty()) return tree::read_moments(table, command.by, options);
  tree::MorphologyTable read = tree::read_morphologies(table, options);
  tree::Moments one{.left_out = std::move(read.left_out)};
  if (!read.morphologies.empty()) one.moments.push_back({.trees = std::move(read.morphologies)});
  return one;
}

/// The preset of the L-system builder with the user's grammar; null if none is given.
std::unique_ptr<const tree::Builder> builder_with_grammar(const tree::BuilderCatalogue& catalogue,
                                                          const GrowCommand& command) {
  if (command.grammar.empty()) return nullptr;
  const tree::Builder& looks = command.preset.empty()
                                   ? catalogue.fallback(command.builder)
                                   : catalogue.named(command.builder, command.preset);
  return dynamic_cast<const tree::LsystemBuilder&>(looks).with_grammar(
      tree::Grammar::load(command.grammar));
}

/// Output for all moments together.
struct Sequence {
  GrowResult result{};
  std::vector<tree::Morphology> morphologies{};
  std::unique_ptr<const tree::Builder> with_grammar{};
};

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
  all.builders.insert(all.builders.end(), part.builders.begin(), part.builders.end());
  all.files.insert(all.files.end(), part.files.begin(), part.files.end());
  all.shared = std::move(part.shared);
  for (const std::size_t tree : part.with_guesses) all.with_guesses.push_back(before + tree);
  for (const std::size_t tree : part.crossing) all.crossing.push_back(before + tree);
}

Sequence grow_moments(const GrowCommand& command,
                      const std::vector<tree::Moment>& moments,
                      const tree::BuilderCatalogue& catalogue) {
  Sequence all;
  for (const tree::Moment& moment : moments) {
    all.morphologies.insert(all.morphologies.end(), moment.trees.begin(), moment.trees.end());
  }
  all.with_grammar = builder_with_grammar(catalogue, command);
  if (command.animate) {
    all.result =
        write_animation(command, moments, all.morphologies, catalogue, all.with_grammar.get());
    return all;
  }
  std::size_t before = 0;
  for (const tree::Moment& moment : moments) {
    GrowCommand one = command.by.empty() ? command : of_moment(command, moment);
    // Messages about species would be repeated.
    one.common.quiet = command.common.quiet || before > 0;
    append(grow_trees(one, moment.trees, all.morphologies, catalogue, all.with_grammar.get()),
           moment.name,
           before,
           all.result);
    before += moment.trees.size();
  }
  return all;
}

void run(GrowCommand& command) {
  check_and_complete(command);
  refuse_same_files({{"MORPHOLOGY.csv", command.file}, {"--grammar", command.grammar}},
                    {{"--scene", command.scene}});
  const auto start = std::chrono::steady_clock::now();
  const auto catalogue = tree::BuilderCatalogue::load(data_directory() / "models");
  const tree::Moments table = read_trees(command);
  report_left_out(command, table.left_out);
  if (table.moments.empty()) {
    throw InputError("no row can be used to grow a tree", {.file = command.file});
  }
  report_coinciding_plots(command, table.moments);
  std::optional<ResultFolder> results;
  if (!command.out.empty()) results.emplace(command.out);
  const Sequence all = grow_moments(command, table.moments, catalogue);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  report_grown(
      command, all.result, all.morphologies, table.moments.size(), table.left_out, seconds.count());
}

}  // namespace

void add_grow_command(CLI::App& program) {
  auto options = std::make_shared<GrowCommand>();
  CLI::App* command =
      program.add_subcommand("grow", "Grow measured or predicted trees as 3D models");
  add_grow_options(*command, *options);
  add_common_options(*command, options->common);
  add_example(*command,
              "silvafit grow examples/fir-mixed/inventory.csv --plot 1 --scene plot1.glb");
  command->callback([options] { run(*options); });
}

}  // namespace silvafit::cli
