// SPDX-License-Identifier: MIT
#include "silvafit/data/row_sums.hpp"

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "program/each_instruction_set_test_support.hpp"
#include "silvafit/base/random.hpp"

using silvafit::Random;
using silvafit::data::with_each_instruction_set;

namespace {

// Lengths around the vectors and the running sums, and long ones.
const std::vector<std::size_t> kLengths = {0,  1,  2,  3,  4,   5,   7,    8,   9,
                                           12, 15, 16, 17, 18,  23,  24,   25,  31,
                                           32, 33, 40, 47, 100, 257, 1000, 5001};

std::vector<double> random_values(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> values(count);
  for (double& value : values) value = random.uniform(-1.0, 2.0);
  return values;
}

/// The sum of terms with the rounding of 64 bits, and the bound for adding `rows` terms in any
/// order with 53 bits: gamma_n times the sum of sizes (Higham 2002, Accuracy and Stability,
/// section 4.2); a product of three rounds twice more.
struct Expected {
  long double sum = 0.0L;
  long double sizes = 0.0L;
  std::size_t rows = 0;
  void add(long double term) {
    sum += term;
    sizes += std::abs(term);
    ++rows;
  }
  double bound() const {
    return static_cast<double>((static_cast<long double>(rows) + 2.0L) *
                               (std::numeric_limits<double>::epsilon() / 2.0L) * sizes);
  }
};

void check_sum(double value, const Expected& expected) {
  CAPTURE(expected.rows);
  CHECK(std::abs(value - static_cast<double>(expected.sum)) <= expected.bound());
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

}  // namespace

TEST_CASE("sums over rows are right for any length") {
  const std::vector<double> w = random_values(5001, 1);
  const std::vector<double> a = random_values(5001, 2);
  const std::vector<double> b = random_values(5001, 3);
  with_each_instruction_set([&](const std::string& set) {
    CAPTURE(set);
    for (const std::size_t rows : kLengths) {
      Expected plain;
      Expected product;
      Expected weighted;
      for (std::size_t i = 0; i < rows; ++i) {
        const long double term = a[i];
        plain.add(term);
        product.add(term * b[i]);
        weighted.add(term * b[i] * w[i]);
      }
      check_sum(silvafit::data::sum(a.data(), rows), plain);
      check_sum(silvafit::data::dot(a.data(), b.data(), rows), product);
      check_sum(silvafit::data::weighted_dot(w.data(), a.data(), b.data(), rows), weighted);
    }
  });
}

TEST_CASE("a sum does not read beyond its rows") {
  with_each_instruction_set([&](const std::string& set) {
    CAPTURE(set);
    for (std::size_t rows = 0; rows < 40; ++rows) {
      std::vector<double> a(rows + 16, std::numeric_limits<double>::quiet_NaN());
      std::fill_n(a.begin(), rows, 1.0);
      const double count = static_cast<double>(rows);
      CHECK(silvafit::data::sum(a.data(), rows) == count);
      CHECK(silvafit::data::dot(a.data(), a.data(), rows) == count);
      CHECK(silvafit::data::weighted_dot(a.data(), a.data(), a.data(), rows) == count);
      const std::vector<const double*> columns{a.data()};
      double product = -1.0;
      silvafit::data::weighted_products(columns, a.data(), rows, &product);
      CHECK(product == count);
    }
  });
}

TEST_CASE("a sum does not depend on where its rows lie") {
  const std::vector<double> values = random_values(1000, 4);
  with_each_instruction_set([&](const std::string& set) {
    CAPTURE(set);
    for (const std::size_t rows : {std::size_t{5}, std::size_t{37}, std::size_t{900}}) {
      const double expected = silvafit::data::sum(values.data(), rows);
      const double expected_dot = silvafit::data::dot(values.data(), values.data(), rows);
      for (std::size_t shift = 1; shift < 9; ++shift) {
        std::vector<double> moved(rows + shift);
        std::copy_n(values.begin(), rows, moved.begin() + static_cast<std::ptrdiff_t>(shift));
        CHECK(same_bits(silvafit::data::sum(moved.data() + shift, rows), expected));
        CHECK(same_bits(silvafit::data::dot(moved.data() + shift, values.data(), rows),
                        expected_dot));
      }
    }
  });
}

TEST_CASE(
    "a plain sum is the same with every instruction set, a product where it is rounded once") {
  const std::vector<double> a = random_values(5001, 5);
  const std::vector<double> b = random_values(5001, 6);
  const std::vector<const double*> columns{a.data(), b.data()};
  for (const std::size_t rows : kLengths) {
    std::vector<double> sums;
    std::vector<std::vector<double>> fused;
    with_each_instruction_set([&](const std::string& set) {
      sums.push_back(silvafit::data::sum(a.data(), rows));
      if (set != "AVX2" && set != "AVX3" && set != "NEON") return;
      std::vector<double> products(4);
      silvafit::data::weighted_products(columns, a.data(), rows, products.data());
      products.push_back(silvafit::data::dot(a.data(), b.data(), rows));
      products.push_back(silvafit::data::weighted_dot(a.data(), a.data(), b.data(), rows));
      fused.push_back(products);
    });
    REQUIRE_FALSE(sums.empty());
    for (const double value : sums) CHECK(same_bits(value, sums.front()));
    for (const auto& products : fused) CHECK(products == fused.front());
  }
}

TEST_CASE("a missing value makes its sum missing") {
  std::vector<double> a(21, 1.0);
  with_each_instruction_set([&](const std::string& set) {
    CAPTURE(set);
    for (std::size_t i = 0; i < a.size(); ++i) {
      a[i] = std::numeric_limits<double>::quiet_NaN();
      CHECK(std::isnan(silvafit::data::sum(a.data(), a.size())));
      a[i] = std::numeric_limits<double>::infinity();
      CHECK(silvafit::data::sum(a.data(), a.size()) == a[i]);
      a[i] = 1.0;
    }
  });
}

TEST_CASE("sums of segments are the sums of their rows") {
  const std::vector<std::vector<double>> values = {
      random_values(400, 6), random_values(400, 7), random_values(400, 8)};
  const std::vector<const double*> columns{values[0].data(), values[1].data(), values[2].data()};
  const std::vector<std::size_t> begins{3, 4, 4, 9, 20, 37, 400};  // one segment without rows
  with_each_instruction_set([&](const std::string& set) {
    CAPTURE(set);
    std::vector<double> sums((begins.size() - 1) * columns.size(), -1.0);
    silvafit::data::segment_sums(columns, begins, sums.data());
    for (std::size_t s = 0; s + 1 < begins.size(); ++s) {
      for (std::size_t c = 0; c < columns.size(); ++c) {
        Expected expected;
        for (std::size_t i = begins[s]; i < begins[s + 1]; ++i) expected.add(values[c][i]);
        check_sum(sums[s * columns.size() + c], expected);
        CHECK(same_bits(sums[s * columns.size() + c],
                        silvafit::data::sum(columns[c] + begins[s], begins[s + 1] - begins[s])));
      }
    }
  });
  silvafit::data::segment_sums(columns, {}, nullptr);
}

TEST_CASE("all products of columns are right for any number of columns and rows") {
  constexpr std::size_t kColumns = 13;
  std::vector<std::vector<double>> values;
  for (std::size_t c = 0; c < kColumns; ++c) values.push_back(random_values(5001, 10 + c));
  const std::vector<double> weight = random_values(5001, 30);
  with_each_instruction_set([&](const std::string& set) {
    CAPTURE(set);
    for (std::size_t count = 1; count <= kColumns; ++count) {
      std::vector<const double*> columns;
      for (std::size_t c = 0; c < count; ++c) columns.push_back(values[c].data() + c % 3);
      for (const std::size_t rows : {0, 1, 2, 5, 7, 8, 9, 15, 16, 50, 333}) {
        for (const double* w : {static_cast<const double*>(nullptr), weight.data()}) {
          CAPTURE(count, rows, w != nullptr);
          std::vector<double> products(count * count, -1.0);
          silvafit::data::weighted_products(columns, w, rows, products.data());
          for (std::size_t j = 0; j < count; ++j) {
            for (std::size_t k = 0; k < count; ++k) {
              Expected expected;
              for (std::size_t i = 0; i < rows; ++i) {
                const long double term = static_cast<long double>(columns[j][i]) * columns[k][i];
                expected.add(w == nullptr ? term : term * w[i]);
              }
              const double value = products[j * count + k];
              REQUIRE(std::abs(value - static_cast<double>(expected.sum)) <= expected.bound());
              REQUIRE(same_bits(value, products[k * count + j]));
            }
          }
        }
      }
    }
  });
}
