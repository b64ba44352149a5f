// SPDX-License-Identifier: MIT
#include "workflow/assumed_sizes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "silvafit/base/text.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/program.hpp"

namespace silvafit::study {
namespace {

/// What is drawn where nothing was measured. Naslund's curve with values between those of published
/// curves of closed temperate stands (16 m at 20 cm, 22 m at 40 cm); half of the height has a
/// crown; crown widths of forest trees are about 20 times the diameter, and more of thin ones.
constexpr std::array<std::array<const char*, 2>, 3> kAssumed{
    {{"h", "1.3 + dbh^2/(0.19*dbh + 1.5)^2"}, {"hcb", "0.5*h"}, {"cw", "0.6 + 0.16*dbh"}}};

class Completion {
 public:
  Completion(data::Table& table, std::map<std::string, std::string>& columns)
      : table_(table), columns_(columns) {}

  std::optional<std::vector<double>> numbers(const std::string& name) const {
    const auto mapped = columns_.find(name);
    if (mapped == columns_.end() && !table_.has(name)) {
      return std::vector<double>(table_.rows(), data::kMissing);
    }
    const std::string source = mapped == columns_.end() ? name : mapped->second;
    std::vector<data::TextCell> unreadable;
    const auto reference = data::column_reference(name, source, table_.names(), table_.file());
    std::vector<double> values = data::numbers_of(table_, reference, unreadable);
    if (!unreadable.empty()) return std::nullopt;
    return values;
  }

  bool has_radii(std::size_t row) {
    if (!radii_) {
      radii_.emplace();
      for (const char* name : {"cr_e", "cr_w", "cr_s", "cr_n"}) {
        radii_->push_back(numbers(name).value_or(std::vector<double>(table_.rows(), 0.0)));
      }
    }
    return std::ranges::none_of(
        *radii_, [row](const std::vector<double>& radius) { return std::isnan(radius[row]); });
  }

  /// \return the number of values that are assumed
  std::size_t complete(const std::string& name, const char* formula, data::Table& known) {
    auto values = numbers(name);
    if (!values) return 0;
    const std::vector<double> assumed = data::evaluate(data::Expression::parse(formula), known);
    std::size_t count = 0;
    for (std::size_t row = 0; row < values->size(); ++row) {
      double& value = (*values)[row];
      const bool is_lacking = std::isnan(value) && std::isfinite(assumed[row]);
      if (!is_lacking || (name == "cw" && has_radii(row))) continue;
      value = assumed[row];
      ++count;
    }
    known.set(name, *values);
    if (count == 0) return 0;
    columns_.erase(name);
    table_.set(name, std::move(*values));
    return count;
  }

 private:
  data::Table& table_;
  std::map<std::string, std::string>& columns_;
  std::optional<std::vector<std::vector<double>>> radii_{};
};

}  // namespace

void assume_sizes(data::Table& table,
                  std::map<std::string, std::string>& columns,
                  AssumedSizes& counts) {
  Completion completion(table, columns);
  auto dbh = completion.numbers("dbh");
  if (!dbh) return;
  for (double& value : *dbh) {
    if (!(value > 0.0)) value = data::kMissing;
  }
  data::Table known(table.rows());
  known.set("dbh", std::move(*dbh));
  for (std::size_t k = 0; k < kAssumed.size(); ++k) {
    const auto& [name, formula] = kAssumed[k];
    counts[k] += completion.complete(name, formula, known);
  }
}

std::string note_on(const AssumedSizes& counts) {
  std::vector<std::string> texts;
  for (std::size_t k = 0; k < kAssumed.size(); ++k) {
    if (counts[k] == 0) continue;
    const auto& [name, formula] = kAssumed[k];
    texts.push_back(
        fmt::format("{} of {}: {}", name, counted(counts[k], "tree", "trees"), formula));
  }
  if (texts.empty()) return {};
  return fmt::format(
      "not measured, and assumed for the picture: {}; `silvafit impute` fits curves "
      "to measured trees",
      fmt::join(texts, ", "));
}

void assume_labels(data::Table& table, const std::map<std::string, std::string>& columns) {
  const auto lacks = [&](const char* name) { return !table.has(name) && !columns.contains(name); };
  const auto set = [&table](const char* name, const auto& label_of) {
    data::TextColumn labels;
    for (std::size_t row = 0; row < table.rows(); ++row) labels.append(label_of(row));
    table.set(name, std::move(labels));
  };
  if (lacks("plot")) set("plot", [](std::size_t) { return std::string("1"); });
  if (lacks("tree")) set("tree", [](std::size_t row) { return std::to_string(row + 1); });
}

}  // namespace silvafit::study
