// SPDX-License-Identifier: MIT
#include "silvafit/base/read_ahead.hpp"

#include <catch2/catch.hpp>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

using silvafit::ReadAhead;

TEST_CASE("parts that are read ahead come in order, with any number of threads") {
  for (const unsigned threads : {1U, 2U, 4U}) {
    int last = 0;
    ReadAhead<std::optional<int>> ahead(
        [&last]() -> std::optional<int> {
          return last < 100 ? std::optional(++last) : std::nullopt;
        },
        threads);
    std::vector<int> found;
    while (const auto part = ahead.next()) found.push_back(*part);
    REQUIRE(found.size() == 100);
    for (int i = 0; i < 100; ++i) CHECK(found[static_cast<std::size_t>(i)] == i + 1);
    CHECK_FALSE(ahead.next());
  }
}

TEST_CASE("an error of reading comes with its part, after the parts before") {
  for (const unsigned threads : {1U, 2U}) {
    int last = 0;
    ReadAhead<std::unique_ptr<int>> ahead(
        [&last] {
          if (++last == 3) throw std::runtime_error("part 3");
          return std::make_unique<int>(last);
        },
        threads);
    CHECK(*ahead.next() == 1);
    CHECK(*ahead.next() == 2);
    CHECK_THROWS_WITH(ahead.next(), "part 3");
  }
}

TEST_CASE("parts need not be read to the end") {
  int last = 0;
  {
    ReadAhead<std::optional<int>> ahead([&last] { return std::optional(++last); }, 2);
    CHECK(ahead.next() == 1);
  }
  CHECK(last <= 2);
}
