// SPDX-License-Identifier: MIT
// Least squares against R 4.2.2: nls of minpack.lm 1.2.3, without giving it any start values.
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "fir_mixed.hpp"
#include "silvafit/fit/least_squares.hpp"
#include "silvafit/study/catalogue.hpp"

using namespace silvafit;
using fit::LeastSquaresFit;
using nlohmann::json;

namespace {

/// How a coefficient is called in the reference, and its sign there.
struct Name {
  std::string reference;
  double sign = 1.0;
};
using Names = std::map<std::string, Name>;

struct SubModelCase {
  std::string id;
  std::string formula;
  std::vector<std::string> sub_models{};
  Names names{};
};

const std::string kMeyer = "h ~ 1.3 + a*(1 - exp(-b*dbh))";
const std::string kPower = "h ~ 1.3 + a*dbh^b";
const std::string kWalters = "hcb ~ h/(1 + exp(a + b*dbh))";
const std::string kLogistic = "cw ~ a/(1 + b*exp(-c*dbh))";
const std::string kCrownPower = "cw ~ a*dbh^b";

/// Levels 1 and 2 of the study. The reference writes rates as -b + c C, so that signs differ.
const std::vector<SubModelCase> kStudy{
    {"SM_h_base", kMeyer},
    {"SM_hcb_base", kWalters},
    {"SM_cw_base", kLogistic},
    {"BHN_h_base", kMeyer},
    {"BHN_hcb_base", kWalters},
    {"BHN_cw_base", kLogistic},
    {"MH_h_base", kPower},
    {"MH_hcb_base", kWalters},
    {"MH_cw_base", kCrownPower},
    {"SM_h_ssp", kMeyer, {"b ~ 1 + C"}, {{"b:C", {"c", -1.0}}}},
    {"SM_hcb_ssp", kWalters, {"b ~ 1 + C"}, {{"b:C", {"c"}}}},
    {"SM_cw_ssp", kLogistic, {"c ~ 1 + C + M"}, {{"c:C", {"d", -1.0}}, {"c:M", {"e", -1.0}}}},
    {"BHN_h_ssp", kMeyer, {"b ~ 1 + C + U"}, {{"b:C", {"c", -1.0}}, {"b:U", {"d", -1.0}}}},
    {"BHN_hcb_ssp", kWalters, {"b ~ 0 + C + U"}, {{"b:C", {"b"}}, {"b:U", {"c"}}}},
    {"BHN_cw_ssp", kLogistic, {"c ~ 1 + C"}, {{"c:C", {"d", -1.0}}}},
    {"MH_h_ssp", kPower, {"a ~ 1 + M + C"}, {{"a:M", {"c"}}, {"a:C", {"d"}}}},
    {"MH_hcb_ssp",
     kWalters,
     {"b ~ 0 + M + C + U"},
     {{"b:M", {"b"}}, {"b:C", {"c"}}, {"b:U", {"d"}}}},
    {"MH_cw_ssp", kCrownPower, {"a ~ 1 + C + M"}, {{"a:C", {"c"}}, {"a:M", {"d"}}}}};

/// The same log-likelihood as R or a better one; where it is the same and R's own second algorithm
/// agrees, the same estimates within R's tolerances.
void check_against_nls(const json& reference, const LeastSquaresFit& fit, const Names& names = {}) {
  INFO(reference["id"].get<std::string>() << ": " << fit.convergence.verdict());
  CHECK_FALSE(fit.convergence.verdict().empty());
  REQUIRE(fit.observations == reference["n"].get<int>());
  const double log_likelihood = reference["logLik"].get<double>();
  CHECK(fit.log_likelihood > log_likelihood - 1e-6);
  if (fit.log_likelihood > log_likelihood + 1e-6) return;
  if (!reference["nls_gauss_newton_converged"].get<bool>()) return;
  CHECK(fit.convergence.converged());
  CHECK(fit.convergence.newton_decrement < 1e-20);
  CHECK(fit.sigma == Approx(reference["sigma"].get<double>()).epsilon(1e-9));
  const Eigen::VectorXd errors = fit.standard_errors();
  for (std::size_t j = 0; j < fit.coefficient_names.size(); ++j) {
    const std::string& ours = fit.coefficient_names[j];
    const auto found = names.find(ours);
    const Name name = found == names.end() ? Name{ours} : found->second;
    INFO(ours);
    CHECK(name.sign * fit.estimate[static_cast<Eigen::Index>(j)] ==
          Approx(reference["estimates"][name.reference].get<double>()).epsilon(1e-5));
    CHECK(errors[static_cast<Eigen::Index>(j)] ==
          Approx(reference["std_errors"][name.reference].get<double>()).epsilon(1e-4));
  }
}

LeastSquaresFit fitted_by_squares(const std::string& formula,
                                  const std::vector<std::string>& sub_models,
                                  const data::Table& table) {
  return fit_least_squares(
      fit::NonlinearModel(fit::specify_model(formula, sub_models, table), table));
}

const json& entry(const json& file, const std::string& id) {
  for (const json& fit : file["fits"]) {
    if (fit["id"] == id) return fit;
  }
  FAIL("no reference " << id);
  return file;
}

std::map<std::string, data::Table> species_tables(const std::string& core) {
  std::map<std::string, data::Table> tables;
  for (const char* species : {"SM", "BHN", "MH"}) tables[species] = test::fir_mixed(species, core);
  return tables;
}

void check_study(const std::string& file, const std::string& core) {
  const json reference = test::read_expected(file);
  const auto tables = species_tables(core);
  for (const SubModelCase& model : kStudy) {
    const json& expected = entry(reference, model.id);
    const data::Table& table = tables.at(expected["species"].get<std::string>());
    check_against_nls(
        expected, fitted_by_squares(model.formula, model.sub_models, table), model.names);
  }
}

/// Rows where all of the columns have a value, and a positive one.
data::Table with_positive(const data::Table& table, const std::vector<std::string>& columns) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const bool keep = std::ranges::all_of(
        columns, [&](const std::string& column) { return table.numbers(column)[row] > 0.0; });
    if (keep) rows.push_back(row);
  }
  return table.select(rows);
}

}  // namespace

TEST_CASE("all 32 base models reach R's fit on three species", "[reference]") {
  const json reference = test::read_expected("fir_mixed_base_models.json");
  const auto catalogue = study::Catalogue::load(test::source_file("models"));
  const auto tables = species_tables("in_core");
  int count = 0;
  for (const json& expected : reference["fits"]) {
    const study::BaseModel& base = catalogue.find(expected["model"].get<std::string>());
    const data::Table& table = tables.at(expected["species"].get<std::string>());
    const fit::NonlinearModel model(fit::specify_model(base.formula, {}, table), table);
    check_against_nls(expected, fit_least_squares(model));

    fit::LeastSquaresOptions options;
    const std::vector<double> starts = study::start_values(base, table);
    for (std::size_t j = 0; j < starts.size(); ++j) {
      options.rule[base.parameters[j].name] = starts[j];
    }
    check_against_nls(expected, fit_least_squares(model, options));
    ++count;
  }
  CHECK(count == 96);
}

TEST_CASE("one curve in three forms has one log-likelihood", "[reference]") {
  const data::Table table = test::fir_mixed("SM");
  const double m27 = fitted_by_squares("cw ~ a*b^dbh", {}, table).log_likelihood;
  CHECK(fitted_by_squares("cw ~ exp(a + b*dbh)", {}, table).log_likelihood ==
        Approx(m27).epsilon(1e-13));
  CHECK(fitted_by_squares("cw ~ a*exp(b*dbh)", {}, table).log_likelihood ==
        Approx(m27).epsilon(1e-13));
}

TEST_CASE("levels 1 and 2 of the study are R's", "[reference]") {
  check_study("fir_mixed_nlme.json", "in_core");
  check_study("fir_mixed_nlme_plotbuffer.json", "in_core_plot");
}

TEST_CASE("a covariate more never makes the fit worse", "[reference]") {
  const std::vector<std::string> covariates{"W", "M", "C", "U"};
  const std::vector<std::pair<std::string, std::string>> models{
      {kMeyer, "b"}, {kWalters, "b"}, {kLogistic, "c"}, {kPower, "a"}};
  const data::Table table = test::fir_mixed("BHN");
  for (const auto& [formula, parameter] : models) {
    std::map<std::set<std::size_t>, double> best;
    for (unsigned subset = 0; subset < 16; ++subset) {
      std::set<std::size_t> members;
      std::string sub_model = parameter + " ~ 1";
      for (std::size_t k = 0; k < 4; ++k) {
        if ((subset >> k & 1U) == 0) continue;
        members.insert(k);
        sub_model += " + " + covariates[k];
      }
      best[members] = fitted_by_squares(formula, {sub_model}, table).log_likelihood;
      for (const std::size_t left_out : members) {
        std::set<std::size_t> fewer = members;
        fewer.erase(left_out);
        INFO(formula << " with " << sub_model);
        CHECK(best[members] >= best[fewer] - 1e-7);
      }
    }
  }
}

TEST_CASE("fits of public data are R's", "[reference]") {
  const json reference = test::read_expected("public_nlme.json");
  const auto read = [](const std::string& name) {
    return data::read_csv_table(test::reference_data("" + name));
  };
  check_against_nls(
      entry(reference, "Loblolly_nls"),
      fitted_by_squares(
          "height ~ Asym + (R0 - Asym)*exp(-exp(lrc)*age)", {}, read("Loblolly.csv")));
  check_against_nls(
      entry(reference, "Orange_nls"),
      fitted_by_squares(
          "circumference ~ Asym/(1 + exp((xmid - age)/scal))", {}, read("Orange.csv")));
  check_against_nls(entry(reference, "alsTree_walters_nls"),
                    fitted_by_squares("HCB ~ H/(1 + exp(a + b*DBH))", {}, read("alsTree.csv")));
  const data::Table spati = with_positive(read("spati.csv"), {"h", "d"});
  check_against_nls(entry(reference, "spati_naslund_nls"),
                    fitted_by_squares("h ~ 1.3 + d^2/(a + b*d)^2", {}, spati));
  check_against_nls(entry(reference, "spati_curtis_nls"),
                    fitted_by_squares("h ~ 1.3 + a*(d/(1 + d))^b", {}, spati));
  check_against_nls(entry(reference, "spati_korf_nls"),
                    fitted_by_squares("h ~ 1.3 + a*exp(-b*d^(-c))", {}, spati));
  check_against_nls(entry(reference, "spati_richards_nls"),
                    fitted_by_squares("h ~ 1.3 + a*(1 - exp(-b*d))^c", {}, spati));
}
