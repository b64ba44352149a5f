// SPDX-License-Identifier: MIT
// The library, predictions and tables that a study writes.
#include "silvafit/study/study_files.hpp"

#include <unistd.h>

#include <catch2/catch.hpp>

#include "silvafit/base/atomic_file.hpp"
#include "study/study_record_test_support.hpp"

using namespace silvafit;
using namespace silvafit::study;

namespace {

/// A folder that is removed at the end of its scope.
class ScratchFolder {
 public:
  ScratchFolder() { std::filesystem::create_directories(path_); }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_ = std::filesystem::temp_directory_path() /
                                ("silvafit-study-files-" + std::to_string(::getpid()));
};

data::Table read_table(const std::filesystem::path& path) {
  return data::read_csv_table(path, {.text_columns = {"species"}});
}

}  // namespace

TEST_CASE("the library holds the chosen model of each level, without wall times") {
  const test::RecordedStudy recorded({});
  const ModelLibrary library = library_of(recorded.record);
  CHECK(library.inventory.trees == 240);
  CHECK_FALSE(library.inventory.fingerprint.empty());
  REQUIRE(library.models.size() == 3);
  CHECK(library.models[0].role == "ols");
  CHECK(library.models[1].role == "covariates");
  CHECK(library.models[2].role == "nlme");
  for (const LibraryModel& model : library.models) {
    CHECK(model.unit == "m");
    CHECK(model.fit.seconds == 0.0);
  }
}

TEST_CASE("a study of a table in memory has its files, without a fingerprint") {
  test::RecordedStudy recorded({});
  recorded.record.inventory.inventory.file.clear();
  const ScratchFolder folder;
  const std::filesystem::path page = folder.path() / "page.html";
  write_file(page, "{{=<% %>=}}<title><% title %></title><script><%& data %></script>");
  const std::filesystem::path catalogue = test::source_file("models");
  write_study(recorded.record, Catalogue::load(catalogue), page, folder.path());
  CHECK(read_library(folder.path() / "library.json").inventory.fingerprint.empty());
  CHECK_THAT(read_file(folder.path() / "report.html"),
             Catch::Matchers::Contains("\"fingerprint\":\"\""));
}

TEST_CASE("predictions for fitted trees are the fitted values") {
  const test::RecordedStudy recorded({});
  const data::Table table = predictions_of(recorded.record, library_of(recorded.record));
  const ResponseStudy& result = recorded.record.study.results.front();
  for (std::size_t i = 0; i < result.rows.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const std::size_t row = result.rows[i];
    // The same model evaluated in two ways: rounding only.
    CHECK(table.numbers("h_ols")[row] == Approx(result.ols->fitted_population[k]).epsilon(1e-12));
    CHECK(table.numbers("h_population")[row] ==
          Approx(result.nlme->fitted_population[k]).epsilon(1e-12));
    CHECK(table.numbers("h_conditional")[row] ==
          Approx(result.nlme->fitted_conditional[k]).epsilon(1e-12));
  }
}

TEST_CASE("indices and core become columns of the table") {
  const test::RecordedStudy recorded({.plots = 2, .trees = 3});
  const stand::Inventory& inventory = recorded.record.inventory.inventory;
  stand::StructuralUnits units;
  units.core = {1, 0, 1, 1, 0, 1};
  units.W = units.M = units.U = {0.0, 0.25, 0.5, 0.75, 1.0, data::kMissing};
  const data::Table table = inventory_table(inventory, units);
  CHECK(table.numbers("core")[1] == 0.0);
  CHECK(table.numbers("W")[3] == 0.75);
  CHECK_FALSE(table.has("C"));  // no crown widths
}

TEST_CASE("tables keep names with commas and quotes, and have a row for each candidate") {
  const std::string species = "\xE6\x9D\x89, \"old\"";
  const test::RecordedStudy recorded({.species = species});
  const ScratchFolder folder;
  write_study_tables(recorded.record, test::catalogue(), folder.path());
  const ResponseStudy& result = recorded.record.study.results.front();
  const auto check_rows = [&](const std::string& name, std::size_t rows) {
    INFO(name);
    const data::Table table = read_table(folder.path() / name);
    CHECK(table.rows() == rows);
    for (std::size_t row = 0; row < rows; ++row) CHECK(table.text("species")[row] == species);
  };
  check_rows("candidates.csv", result.base.size());
  check_rows("covariates.csv", 0);
  check_rows("random_effects.csv", result.random.size());
  check_rows("variance_functions.csv", 4);
  check_rows("statistics.csv", 4);
  const auto estimates = static_cast<std::size_t>(result.ols->fit.estimate.size());
  check_rows("estimates.csv", 3 * estimates);
}

TEST_CASE("numbers of the tables read back as the same doubles") {
  const test::RecordedStudy recorded({});
  const ScratchFolder folder;
  write_study_tables(recorded.record, test::catalogue(), folder.path());
  const ResponseStudy& result = recorded.record.study.results.front();
  const data::Table table = read_table(folder.path() / "candidates.csv");
  for (std::size_t i = 0; i < result.base.size(); ++i) {
    const fit::FittedModel& fit = result.base[i].fit;
    if (!fit.convergence.converged()) continue;
    CHECK(table.numbers("log_likelihood")[i] == fit.log_likelihood);
    CHECK(table.numbers("aic")[i] == fit.aic());
    CHECK(table.numbers("bic")[i] == fit.bic());
    CHECK(table.numbers("rmse")[i] == fit.population.rmse);
  }
}

TEST_CASE("indices of an earlier study are removed, or an error is given") {
  const test::RecordedStudy recorded({});
  const ScratchFolder folder;
  const std::filesystem::path page = folder.path() / "template.html";
  write_file(page, "{{=<% %>=}}<title><% title %></title><script><%& data %></script>");
  const std::filesystem::path out = folder.path() / "out";
  const std::filesystem::path indices = out / "indices.csv";
  write_file(indices, "plot,tree,W\n1,1,0.5\n");
  write_study(recorded.record, test::catalogue(), page, out);
  CHECK_FALSE(std::filesystem::exists(indices));
  // A folder that is not empty cannot be removed like a file, not even by root.
  write_file(indices / "other", "");
  CHECK_THROWS_WITH(
      write_study(recorded.record, test::catalogue(), page, out),
      Catch::Matchers::Contains("indices.csv") && Catch::Matchers::Contains("earlier study"));
}
