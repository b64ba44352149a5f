// SPDX-License-Identifier: MIT
// Nanoseconds a value of exp, log and powers: the project's vector code beside SLEEF, both with
// AVX2 or, where the processor has it, AVX-512.
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
  const Program program({Expression::parse(formula)}, {{"c", true}, {"dbh", false}});
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

[[gnu::target("avx2,fma")]] void with_avx2(Function function, const double* x, double* result) {
  for (std::size_t i = 0; i < kRows; i += 4) {
    const __m256d value = _mm256_loadu_pd(x + i);
    const __m256d found = function == Function::Exponential
                              ? Sleef_expd4_u10avx2(_mm256_sub_pd(_mm256_setzero_pd(), value))
                          : function == Function::Logarithm
                              ? Sleef_logd4_u10avx2(value)
                              : Sleef_powd4_u10avx2(value, _mm256_set1_pd(1.2));
    _mm256_storeu_pd(result + i, found);
  }
}

[[gnu::target("avx512f")]] void with_avx512(Function function, const double* x, double* result) {
  for (std::size_t i = 0; i < kRows; i += 8) {
    const __m512d value = _mm512_loadu_pd(x + i);
    const __m512d found = function == Function::Exponential
                              ? Sleef_expd8_u10avx512f(_mm512_sub_pd(_mm512_setzero_pd(), value))
                          : function == Function::Logarithm
                              ? Sleef_logd8_u10avx512f(value)
                              : Sleef_powd8_u10avx512f(value, _mm512_set1_pd(1.2));
    _mm512_storeu_pd(result + i, found);
  }
}

void sleef(benchmark::State& state, Function function, bool wide) {
  const std::vector<double> x = diameters();
  std::vector<double> result(kRows);
  for ([[maybe_unused]] auto _ : state) {
    if (wide) {
      with_avx512(function, x.data(), result.data());
    } else {
      with_avx2(function, x.data(), result.data());
    }
    benchmark::ClobberMemory();
  }
  report_rows(state);
}

void register_function(const std::string& formula, Function function) {
  benchmark::RegisterBenchmark((formula + ", silvafit").c_str(),
                               [formula](benchmark::State& state) { ours(state, formula); });
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    benchmark::RegisterBenchmark((formula + ", SLEEF AVX2").c_str(), sleef, function, false);
  }
  if (__builtin_cpu_supports("avx512f")) {
    benchmark::RegisterBenchmark((formula + ", SLEEF AVX-512").c_str(), sleef, function, true);
  }
}

}  // namespace

int main(int argc, char** argv) {
  register_function("exp(-dbh)", Function::Exponential);
  register_function("log(dbh)", Function::Logarithm);
  register_function("dbh^c", Function::Power);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
