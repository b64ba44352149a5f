// SPDX-License-Identifier: MIT
// Nanoseconds a value of exp, log and powers: the project's vector code beside SLEEF, both with the
// widest instructions of the processor that compiles this (at least AVX2).
#include <benchmark/benchmark.h>
#include <immintrin.h>
#include <sleef.h>

#include <cstddef>
#include <string>
#include <vector>

#include "silvafit/data/program.hpp"

namespace {

using silvafit::data::Expression;
using silvafit::data::Program;

constexpr std::size_t kRows = 1000;

std::vector<double> diameters() {
  std::vector<double> result(kRows);
  for (std::size_t i = 0; i < kRows; ++i) {
    result[i] = 5.0 + 50.0 * static_cast<double>(i) / static_cast<double>(kRows);
  }
  return result;
}

void report_rows(benchmark::State& state) {
  state.counters["s_per_value"] = benchmark::Counter(
      static_cast<double>(kRows),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void ours(benchmark::State& state, const std::string& formula) {
  const std::vector<Expression> outputs{Expression::parse(formula)};
  const Program program(outputs, {{"c", true}, {"dbh", false}});
  const std::vector<double> exponent{1.2};
  const std::vector<double> x = diameters();
  std::vector<double> result(kRows);
  const std::vector<const double*> sources{exponent.data(), x.data()};
  const std::vector<double*> targets{result.data()};
  Program::Workspace workspace;
  for ([[maybe_unused]] auto _ : state) {
    program.evaluate(sources, kRows, targets, workspace);
    benchmark::ClobberMemory();
  }
  report_rows(state);
}

enum class Function { Exponential, Logarithm, Power };

#ifdef __AVX512F__
constexpr const char* kSleef = ", SLEEF AVX-512";
constexpr std::size_t kLanes = 8;
__m512d load(const double* x) { return _mm512_loadu_pd(x); }
void store(double* x, __m512d value) { _mm512_storeu_pd(x, value); }
__m512d exp_of_negative(__m512d x) { return Sleef_expd8_u10avx512f(-x); }
__m512d logarithm(__m512d x) { return Sleef_logd8_u10avx512f(x); }
__m512d power(__m512d x) { return Sleef_powd8_u10avx512f(x, _mm512_set1_pd(1.2)); }
#else
constexpr const char* kSleef = ", SLEEF AVX2";
constexpr std::size_t kLanes = 4;
__m256d load(const double* x) { return _mm256_loadu_pd(x); }
void store(double* x, __m256d value) { _mm256_storeu_pd(x, value); }
__m256d exp_of_negative(__m256d x) { return Sleef_expd4_u10avx2(-x); }
__m256d logarithm(__m256d x) { return Sleef_logd4_u10avx2(x); }
__m256d power(__m256d x) { return Sleef_powd4_u10avx2(x, _mm256_set1_pd(1.2)); }
#endif

template <typename Function>
void sleef(benchmark::State& state, const Function& function) {
  const std::vector<double> x = diameters();
  std::vector<double> result(kRows);
  for ([[maybe_unused]] auto _ : state) {
    for (std::size_t i = 0; i < kRows; i += kLanes) {
      store(result.data() + i, function(load(x.data() + i)));
    }
    benchmark::ClobberMemory();
  }
  report_rows(state);
}

template <typename Function>
void register_function(const std::string& formula, const Function& function) {
  benchmark::RegisterBenchmark((formula + ", silvafit").c_str(),
                               [formula](benchmark::State& state) { ours(state, formula); });
  benchmark::RegisterBenchmark((formula + kSleef).c_str(),
                               [function](benchmark::State& state) { sleef(state, function); });
}

}  // namespace

int main(int argc, char** argv) {
  register_function("exp(-dbh)", [](auto x) { return exp_of_negative(x); });
  register_function("log(dbh)", [](auto x) { return logarithm(x); });
  register_function("dbh^c", [](auto x) { return power(x); });
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
