// SPDX-License-Identifier: MIT
#include "prediction/chosen_models.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <set>
#include <string_view>
#include <tuple>

#include "silvafit/base/error.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/study/structure_columns.hpp"
#include "silvafit/study/table_checks.hpp"

namespace silvafit::study {
namespace {

using Names = std::vector<std::string>;

bool is_listed(const std::string& name, const Names& names) {
  return std::ranges::find(names, name) != names.end();
}

/// The models of one response and species, the best first.
struct Candidates {
  std::string response{};
  std::string species{};
  std::vector<const LibraryModel*> models{};
  std::size_t chosen = 0;  ///< models.size(): none
  Names missing{};         ///< columns that the first model lacks

  bool has_model() const { return chosen < models.size(); }
  bool lacks_columns() const { return !missing.empty(); }
};

/// The place of a role among those of a study, the most complex one first.
std::size_t rank_of(const std::string& role) {
  return static_cast<std::size_t>(std::find(kRoles.rbegin(), kRoles.rend(), role) -
                                  kRoles.rbegin());
}

/// Whether a model may predict if models of a given role are requested.
bool may_stand_in(const LibraryModel& model, const std::string& role) {
  return model.role.empty() || rank_of(model.role) >= rank_of(role);
}

bool is_of_role(const LibraryModel& model, const std::string& role) {
  return model.role.empty() || model.role == role;
}

std::string described(const std::string& response, const std::string& species) {
  return response + (species.empty() ? "" : " for species " + species);
}

/// The name of a model in messages: its role in a study, or its name in the catalogue.
std::string name_of(const LibraryModel& model) {
  if (!model.role.empty()) return model.role;
  if (!model.fit.model.empty()) return model.fit.model;
  return model.response + " ~ " + model.fit.specification.formula.right.text();
}

Candidates& candidates_of(const LibraryModel& model, std::vector<Candidates>& all) {
  const auto is_its = [&model](const Candidates& each) {
    return each.response == model.response && each.species == model.species;
  };
  const auto found = std::ranges::find_if(all, is_its);
  if (found != all.end()) return *found;
  return all.emplace_back(Candidates{.response = model.response, .species = model.species});
}

/// Models of the role, in the order of the library.
std::vector<Candidates> all_candidates(const ModelLibrary& library,
                                       const std::string& role,
                                       Names& notes) {
  std::vector<Candidates> result;
  std::set<std::string> roles;
  for (const LibraryModel& model : library.models) {
    roles.insert(model.role);
    if (is_of_role(model, role)) {
      Candidates& candidates = candidates_of(model, result);
      if (model.fit.convergence.converged()) {
        candidates.models.push_back(&model);
      } else {
        notes.push_back(fmt::format("a model for {} is not used because its fit did not converge",
                                    described(model.response, model.species)));
      }
    }
  }
  if (result.empty()) {
    if (library.models.empty()) throw InputError("the library has no models");
    throw UsageError(fmt::format(
        "the library has no converged model with the role {}; choose one with `role`: {}",
        role,
        fmt::join(roles, ", ")));
  }
  for (const Candidates& each : result) {
    if (each.models.size() < 2) continue;
    notes.push_back(fmt::format("several models for {}: the one with the lowest AIC is used",
                                described(each.response, each.species)));
  }
  return result;
}

/// Adds converged models of simpler roles.
void add_stand_ins(const ModelLibrary& library,
                   const std::string& role,
                   std::vector<Candidates>& all) {
  for (Candidates& each : all) {
    if (each.models.empty()) continue;
    for (const LibraryModel& model : library.models) {
      const bool is_its = model.response == each.response && model.species == each.species;
      if (!is_its || is_of_role(model, role) || !may_stand_in(model, role)) continue;
      if (model.fit.convergence.converged()) each.models.push_back(&model);
    }
  }
}

void put_best_first(std::vector<Candidates>& all) {
  const auto place = [](const LibraryModel* model) {
    return std::tuple(model->role.empty() ? 0 : rank_of(model->role), model->fit.aic());
  };
  for (Candidates& each : all) std::ranges::stable_sort(each.models, {}, place);
}

/// Columns that a model reads and that are neither in the table nor predicted.
Names missing_columns(const LibraryModel& model,
                      const data::Table& table,
                      const std::set<std::string>& predicted) {
  Names missing;
  for (const std::string& variable : model.fit.specification.predictors()) {
    const std::string column = data::column_of(variable);
    const bool is_known = table.has(column) || predicted.contains(column);
    if (!is_known && !is_listed(column, missing)) missing.push_back(column);
  }
  return missing;
}

/// Chooses the first model of each response and species that has all its columns. A response
/// without a model is no column for other models any more, so this is repeated until nothing
/// changes.
void choose(const data::Table& table, std::vector<Candidates>& all) {
  for (bool has_changed = true; has_changed;) {
    has_changed = false;
    std::set<std::string> predicted;
    for (const Candidates& each : all) {
      if (each.has_model()) predicted.insert(each.response);
    }
    for (Candidates& each : all) {
      while (each.has_model()) {
        const Names missing = missing_columns(*each.models[each.chosen], table, predicted);
        if (missing.empty()) break;
        if (each.chosen == 0) each.missing = missing;
        ++each.chosen;
        has_changed = true;
      }
    }
  }
}

/// The error if no model has all its columns.
/// \param instead  a role whose models have them, or empty
[[noreturn]] void refuse(const std::vector<Candidates>& all,
                         const std::string& instead,
                         const data::Table& table) {
  Names indices;
  Names others;
  Names responses;  // predicted only by models that lack a column
  for (const Candidates& each : all) {
    for (const std::string& name : each.missing) {
      const bool is_response = std::ranges::find(all, name, &Candidates::response) != all.end();
      Names& names = is_structure_name(name) ? indices : is_response ? responses : others;
      if (!is_listed(name, names)) names.push_back(name);
    }
  }
  try {
    // Simpler models need no structural indices, but all need the measured columns.
    for (const Names* names : {&others, &indices, &responses}) require_numbers(table, *names);
  } catch (const InputError& error) {
    if (instead.empty()) throw;
    throw InputError(
        fmt::format("{}. The models of `role={}` do not need it", error.message(), instead),
        error.place());
  }
  throw InputError("no model of the library can be used", {.file = table.file()});
}

/// A note for each set of missing columns.
void add_notes(const ChosenModels& chosen, const data::Table& table, Names& notes) {
  std::map<Names, std::map<std::string, Names>> texts;  // columns, consequence, species
  for (const UnusedModel& unused : chosen.unused) {
    const std::string what =
        unused.instead.empty()
            ? unused.response + " is not predicted"
            : fmt::format("{} is predicted by the {} model instead of the {} model",
                          unused.response,
                          unused.instead,
                          unused.name);
    texts[unused.missing][what].push_back(unused.species);
  }
  for (const auto& [columns, by_outcome] : texts) {
    Names parts;
    for (const auto& [what, species] : by_outcome) {
      const bool is_of_all = species.front().empty();
      parts.push_back(is_of_all ? what : fmt::format("{} ({})", what, fmt::join(species, ", ")));
    }
    const bool is_one = columns.size() == 1;
    notes.push_back(fmt::format("{} {} {} missing: {}{}",
                                is_one ? "column" : "columns",
                                fmt::join(columns, ", "),
                                is_one ? "is" : "are",
                                fmt::join(parts, "; "),
                                origin_of_missing(columns, table)));
  }
}

/// \param instead  the model that predicts; may be null
UnusedModel unused_of(const Candidates& candidates, const LibraryModel* instead) {
  UnusedModel unused{.species = candidates.species,
                     .response = candidates.response,
                     .name = name_of(*candidates.models.front()),
                     .missing = candidates.missing};
  if (instead != nullptr) unused.instead = name_of(*instead);
  return unused;
}

/// The text of a tree's flag.
std::string remark_of(const UnusedModel& unused) {
  const std::string columns = fmt::format("{}", fmt::join(unused.missing, ", "));
  if (unused.instead.empty())
    return fmt::format("{} is not predicted: no column {}", unused.response, columns);
  return fmt::format("{} by the {} model: no column {}", unused.response, unused.instead, columns);
}

}  // namespace

const LibraryModel* ResponseModels::model_for(const std::string& species) const {
  const auto own = by_species.find(species);
  if (own != by_species.end()) return own->second;
  const auto any = by_species.find("");
  return any == by_species.end() ? nullptr : any->second;
}

bool ResponseModels::needs(const std::string& column) const {
  return std::ranges::any_of(by_species, [&column](const auto& entry) {
    return is_listed(column, entry.second->fit.specification.predictors());
  });
}

bool ResponseModels::is_by_species() const {
  const auto has_name = [](const auto& entry) { return !entry.first.empty(); };
  return std::ranges::any_of(by_species, has_name) || std::ranges::any_of(remarks, has_name);
}

ChosenModels choose_models(const ModelLibrary& library,
                           const data::Table& table,
                           const std::string& role) {
  const std::string wanted = role.empty() ? "nlme" : role;
  ChosenModels result;
  std::vector<Candidates> all = all_candidates(library, wanted, result.notes);
  put_best_first(all);
  std::vector<Candidates> with_stand_ins = all;
  add_stand_ins(library, wanted, with_stand_ins);
  put_best_first(with_stand_ins);
  choose(table, with_stand_ins);
  if (role.empty()) {
    all = with_stand_ins;
  } else {
    choose(table, all);
  }
  const bool lacks_columns = std::ranges::any_of(all, &Candidates::lacks_columns);
  if (lacks_columns && std::ranges::none_of(all, &Candidates::has_model)) {
    const auto other = std::ranges::find_if(with_stand_ins, &Candidates::has_model);
    refuse(all, other == with_stand_ins.end() ? "" : other->models[other->chosen]->role, table);
  }
  const auto models_of = [&result](const std::string& response) -> ResponseModels& {
    const auto found = std::ranges::find(result.responses, response, &ResponseModels::response);
    if (found != result.responses.end()) return *found;
    return result.responses.emplace_back(ResponseModels{.response = response});
  };
  for (const Candidates& each : all) {
    ResponseModels& models = models_of(each.response);
    if (each.has_model()) models.by_species[each.species] = each.models[each.chosen];
  }
  for (const Candidates& each : all) {
    if (!each.lacks_columns()) continue;
    ResponseModels& models = models_of(each.response);
    result.unused.push_back(unused_of(each, models.model_for(each.species)));
    models.remarks[each.species] = remark_of(result.unused.back());
  }
  std::erase_if(result.responses, [](const ResponseModels& each) {
    return each.by_species.empty() && !each.remarks.empty();
  });
  add_notes(result, table, result.notes);
  return result;
}

std::vector<std::size_t> order_of(const std::vector<ResponseModels>& models) {
  std::vector<std::size_t> order;
  std::vector<bool> seen(models.size(), false);
  const auto visit = [&](const auto& self, std::size_t i) -> void {
    if (seen[i]) return;
    seen[i] = true;
    for (std::size_t j = 0; j < models.size(); ++j) {
      if (models[i].needs(models[j].response)) self(self, j);
    }
    order.push_back(i);
  };
  for (std::size_t i = 0; i < models.size(); ++i) visit(visit, i);
  return order;
}

}  // namespace silvafit::study
