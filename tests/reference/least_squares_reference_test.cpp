// SPDX-License-Identifier: MIT
#include <chrono>
#include <cstdio>
#include "fir_mixed.hpp"
#include "silvafit/fit/least_squares.hpp"
#include "silvafit/study/catalogue.hpp"

using namespace silvafit;

TEST_CASE("probe") {
  const auto reference = test::read_json("fir_mixed_base_models.json");
  const auto catalogue = study::Catalogue::load(test::source_file("models"));
  std::map<std::string, data::Table> tables;
  for (const char* s : {"SM", "BHN", "MH"}) tables[s] = test::fir_mixed(s);
  double total = 0;
  const double fx = std::getenv("FX") ? atof(std::getenv("FX")) : 1;
  const double fy = std::getenv("FY") ? atof(std::getenv("FY")) : 1;
  if (fx != 1 || fy != 1) for (auto& [k, t] : tables) {
    auto scale = [&](const char* n, double f) { std::vector<double> v(t.numbers(n).begin(), t.numbers(n).end()); for (auto& x : v) x *= f; t.set(n, v); };
    scale("dbh", fx); scale("h", fy); scale("hcb", fy); scale("cw", fy);
  }
  for (const auto& f : reference["fits"]) {
    const auto& m = catalogue.find(f["model"].get<std::string>());
    const auto& table = tables[f["species"]];
    fit::LeastSquaresOptions options;
    if (std::getenv("RULE")) {
      auto s = study::start_values(m, table);
      for (size_t i = 0; i < s.size(); ++i) options.rule[m.parameters[i].name] = s[i];
    }
    std::string formula = m.formula;
    if (fy != 1) { auto p = formula.find("1.3"); if (p != std::string::npos) formula.replace(p, 3, std::to_string(1.3 * fy)); }
    const fit::NonlinearModel model(fit::specify_model(formula, {}, table), table);
    auto t0 = std::chrono::steady_clock::now();
    auto r = fit::fit_least_squares(model, options);
    double ms = std::chrono::duration<double>(std::chrono::steady_clock::now() - t0).count() * 1e3;
    total += ms;
    double dl = r.log_likelihood + double(model.observations()) * std::log(fy) - f["logLik"].get<double>();
    double de = 0, ds = 0;
    for (int j = 0; j < r.estimate.size(); ++j) {
      double e = f["estimates"][r.coefficient_names[j]], s = f["std_errors"][r.coefficient_names[j]].is_number() ? f["std_errors"][r.coefficient_names[j]].get<double>() : NAN;
      de = std::max(de, std::abs(r.estimate[j] / e - 1)); ds = std::max(ds, std::abs(r.standard_errors()[j] / s - 1));
    }
    printf("%-8s %5.2fms it %3d dl %9.2e de %8.1e ds %8.1e %d|%d %s", f["id"].get<std::string>().c_str(), ms, r.convergence.iterations, dl, de, ds, (int)r.convergence.converged, (int)f["nls_gauss_newton_converged"].get<bool>(), r.convergence.verdict.c_str());
    if (de > 1e-5) for (int j = 0; j < r.estimate.size(); ++j) printf(" %.6g", r.estimate[j]);
    printf("\n");
  }
  printf("total %.1f ms\n", total);
}
