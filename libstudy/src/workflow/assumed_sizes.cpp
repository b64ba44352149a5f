// SPDX-License-Identifier: MIT
#include "workflow/assumed_sizes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "silvafit/base/text.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/tree/morphology_table.hpp"
#include "workflow/mapped_numbers.hpp"

namespace silvafit::study {
namespace {

/// What is drawn where nothing was measured. Naslund's curve with values between those of published
/// curves of closed temperate stands (16 m at 20 cm, 22 m at 40 cm); half of the height has a
/// crown; crown widths of forest trees are about 20 times the diameter, and more of thin ones. Of a
/// tree whose crown base was measured above this height, the height is twice the crown base; of one
/// with some measured radii, the width is twice their mean.
constexpr std::array<std::array<const char*, 2>, 3> kAssumed{
    {{"h", "1.3 + dbh^2/(0.19*dbh + 1.5)^2"}, {"hcb", "0.5*h"}, {"cw", "0.6 + 0.16*dbh"}}};

class Completion {
 public:
  Completion(data::Table& table, std::map<std::string, std::string>& columns)
      : table_(table), columns_(columns), hcb_(numbers("hcb")), assumed_(table.rows()) {}

  /// Cells with texts are reported where trees are read.
  std::vector<double> numbers(const std::string& name) const {
    std::vector<data::TextCell> ignored;
    return mapped_numbers(table_, columns_, name, ignored);
  }

  /// \param number     of the size
  /// \param[out] count  is increased by the values that are assumed
  void complete(std::size_t number, data::Table& known, AssumedSizes& count) {
    const std::string name = kAssumed[number][0];
    const char* const formula = kAssumed[number][1];
    std::vector<data::TextCell> texts;
    std::vector<double> values = mapped_numbers(table_, columns_, name, texts);
    std::vector<char> is_text(values.size(), 0);
    for (const data::TextCell& cell : texts) is_text[cell.row] = 1;
    const std::vector<double> usual = data::evaluate(data::Expression::parse(formula), known);
    bool is_complete = true;
    for (std::size_t row = 0; row < values.size(); ++row) {
      double& value = values[row];
      const bool is_lacking = std::isnan(value) && is_text[row] == 0 && std::isfinite(usual[row]);
      const std::vector<double> of_crown = name == "cw" ? radii(row) : std::vector<double>();
      if (!is_lacking || of_crown.size() == kRadii.size()) continue;
      value = usual[row];
      // What was measured of the tree is not contradicted.
      if (name == "h" && hcb_[row] >= value) value = 2.0 * hcb_[row];
      if (!of_crown.empty()) value = 2.0 * mean(of_crown);
      assumed_[row] += (assumed_[row].empty() ? "" : ", ") + name;
      ++(of_crown.empty() ? count.by_dbh[number] : count.by_radii);
      is_complete = false;
    }
    known.set(name, values);
    if (is_complete) return;
    columns_.erase(name);
    if (texts.empty()) {
      table_.set(name, std::move(values));
    } else {
      table_.set(name, with_texts(values, texts));
    }
  }

  /// Sets the column of the sizes that are assumed.
  void mark() {
    data::TextColumn names;
    for (const std::string& each : assumed_) names.append(each);
    table_.set(tree::kAssumedColumn, std::move(names));
  }

 private:
  static constexpr std::array<const char*, 4> kRadii{"cr_e", "cr_w", "cr_s", "cr_n"};

  /// A column that keeps the cells that are no numbers.
  static data::TextColumn with_texts(const std::vector<double>& values,
                                     const std::vector<data::TextCell>& texts) {
    data::TextColumn column;
    auto text = texts.begin();
    for (std::size_t row = 0; row < values.size(); ++row) {
      while (text != texts.end() && text->row < row) ++text;
      if (text != texts.end() && text->row == row) {
        column.append(text->text);
      } else if (std::isnan(values[row])) {
        column.append_missing();
      } else {
        column.append(data::shortest(values[row]));
      }
    }
    return column;
  }

  static double mean(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  }

  /// The measured ones of the four radii.
  std::vector<double> radii(std::size_t row) {
    if (!radii_) {
      radii_.emplace();
      for (const char* name : kRadii) radii_->push_back(numbers(name));
    }
    std::vector<double> measured;
    for (const std::vector<double>& radius : *radii_) {
      if (!std::isnan(radius[row])) measured.push_back(radius[row]);
    }
    return measured;
  }

  data::Table& table_;
  std::map<std::string, std::string>& columns_;
  std::vector<double> hcb_;
  std::vector<std::string> assumed_;
  std::optional<std::vector<std::vector<double>>> radii_{};
};

}  // namespace

void assume_sizes(data::Table& table,
                  std::map<std::string, std::string>& columns,
                  AssumedSizes& counts) {
  Completion completion(table, columns);
  std::vector<double> dbh = completion.numbers("dbh");
  for (double& value : dbh) {
    if (!(value > 0.0)) value = data::kMissing;
  }
  data::Table known(table.rows());
  known.set("dbh", std::move(dbh));
  for (std::size_t k = 0; k < kAssumed.size(); ++k) completion.complete(k, known, counts);
  completion.mark();
}

std::string note_on_predictions(const data::Table& table) {
  if (!table.has("h_pred")) return {};
  return "the predictions of h_pred and others are not drawn; use `use=pred`";
}

std::string note_on(const AssumedSizes& counts) {
  std::vector<std::string> texts;
  for (std::size_t k = 0; k < kAssumed.size(); ++k) {
    if (counts.by_dbh[k] == 0) continue;
    const auto& [name, formula] = kAssumed[k];
    texts.push_back(
        fmt::format("{} of {}: {}", name, counted(counts.by_dbh[k], "tree", "trees"), formula));
  }
  if (counts.by_radii > 0) {
    texts.push_back(fmt::format("cw of {}: twice the mean of the measured radii",
                                counted(counts.by_radii, "tree", "trees")));
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
