// SPDX-License-Identifier: MIT
// The output of `silvafit grow`.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "grow_command.hpp"
#include "silvafit/base/text.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

/// Such as ", with trees.mtl, bark.png, leaf.png and 2 more in the same folder"; empty for a single
/// file.
std::string beside_text(const study::WrittenScene& written) {
  if (written.beside.empty()) return {};
  constexpr std::size_t kNamed = 3;
  const std::size_t named = std::min(kNamed, written.beside.size());
  std::vector<std::string> names;
  for (std::size_t i = 0; i < named; ++i) {
    names.push_back(std::filesystem::path(written.beside[i]).filename().string());
  }
  const std::size_t more = written.beside.size() - named;
  return fmt::format(", with {}{} in the same folder",
                     fmt::join(names, ", "),
                     more > 0 ? fmt::format(" and {} more", more) : "");
}

/// The written files: one file in one line, several files each in its own line.
void print_files(const study::GrowResult& result) {
  const std::string stand = counted(result.counts.trees, "tree", "trees");
  if (result.files.size() == 1) {
    const study::WrittenScene& only = result.files.front();
    print_text("{}, {} triangles, {:.2f} s: {}{}\n",
               stand,
               only.triangles,
               result.seconds,
               only.name,
               beside_text(only));
    return;
  }
  const std::string times = result.moments > 1 ? fmt::format(" at {} times", result.moments) : "";
  print_text("{}{}, {:.2f} s:\n", stand, times, result.seconds);
  constexpr std::size_t kShown = 40;
  for (std::size_t i = 0; i < std::min(kShown, result.files.size()); ++i) {
    const study::WrittenScene& one = result.files[i];
    print_text("  {}: {}, {} triangles{}\n",
               one.name,
               counted(one.trees, "tree", "trees"),
               one.triangles,
               beside_text(one));
  }
  if (result.files.size() > kShown) {
    print_text("  ... and {} more; use {} to list all\n",
               result.files.size() - kShown,
               result.settings.stream ? "--manifest" : "--json");
  }
}

}  // namespace

void report_grown(const CommonOptions& common, const study::GrowResult& result) {
  if (common.json) {
    print_json_value(study::json_of(result), -1);
    return;
  }
  const study::GrowCounts& counts = result.counts;
  const std::string how = result.settings.stream ? "." : "; use --json to list them.";
  print_files(result);
  if (result.settings.share) {
    const tree::ShapeError worst = study::worst_of(result.shared);
    print_text("{}; largest errors: crown base {:.0f} cm, DBH {:.1f} cm, crown radius {:.0f} cm\n",
               counted(result.shared.models.size(), "model", "models"),
               worst.hcb_cm,
               worst.dbh_cm,
               worst.radius_cm);
  }
  if (result.settings.resolve_overlaps)
    print_text("{} overlapped\n", counted(counts.overlaps, "pair of crowns", "pairs of crowns"));
  if (counts.crossing > 0) {
    say(common,
        counted(counts.crossing, "tree is", "trees are") +
            " too close to others to separate all branches" + how);
  }
  if (counts.with_guesses > 0) {
    std::vector<std::string> replaced;
    for (const auto& [name, count] : counts.guesses) {
      replaced.push_back(fmt::format("{} of {}", name, count));
    }
    say(common,
        fmt::format("{} missing measurements, for which defaults are used ({}){}",
                    counted(counts.with_guesses, "tree has", "trees have"),
                    fmt::join(replaced, ", "),
                    how));
  }
}

}  // namespace silvafit::cli
