// SPDX-License-Identifier: MIT
// Volume, biomass and carbon of trees by the equations that settings name.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/study/tree_equations.hpp"
#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/taper.hpp"

namespace silvafit::study {
namespace {

constexpr std::string_view kTaper = "taper";

std::string lower_case(std::string_view text) {
  std::string result(text);
  std::ranges::transform(
      result, result.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

bool is_ours(const std::string& column) {
  return stand::is_measure(column) || stand::is_label(column);
}

/// `ID` or `SPECIES=ID`.
struct NamedEquation {
  std::string species{};
  std::string id{};
};

NamedEquation named_equation(const std::string& text) {
  const std::size_t sign = text.rfind('=');
  if (sign == std::string::npos) return {.id = text};
  return {.species = text.substr(0, sign), .id = text.substr(sign + 1)};
}

TreeEquations equations_of(const EquationSettings& settings) {
  TreeEquations equations = TreeEquations::load(settings.models);
  for (const std::string& file : settings.files) equations.add(file);
  return equations;
}

/// The equations of one quantity. Null: the taper equation.
struct QuantityPlan {
  std::string name{};
  std::string unit{};
  std::map<std::string, const TreeEquation*> of_species{};  ///< in small letters
  std::set<std::string> seen{};                             ///< species of trees, the same
  std::vector<const TreeEquation*> of_all{};

  // Counts of trees, for notes.
  /// By equation in the order of the catalogue: outside of each range of its domain.
  std::map<const TreeEquation*, std::vector<std::size_t>> outside{};
  /// Species of trees that an equation is used for, although it lists others.
  std::map<const TreeEquation*, std::set<std::string>> unlisted{};
  std::size_t without_value = 0;  ///< that the equation needs
  std::size_t without_equation = 0;
  std::size_t not_positive = 0;
};

class QuantityMaker {
 public:
  explicit QuantityMaker(const EquationSettings& settings)
      : settings_(settings), equations_(equations_of(settings)) {
    plan();
  }

  std::vector<stand::TreeQuantity> add(const data::Table& trees);
  std::vector<std::string> notes() const;

 private:
  void plan();
  QuantityPlan& plan_of(const std::string& name, const std::string& unit);
  std::optional<const TreeEquation*> equation_for(const QuantityPlan& plan,
                                                  const std::string& species) const;
  static void note_unlisted(const std::string& species,
                            const TreeEquation* equation,
                            QuantityPlan& plan);
  stand::TreeQuantity compute(QuantityPlan& plan);
  std::vector<double> values_of(const TreeEquation& equation) const;
  std::vector<double> taper_volumes(const std::vector<std::size_t>& rows) const;
  void count_outside(const TreeEquation& equation,
                     const std::vector<std::size_t>& rows,
                     QuantityPlan& plan) const;
  static void note_domain(const TreeEquation& equation,
                          const std::vector<std::size_t>& outside,
                          std::vector<std::string>& notes);
  std::string species_of(std::size_t row) const {
    return species_.size() == 0 ? std::string() : std::string(species_[row]);
  }

  data::Table table_{};
  EquationSettings settings_;
  TreeEquations equations_;
  data::TextColumn species_{};
  std::vector<QuantityPlan> plans_{};
};

QuantityPlan& QuantityMaker::plan_of(const std::string& name, const std::string& unit) {
  const auto found = std::ranges::find(plans_, name, &QuantityPlan::name);
  if (found == plans_.end()) return plans_.emplace_back(QuantityPlan{.name = name, .unit = unit});
  if (found->unit == unit) return *found;
  throw UsageError(fmt::format("equations of {} have the units {} and {}", name, found->unit, unit),
                   {.column = "`equations`"});
}

void QuantityMaker::plan() {
  for (const std::string& text : settings_.equations) {
    const NamedEquation named = named_equation(text);
    const TreeEquation* const equation = named.id == kTaper ? nullptr : &equations_.find(named.id);
    QuantityPlan& plan =
        equation == nullptr ? plan_of("volume", "m3") : plan_of(equation->quantity, equation->unit);
    if (named.species.empty()) {
      plan.of_all.push_back(equation);
    } else if (!plan.of_species.try_emplace(lower_case(named.species), equation).second) {
      throw UsageError(
          fmt::format("two equations of {} for species '{}'", plan.name, named.species),
          {.column = "`equations`"});
    }
  }
  const auto is_general = [](const TreeEquation* one) {
    return one == nullptr || one->species.empty();
  };
  for (const QuantityPlan& plan : plans_) {
    if (plan.of_all.size() < 2 || std::ranges::count_if(plan.of_all, is_general) < 2) continue;
    throw UsageError(fmt::format("two equations of {} for all species; give SPECIES=ID", plan.name),
                     {.column = "`equations`"});
  }
}

/// Of the equations for all species, one that lists the species has priority over one without a
/// list; a single equation is used for all species, even if it lists others.
std::optional<const TreeEquation*> QuantityMaker::equation_for(const QuantityPlan& plan,
                                                               const std::string& species) const {
  const std::string key = lower_case(species);
  if (const auto own = plan.of_species.find(key); own != plan.of_species.end()) return own->second;
  for (const TreeEquation* const equation : plan.of_all) {
    if (equation == nullptr) continue;
    for (const std::string& name : equation->species) {
      if (lower_case(name) == key) return equation;
    }
  }
  for (const TreeEquation* const equation : plan.of_all) {
    if (equation == nullptr || equation->species.empty()) return equation;
  }
  if (plan.of_all.size() == 1) return plan.of_all.front();
  return std::nullopt;
}

void QuantityMaker::note_unlisted(const std::string& species,
                                  const TreeEquation* equation,
                                  QuantityPlan& plan) {
  const std::string key = lower_case(species);
  const auto is_it = [&key](const std::string& name) { return lower_case(name) == key; };
  // The user has chosen the equation for the species, or the equation is for all.
  if (equation == nullptr || equation->species.empty() || plan.of_species.contains(key)) return;
  if (species.empty() || std::ranges::any_of(equation->species, is_it)) return;
  plan.unlisted[equation].insert(species);
}

std::vector<double> QuantityMaker::values_of(const TreeEquation& equation) const {
  for (const std::string& column : data::columns_of(equation.value)) {
    if (table_.has(column)) continue;
    throw InputError(
        fmt::format("equation {} needs the column {}: {}", equation.id, column, equation.formula),
        {.file = table_.file(), .column = column});
  }
  return data::evaluate(equation.value, table_);
}

std::vector<double> QuantityMaker::taper_volumes(const std::vector<std::size_t>& rows) const {
  const auto catalogue = tree::BuilderCatalogue::load(settings_.models);
  std::map<std::string, const tree::Taper*> taper_of;
  std::vector<double> volumes(table_.rows(), data::kMissing);
  if (!table_.has("h") || !table_.has("dbh")) {
    throw InputError("the volume by a taper equation needs the columns dbh and h",
                     {.file = table_.file(), .column = "h"});
  }
  const std::span<const double> dbh_cm = table_.numbers("dbh");
  const std::span<const double> h_m = table_.numbers("h");
  constexpr auto kKind = tree::BuilderKind::kSegment;
  for (const std::size_t row : rows) {
    const bool is_known = dbh_cm[row] > 0.0 && h_m[row] > 1.3;
    if (!is_known || std::isinf(dbh_cm[row]) || std::isinf(h_m[row])) continue;
    const auto [taper, is_new] = taper_of.try_emplace(species_of(row), nullptr);
    if (is_new) {
      taper->second = &catalogue.choose(kKind, taper->first).builder->preset().taper;
    }
    volumes[row] = tree::stem_volume_m3(*taper->second, h_m[row], dbh_cm[row]);
  }
  return volumes;
}

void QuantityMaker::count_outside(const TreeEquation& equation,
                                  const std::vector<std::size_t>& rows,
                                  QuantityPlan& plan) const {
  std::vector<std::size_t>& outside = plan.outside[&equation];
  outside.resize(equation.domain.size());
  for (std::size_t i = 0; i < outside.size(); ++i) {
    const EquationRange& range = equation.domain[i];
    if (!table_.has(range.column) || !table_.is_numeric(range.column)) continue;
    const std::span<const double> values = table_.numbers(range.column);
    outside[i] += static_cast<std::size_t>(std::ranges::count_if(rows, [&](std::size_t row) {
      return values[row] < range.low || values[row] > range.high;
    }));
  }
}

void QuantityMaker::note_domain(const TreeEquation& equation,
                                const std::vector<std::size_t>& outside,
                                std::vector<std::string>& notes) {
  for (std::size_t i = 0; i < outside.size(); ++i) {
    if (outside[i] == 0) continue;
    const EquationRange& range = equation.domain[i];
    notes.push_back(fmt::format("{} outside the domain of {}, {} {} to {}, and {} extrapolated",
                                counted(outside[i], "tree is", "trees are"),
                                equation.id,
                                range.column,
                                range.low,
                                range.high,
                                outside[i] == 1 ? "its value is" : "their values are"));
  }
}

stand::TreeQuantity QuantityMaker::compute(QuantityPlan& plan) {
  std::map<const TreeEquation*, std::vector<std::size_t>> rows_of;
  std::map<std::string, std::optional<const TreeEquation*>> equation_of;
  std::size_t without_equation = 0;
  for (std::size_t row = 0; row < table_.rows(); ++row) {
    const std::string species = species_of(row);
    const auto [equation, is_new] = equation_of.try_emplace(species);
    if (is_new) {
      equation->second = equation_for(plan, species);
      plan.seen.insert(lower_case(species));
      note_unlisted(species, equation->second.value_or(nullptr), plan);
    }
    if (equation->second) {
      rows_of[*equation->second].push_back(row);
    } else {
      ++without_equation;
    }
  }
  std::vector<double> values(table_.rows(), data::kMissing);
  std::size_t not_positive = 0;
  for (const auto& [equation, rows] : rows_of) {
    const std::vector<double> own =
        equation == nullptr ? taper_volumes(rows) : values_of(*equation);
    for (const std::size_t row : rows) {
      if (own[row] > 0.0 && std::isfinite(own[row])) {
        values[row] = own[row];
      } else if (!std::isnan(own[row])) {
        ++not_positive;
      }
    }
    if (equation != nullptr) count_outside(*equation, rows, plan);
  }
  plan.without_value += static_cast<std::size_t>(std::ranges::count_if(
                            values, [](double value) { return std::isnan(value); })) -
                        without_equation - not_positive;
  plan.without_equation += without_equation;
  plan.not_positive += not_positive;
  if (!table_.has(plan.name)) table_.set(plan.name, values);
  return {.name = plan.name, .unit = plan.unit, .values = std::move(values)};
}

std::vector<stand::TreeQuantity> QuantityMaker::add(const data::Table& trees) {
  table_ = trees;
  species_ = table_.has("species") ? table_.labels("species") : data::TextColumn();
  std::vector<stand::TreeQuantity> quantities;
  for (QuantityPlan& plan : plans_) quantities.push_back(compute(plan));
  return quantities;
}

std::vector<std::string> QuantityMaker::notes() const {
  std::vector<std::string> notes;
  for (const QuantityPlan& plan : plans_) {
    for (const auto& [equation, outside] : plan.outside) note_domain(*equation, outside, notes);
    for (const auto& [equation, species] : plan.unlisted) {
      notes.push_back(fmt::format("equation {} is of {} and is used for other species: {}",
                                  equation->id,
                                  equation->species.front(),
                                  data::list_of(std::vector(species.begin(), species.end()))));
    }
    for (const auto& [species, equation] : plan.of_species) {
      if (plan.seen.contains(species)) continue;
      notes.push_back(fmt::format("no tree has the species '{}' of `equations`", species));
    }
    const auto note = [&](std::size_t count, std::string_view why) {
      if (count == 0) return;
      notes.push_back(
          fmt::format("{} no {}: {}", counted(count, "tree has", "trees have"), plan.name, why));
    };
    note(plan.without_value,
         "a value that the equation needs is missing; `silvafit impute` fills heights");
    note(plan.without_equation, "no equation lists the species; give SPECIES=ID in `equations`");
    note(plan.not_positive, "the equation gives 0 or less");
  }
  return notes;
}

}  // namespace

TreeQuantities tree_quantities(const data::Table& trees, const EquationSettings& settings) {
  if (settings.equations.empty()) return {};
  QuantitiesOfParts parts(settings);
  std::vector<stand::TreeQuantity> quantities = parts.add(trees);
  return {.quantities = std::move(quantities), .notes = parts.notes()};
}

struct QuantitiesOfParts::State {
  QuantityMaker maker;
};

QuantitiesOfParts::QuantitiesOfParts(const EquationSettings& settings)
    : state_(std::make_unique<State>(State{QuantityMaker(settings)})) {}
QuantitiesOfParts::~QuantitiesOfParts() = default;
QuantitiesOfParts::QuantitiesOfParts(QuantitiesOfParts&&) noexcept = default;
QuantitiesOfParts& QuantitiesOfParts::operator=(QuantitiesOfParts&&) noexcept = default;

std::vector<stand::TreeQuantity> QuantitiesOfParts::add(const data::Table& trees) {
  return state_->maker.add(trees);
}

std::vector<std::string> QuantitiesOfParts::notes() const { return state_->maker.notes(); }

std::vector<std::string> columns_of(const EquationSettings& settings) {
  std::vector<std::string> columns;
  if (settings.equations.empty()) return columns;
  const TreeEquations equations = equations_of(settings);
  std::set<std::string> quantities;
  for (const std::string& text : settings.equations) {
    const NamedEquation named = named_equation(text);
    if (named.id == kTaper) {
      quantities.insert("volume");
      continue;
    }
    const TreeEquation& equation = equations.find(named.id);
    for (const std::string& column : data::columns_of(equation.value)) {
      const bool is_taken = std::ranges::find(columns, column) != columns.end();
      if (!is_ours(column) && !is_taken && !quantities.contains(column)) columns.push_back(column);
    }
    quantities.insert(equation.quantity);
  }
  return columns;
}

}  // namespace silvafit::study
