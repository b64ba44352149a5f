// SPDX-License-Identifier: MIT
// What a row costs: one exp ("the floor"), growth curves with their gradients, and sums.
//
// Compare two commits on an idle machine, each three times.
#include <benchmark/benchmark.h>

#include <cstddef>
#include <string>
#include <vector>

#include "silvafit/data/program.hpp"
#include "silvafit/data/row_sums.hpp"

using silvafit::data::Expression;
using silvafit::data::Program;

namespace {

/// The counter is in seconds; google-benchmark prints 1.2n for 1.2 nanoseconds.
void report_rows(benchmark::State& state, std::size_t rows) {
  state.counters["s_per_row"] = benchmark::Counter(
      static_cast<double>(rows),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

std::vector<double> diameters(std::size_t rows) {
  std::vector<double> result(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    result[i] = 5.0 + 50.0 * static_cast<double>(i % 997) / 997.0;
  }
  return result;
}

/// Outputs of a formula in dbh with the parameters a, b, c, which are scalars or one value a row.
void evaluate(benchmark::State& state, const std::vector<Expression>& outputs, bool is_scalar) {
  const auto rows = static_cast<std::size_t>(state.range(0));
  const Program program(outputs,
                        {{"a", is_scalar}, {"b", is_scalar}, {"c", is_scalar}, {"dbh", false}});
  const std::size_t values = is_scalar ? 1 : rows;
  const std::vector<std::vector<double>> inputs = {std::vector<double>(values, 25.0),
                                                   std::vector<double>(values, 0.05),
                                                   std::vector<double>(values, 1.2),
                                                   diameters(rows)};
  std::vector<const double*> sources;
  for (const auto& input : inputs) sources.push_back(input.data());
  std::vector<std::vector<double>> results(outputs.size(), std::vector<double>(rows));
  std::vector<double*> targets;
  for (auto& result : results) targets.push_back(result.data());
  Program::Workspace workspace;
  for ([[maybe_unused]] auto _ : state) {
    program.evaluate(sources, rows, targets, workspace);
    benchmark::ClobberMemory();
  }
  report_rows(state, rows);
}

std::vector<Expression> with_gradient(const std::string& text) {
  const Expression curve = Expression::parse(text);
  std::vector<Expression> outputs{curve};
  for (const std::string& name : curve.variables()) {
    if (name != "dbh") outputs.push_back(curve.derivative(name));
  }
  return outputs;
}

void sum_of_products(benchmark::State& state) {
  const auto rows = static_cast<std::size_t>(state.range(0));
  const auto count = static_cast<std::size_t>(state.range(1));
  const std::vector<std::vector<double>> values(count + 1, diameters(rows));
  std::vector<const double*> columns;
  for (const auto& column : values) columns.push_back(column.data());
  std::vector<double> products(count * count);
  for ([[maybe_unused]] auto _ : state) {
    silvafit::data::weighted_products(
        {columns.data(), count}, columns.back(), rows, products.data());
    benchmark::ClobberMemory();
  }
  report_rows(state, rows);
}

void weighted_dot(benchmark::State& state) {
  const auto rows = static_cast<std::size_t>(state.range(0));
  const std::vector<double> a = diameters(rows);
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(silvafit::data::weighted_dot(a.data(), a.data(), a.data(), rows));
  }
  report_rows(state, rows);
}

void register_formula(const std::string& name, const std::vector<Expression>& outputs) {
  for (const bool is_scalar : {true, false}) {
    const std::string kind = is_scalar ? "/scalar parameters" : "/parameters by row";
    benchmark::RegisterBenchmark(
        (name + kind).c_str(),
        [outputs, is_scalar](benchmark::State& state) { evaluate(state, outputs, is_scalar); })
        ->Arg(20)
        ->Arg(1000)
        ->Arg(100000);
  }
}

}  // namespace

int main(int argc, char** argv) {
  register_formula("exp (the floor)", {Expression::parse("exp(-dbh)")});
  for (const char* curve : {"1.3 + a*(1 - exp(-b*dbh))",
                            "1.3 + a*(1 - exp(-b*dbh^c))",
                            "1.3 + a*(1 - exp(-b*dbh))^c"}) {
    register_formula(curve, {Expression::parse(curve)});
    register_formula(std::string(curve) + " with gradient", with_gradient(curve));
  }
  benchmark::RegisterBenchmark("weighted_dot", weighted_dot)->Arg(5)->Arg(50)->Arg(5000);
  benchmark::RegisterBenchmark("weighted_products", sum_of_products)
      ->ArgsProduct({{5, 50, 5000}, {4, 8, 12}});
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
