// SPDX-License-Identifier: MIT
// Milliseconds of a Cholesky factorization of crossed random effects: the project's, Eigen's and
// CHOLMOD's, on the students and lecturers of lme4's InstEval:
//   Rscript -e 'utils::write.table(lme4::InstEval[c("s","d")], "pairs.txt", row.names=FALSE,
//   col.names=FALSE, quote=FALSE)'
//   SILVAFIT_PAIRS=pairs.txt silvafit_bench_sparse_factor
#include "conditional_modes/sparse_factor.hpp"

#include <benchmark/benchmark.h>

#include <Eigen/CholmodSupport>
#include <Eigen/SparseCholesky>
#include <cstdlib>
#include <fstream>
#include <map>
#include <utility>
#include <vector>

namespace {

using namespace silvafit::fit;
using Sparse = Eigen::SparseMatrix<double>;

/// The number of rows of each pair of groups, numbered from 0, the second after the first.
struct Pairs {
  Eigen::MatrixXi places{};
  std::vector<double> rows{};
  Index size = 0;
};

Pairs read_pairs() {
  const char* const name = std::getenv("SILVAFIT_PAIRS");
  std::ifstream file(name == nullptr ? "pairs.txt" : name);
  std::map<std::pair<int, int>, double> counts;
  std::map<int, int> first;
  std::map<int, int> second;
  for (int a = 0, b = 0; file >> a >> b;) {
    const auto place = [](std::map<int, int>& known, int label) {
      return known.emplace(label, static_cast<int>(known.size())).first->second;
    };
    ++counts[{place(first, a), place(second, b)}];
  }
  Pairs pairs{.places = Eigen::MatrixXi(2, static_cast<Index>(counts.size())),
              .size = static_cast<Index>(first.size() + second.size())};
  for (const auto& [pair, rows] : counts) {
    pairs.places.col(static_cast<Index>(pairs.rows.size())) << pair.first,
        static_cast<int>(first.size()) + pair.second;
    pairs.rows.push_back(rows);
  }
  return pairs;
}

const Pairs& pairs() {
  static const Pairs read = read_pairs();
  return read;
}

Sparse matrix_of(const Pairs& of) {
  std::vector<Eigen::Triplet<double>> elements;
  for (int i = 0; i < of.size; ++i) elements.emplace_back(i, i, 1.0);
  for (std::size_t k = 0; k < of.rows.size(); ++k) {
    const auto column = of.places.col(static_cast<Index>(k));
    for (int a = 0; a < 2; ++a) {
      for (int b = 0; b < 2; ++b) elements.emplace_back(column[a], column[b], of.rows[k]);
    }
  }
  Sparse matrix(of.size, of.size);
  matrix.setFromTriplets(elements.begin(), elements.end());
  return matrix;
}

void ours(benchmark::State& state) {
  const SparsePattern pattern(pairs().size, pairs().places);
  SparseFactor factor;
  for ([[maybe_unused]] auto _ : state) {
    factor.begin(pattern, 1.0);
    for (std::size_t k = 0; k < pairs().rows.size(); ++k) {
      factor.add(static_cast<Index>(k), SmallMatrix::Constant(2, 2, pairs().rows[k]));
    }
    if (!factor.factorize()) state.SkipWithError("not positive definite");
  }
  state.counters["log_determinant"] = factor.log_determinant();
}

double log_determinant(const Eigen::SimplicialLDLT<Sparse>& factor) {
  return factor.vectorD().array().log().sum();
}
template <class Factor>
double log_determinant(const Factor& factor) {
  return factor.logDeterminant();
}

/// Without setting the values of the matrix.
template <class Factor>
void theirs(benchmark::State& state) {
  const Sparse matrix = matrix_of(pairs());
  Factor factor;
  factor.analyzePattern(matrix);
  for ([[maybe_unused]] auto _ : state) factor.factorize(matrix);
  state.counters["log_determinant"] = log_determinant(factor);
}

BENCHMARK(ours)->Unit(benchmark::kMillisecond);
BENCHMARK(theirs<Eigen::SimplicialLDLT<Sparse>>)->Unit(benchmark::kMillisecond);
BENCHMARK(theirs<Eigen::CholmodSimplicialLDLT<Sparse>>)->Unit(benchmark::kMillisecond);
BENCHMARK(theirs<Eigen::CholmodSupernodalLLT<Sparse>>)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
