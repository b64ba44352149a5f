// SPDX-License-Identifier: MIT
#include "silvafit/study/comparison_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "report/report_json.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/base/json_values.hpp"
#include "silvafit/fit/prediction.hpp"
#include "silvafit/study/model_library.hpp"
#include "silvafit/study/report_page.hpp"

namespace silvafit::study {
namespace {

struct ComparedCurves {
  std::map<std::string, double> held_at{};
  std::vector<double> dbh_cm{};
  bool own_heights = false;                   ///< heights are those of each library's height model
  std::vector<std::vector<double>> values{};  ///< by library; empty without a curve, NaN outside
                                              ///< the DBH that the model was fitted to
};

constexpr std::size_t kGridPoints = 60;

using Range = std::pair<double, double>;

std::optional<Range> range_of(const fit::FittedModel& fit, const std::string& column) {
  for (const fit::ColumnRange& range : fit.ranges) {
    if (range.column == column) return Range{range.low, range.high};
  }
  return std::nullopt;
}

/// Without a range of DBH, as in published libraries, the ends of the curve are unknown. A
/// covariate that is compared with text, such as species == "SM", has no middle value.
bool has_curve(const fit::FittedModel& fit) {
  const auto dbh = range_of(fit, "dbh");
  if (!dbh || !(dbh->first < dbh->second)) return false;
  return std::ranges::all_of(fit.specification.predictors(), [&](const std::string& name) {
    return range_of(fit, name).has_value();
  });
}

std::vector<double> grid_between(double low, double high) {
  std::vector<double> grid;
  for (std::size_t i = 0; i < kGridPoints; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(kGridPoints - 1);
    grid.push_back(low + share * (high - low));
  }
  return grid;
}

std::vector<double> predicted(const fit::FittedModel& fit, const data::Table& grid) {
  const Eigen::VectorXd values = fit::predict(fit, grid, fit::Level::kPopulation).value;
  return {values.begin(), values.end()};
}

/// The height model of a species for a model that reads h: of the same role if there is one.
const LibraryModel* height_model(const ModelLibrary& library, const LibraryModel& model) {
  const LibraryModel* found = nullptr;
  for (const LibraryModel& candidate : library.models) {
    const bool fits = candidate.species == model.species && candidate.response == "h" &&
                      candidate.fit.convergence.converged() && has_curve(candidate.fit);
    if (fits && (found == nullptr || candidate.role == model.role)) found = &candidate;
  }
  return found;
}

/// The ranges over which curves are drawn; each model that uses a column narrows its range.
class Setting {
 public:
  void widen_dbh(const Range& range) {
    dbh_ = dbh_ ? Range{std::min(dbh_->first, range.first), std::max(dbh_->second, range.second)}
                : range;
  }
  void use(const fit::FittedModel& fit, bool has_heights) {
    for (const fit::ColumnRange& range : fit.ranges) {
      if (range.column == "dbh" || (range.column == "h" && has_heights)) continue;
      const auto [place, is_new] = held_.try_emplace(range.column, Range{range.low, range.high});
      if (is_new) continue;
      Range& common = place->second;
      const Range narrower{std::max(common.first, range.low), std::min(common.second, range.high)};
      // Ranges that do not overlap have no common middle; that of the first model is used.
      if (narrower.first <= narrower.second) common = narrower;
    }
  }
  bool is_empty() const { return !dbh_; }
  std::vector<double> dbh() const { return grid_between(dbh_->first, dbh_->second); }
  std::map<std::string, double> held_at() const {
    std::map<std::string, double> values;
    for (const auto& [name, range] : held_) values[name] = 0.5 * (range.first + range.second);
    return values;
  }

 private:
  std::optional<Range> dbh_;
  std::map<std::string, Range> held_;
};

/// Population curves of the models of one species, response and role; empty if no model
/// has a curve.
/// \param models     by library, null if it has no such model
/// \param libraries  in the same order
ComparedCurves compared_curves(const std::vector<const LibraryModel*>& models,
                               const std::vector<ModelLibrary>& libraries) {
  Setting setting;
  std::vector<const LibraryModel*> heights(models.size(), nullptr);
  std::vector<bool> drawn(models.size(), false);
  ComparedCurves curves;
  curves.values.resize(models.size());
  for (std::size_t i = 0; i < models.size(); ++i) {
    drawn[i] =
        models[i] != nullptr && models[i]->fit.convergence.converged() && has_curve(models[i]->fit);
    if (!drawn[i]) continue;
    if (range_of(models[i]->fit, "h")) heights[i] = height_model(libraries[i], *models[i]);
    setting.widen_dbh(*range_of(models[i]->fit, "dbh"));
    setting.use(models[i]->fit, heights[i] != nullptr);
    if (heights[i] != nullptr) setting.use(heights[i]->fit, false);
    curves.own_heights |= heights[i] != nullptr;
  }
  if (setting.is_empty()) return curves;
  curves.dbh_cm = setting.dbh();
  curves.held_at = setting.held_at();
  data::Table common;
  common.set("dbh", curves.dbh_cm);
  for (const auto& [name, value] : curves.held_at) {
    common.set(name, std::vector<double>(curves.dbh_cm.size(), value));
  }
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (!drawn[i]) continue;
    data::Table grid = common;
    if (heights[i] != nullptr) grid.set("h", predicted(heights[i]->fit, common));
    const auto [low, high] = *range_of(models[i]->fit, "dbh");
    curves.values[i] = predicted(models[i]->fit, grid);
    for (std::size_t k = 0; k < curves.dbh_cm.size(); ++k) {
      const bool inside = curves.dbh_cm[k] >= low && curves.dbh_cm[k] <= high;
      if (!inside) curves.values[i][k] = data::kMissing;
    }
  }
  return curves;
}

using nlohmann::ordered_json;

/// The models of one response and species in all libraries.
struct Subject {
  std::string species{};
  std::string response{};
  std::string role{};
  bool operator==(const Subject&) const = default;
};

Subject subject_of(const LibraryModel& model) {
  return {.species = model.species, .response = model.response, .role = model.role};
}

/// In the order of the first library, then those that only later ones have.
std::vector<Subject> subjects_of(const std::vector<ModelLibrary>& libraries) {
  std::vector<Subject> subjects;
  for (const ModelLibrary& library : libraries) {
    for (const LibraryModel& model : library.models) {
      const Subject subject = subject_of(model);
      if (std::ranges::find(subjects, subject) == subjects.end()) subjects.push_back(subject);
    }
  }
  return subjects;
}

/// The library's model; of several the one of lowest AIC, as in predictions.
const LibraryModel* model_of(const ModelLibrary& library, const Subject& subject) {
  const LibraryModel* found = nullptr;
  for (const LibraryModel& model : library.models) {
    if (subject_of(model) != subject) continue;
    if (found == nullptr || model.fit.aic() < found->fit.aic()) found = &model;
  }
  return found;
}

/// The reason why two fits are not of the same trees; empty if they may be.
std::string different_data(const fit::FittedModel& first,
                           const LibraryInventory& first_data,
                           const fit::FittedModel& other,
                           const LibraryInventory& other_data) {
  if (first.observations != other.observations) {
    return fmt::format("fitted to {} and {} trees", first.observations, other.observations);
  }
  if (!first.response_fingerprint.empty() && !other.response_fingerprint.empty()) {
    return first.response_fingerprint == other.response_fingerprint ? ""
                                                                    : "fitted to different values";
  }
  // Published and older fits have no fingerprint of their values; their files may have one.
  if (first_data.fingerprint.empty() || other_data.fingerprint.empty()) {
    return "a fit does not store which data it used";
  }
  return first_data.fingerprint == other_data.fingerprint ? "" : "fitted to different files";
}

/// The reason why AIC and BIC of two fits cannot be compared; empty if they can.
std::string not_comparable(const LibraryModel& first,
                           const LibraryInventory& first_data,
                           const LibraryModel& other,
                           const LibraryInventory& other_data) {
  if (!first.fit.convergence.converged() || !other.fit.convergence.converged()) {
    return "a fit has not converged";
  }
  if (first.fit.specification.formula.left != other.fit.specification.formula.left) {
    return "the responses differ";
  }
  if (first.fit.reml != other.fit.reml) return "one by ML, the other by REML";
  if (first.fit.reml && first.fit.coefficient_names != other.fit.coefficient_names) {
    return "REML likelihoods with different fixed effects";
  }
  return different_data(first.fit, first_data, other.fit, other_data);
}

/// The most accurate statistics of the fit: conditional with random effects, else population.
const fit::FitStatistics& best_statistics(const fit::FittedModel& fit) {
  return fit.has_random_effects() ? fit.conditional : fit.population;
}

ordered_json difference_of(const LibraryModel& first,
                           const LibraryInventory& first_data,
                           const LibraryModel& other,
                           const LibraryInventory& other_data) {
  const std::string reason = not_comparable(first, first_data, other, other_data);
  const bool is_comparable = reason.empty();
  const auto likelihood = [&](double value) {
    return is_comparable ? number_or_null(value) : ordered_json(nullptr);
  };
  const fit::FitStatistics& ours = best_statistics(first.fit);
  const fit::FitStatistics& theirs = best_statistics(other.fit);
  return {{"log_likelihood", likelihood(other.fit.log_likelihood - first.fit.log_likelihood)},
          {"aic", likelihood(other.fit.aic() - first.fit.aic())},
          {"bic", likelihood(other.fit.bic() - first.fit.bic())},
          {"rmse", number_or_null(theirs.rmse - ours.rmse)},
          {"r2", number_or_null(theirs.r2 - ours.r2)},
          {"reason", is_comparable ? ordered_json(nullptr) : ordered_json(reason)}};
}

ordered_json curves_object(const std::vector<const LibraryModel*>& models,
                           const std::vector<ModelLibrary>& libraries) {
  const ComparedCurves curves = compared_curves(models, libraries);
  if (curves.dbh_cm.empty()) return nullptr;
  ordered_json object{{"held_at", ordered_json::object()},
                      {"own_heights", curves.own_heights},
                      {"dbh", numbers_or_null(curves.dbh_cm)},
                      {"values", ordered_json::array()}};
  for (const auto& [name, value] : curves.held_at) object["held_at"][name] = number_or_null(value);
  for (const std::vector<double>& values : curves.values) {
    object["values"].push_back(values.empty() ? ordered_json(nullptr) : numbers_or_null(values));
  }
  return object;
}

std::string unit_of_models(const std::vector<const LibraryModel*>& models) {
  for (const LibraryModel* model : models) {
    if (model != nullptr && !model->unit.empty()) return model->unit;
  }
  return "";
}

ordered_json pair_object(const Subject& subject, const std::vector<ModelLibrary>& libraries) {
  std::vector<const LibraryModel*> models;
  models.reserve(libraries.size());
  for (const ModelLibrary& library : libraries) models.push_back(model_of(library, subject));
  ordered_json object{{"species", subject.species},
                      {"response", subject.response},
                      {"role", subject.role},
                      {"unit", unit_of_models(models)},
                      {"fits", ordered_json::array()},
                      {"differences", ordered_json::array()}};
  for (std::size_t i = 0; i < models.size(); ++i) {
    object["fits"].push_back(models[i] ? fit_object(models[i]->fit) : ordered_json(nullptr));
    if (i == 0) continue;
    const bool has_both = models[0] != nullptr && models[i] != nullptr;
    object["differences"].push_back(
        has_both
            ? difference_of(*models[0], libraries[0].inventory, *models[i], libraries[i].inventory)
            : ordered_json(nullptr));
  }
  object["curves"] = curves_object(models, libraries);
  return object;
}

ordered_json library_object(const ModelLibrary& library, const std::string& name) {
  const LibraryInventory& data = library.inventory;
  return {{"name", name},
          {"file", data.file},
          {"fingerprint", data.fingerprint},
          {"trees", data.trees},
          {"models", library.models.size()}};
}

std::string title_of(const std::vector<std::string>& names) {
  return fmt::format("Comparison of {}", fmt::join(names, " and "));
}

}  // namespace

std::string comparison_data(const std::vector<ModelLibrary>& libraries,
                            const std::vector<std::string>& names) {
  if (libraries.size() < 2) throw UsageError("a comparison needs at least two model libraries");
  if (names.size() != libraries.size()) {
    throw UsageError(fmt::format("{} model libraries have {} names; give one name for each",
                                 libraries.size(),
                                 names.size()));
  }
  ordered_json data{{"schema", "silvafit-comparison/1"},
                    {"silvafit", SILVAFIT_VERSION},
                    {"title", title_of(names)},
                    {"versions", report_versions()},
                    {"libraries", ordered_json::array()},
                    {"pairs", ordered_json::array()}};
  for (std::size_t i = 0; i < libraries.size(); ++i) {
    data["libraries"].push_back(library_object(libraries[i], names[i]));
  }
  for (const Subject& subject : subjects_of(libraries)) {
    data["pairs"].push_back(pair_object(subject, libraries));
  }
  return json_text(data);
}

void write_comparison_page(const std::vector<ModelLibrary>& libraries,
                           const std::vector<std::string>& names,
                           const std::filesystem::path& template_path,
                           const std::filesystem::path& out_path) {
  write_report_page(
      template_path, comparison_data(libraries, names), "silvafit: " + title_of(names), out_path);
}

}  // namespace silvafit::study
