// SPDX-License-Identifier: MIT
#include "silvafit/base/ranks.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"

namespace silvafit {
namespace {

TEST_CASE("without a job, there is one rank that has its own bytes") {
  Ranks& ranks = Ranks::of_process();
  CHECK(ranks.size() == 1);
  CHECK(ranks.is_first());
  CHECK(ranks.gather("own") == std::vector<std::string>{"own"});
}

TEST_CASE("results of tasks are in order, also from nested tasks") {
  const auto outer = farm(5, 2, [](std::size_t i) {
    std::string text;
    for (const std::string& part : farm(i, 2, [](std::size_t k) { return std::to_string(k); })) {
      text += part;
    }
    return text;
  });
  CHECK(outer == std::vector<std::string>{"", "0", "01", "012", "0123"});
  CHECK(farm(0, 1, [](std::size_t) { return std::string("x"); }).empty());
}

TEST_CASE("numbers and texts are read back from bytes unchanged") {
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> numbers{0.1, -0.0, infinity, 5e-324};
  std::string bytes;
  append_numbers(numbers.data(), numbers.size(), bytes);
  append_text(std::string("a\0b", 3), bytes);
  append_numbers(nullptr, 0, bytes);
  append_text("", bytes);
  std::string_view rest = bytes;
  const std::vector<double> back = take_numbers(rest);
  CHECK(back == numbers);
  CHECK(std::signbit(back[1]));
  CHECK(take_text(rest) == std::string("a\0b", 3));
  CHECK(take_numbers(rest).empty());
  CHECK(take_text(rest).empty());
  CHECK(rest.empty());
  std::string_view cut = std::string_view(bytes).substr(0, 20);
  CHECK_THROWS_AS(take_numbers(cut), Error);
}

}  // namespace
}  // namespace silvafit
