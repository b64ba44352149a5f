// SPDX-License-Identifier: MIT
#include "report/report_json.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <boost/version.hpp>
#include <utility>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/fingerprint.hpp"
#include "silvafit/base/json_values.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/fit/fit_json.hpp"

namespace silvafit::study {
namespace {

using nlohmann::ordered_json;

std::string compiler() {
#if defined(__clang__)
  return fmt::format("clang {}.{}.{}", __clang_major__, __clang_minor__, __clang_patchlevel__);
#else
  return fmt::format("g++ {}.{}.{}", __GNUC__, __GNUC_MINOR__, __GNUC_PATCHLEVEL__);
#endif
}

std::string boost() {
  constexpr int kMajor = 100000;
  constexpr int kMinor = 100;
  return fmt::format("{}.{}.{}",
                     BOOST_VERSION / kMajor,
                     BOOST_VERSION / kMinor % (kMajor / kMinor),
                     BOOST_VERSION % kMinor);
}

std::string eigen() {
  return fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION);
}

ordered_json cell_value(const TableCell& cell, ColumnKind kind) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  if (std::holds_alternative<MarkedNumber>(cell)) return shown_text(cell, kind);
  const auto* value = std::get_if<double>(&cell);
  return value != nullptr ? number_or_null(*value) : ordered_json(nullptr);
}

}  // namespace

ordered_json fit_object(const fit::FittedModel& fit) {
  ordered_json object = fit::json_of(fit);
  object.erase("seconds");
  object.erase("random_cells");
  // Matrices of each group would double the size of the page, which shows their diagonals only.
  for (ordered_json& term : object["random"]) {
    for (const char* key : {"eblup_covariance", "eblup_by_fixed"}) term.erase(key);
  }
  return object;
}

ordered_json left_out_object(const ResponseStudy& result) {
  if (!result.left_out) return nullptr;
  const LeftOutPlots& left_out = *result.left_out;
  return {{"folds", left_out.folds},
          {"trees", left_out.trees},
          {"rmse_ols", number_or_null(left_out.rmse_ols)},
          {"rmse_covariates", number_or_null(left_out.rmse_covariates)},
          {"rmse_nlme", number_or_null(left_out.rmse_nlme)},
          {"r2_ols", number_or_null(left_out.r2_ols)},
          {"r2_covariates", number_or_null(left_out.r2_covariates)},
          {"r2_nlme", number_or_null(left_out.r2_nlme)},
          {"t", number_or_null(left_out.t)},
          {"worse", left_out.is_worse}};
}

ordered_json report_versions() {
  return ordered_json::array({{{"name", "silvafit"}, {"version", SILVAFIT_VERSION}},
                              {{"name", "compiler"}, {"version", compiler()}},
                              {{"name", "Eigen"}, {"version", eigen()}},
                              {{"name", "Boost"}, {"version", boost()}}});
}

std::string inventory_fingerprint(const StudyRecord& record) {
  const std::string& file = record.inventory.inventory.file;
  return file.empty() || !is_there(file) ? std::string() : fingerprint(read_file(file, kAnySize));
}

ordered_json report_repeat(const StudyRecord& record) {
  return {{"fingerprint", inventory_fingerprint(record)}, {"versions", report_versions()}};
}

ordered_json json_of(const FormattedTable& table) {
  ordered_json columns = ordered_json::array();
  for (const TableColumn& column : table.columns) {
    columns.push_back(
        {{"name", column.name}, {"title", column.title}, {"kind", word_of(column.kind)}});
  }
  ordered_json rows = ordered_json::array();
  for (const TableRow& row : table.rows) {
    ordered_json cells = ordered_json::array();
    for (std::size_t i = 0; i < row.size(); ++i) {
      cells.push_back(cell_value(row[i], table.columns[i].kind));
    }
    rows.push_back(std::move(cells));
  }
  return {{"name", table.name},
          {"caption", table.caption},
          {"columns", std::move(columns)},
          {"rows", std::move(rows)}};
}

}  // namespace silvafit::study
