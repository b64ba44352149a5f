// SPDX-License-Identifier: MIT
#include "silvafit/base/external_sort.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/base/random.hpp"

namespace silvafit {
namespace {

using Record = std::pair<ExternalSort::Key, std::string>;

std::vector<Record> random_records(std::size_t count) {
  Random random(3, 1);
  std::vector<Record> records;
  for (std::size_t i = 0; i < count; ++i) {
    // Few different keys, so that many are equal; zero bytes and empty records among the records.
    const auto first = static_cast<std::uint64_t>(7.0 * random.uniform());
    const auto second = static_cast<std::uint64_t>(50.0 * random.uniform());
    records.emplace_back(
        ExternalSort::Key{first, second},
        i % 11 == 0 ? std::string() : std::string(i % 13, '\0') + std::to_string(i));
  }
  return records;
}

void check_sorted(std::vector<Record> records, std::size_t memory, std::size_t least_runs) {
  ExternalSort sort(memory);
  for (const auto& [key, record] : records) sort.add(key, record);
  CHECK(sort.runs() >= least_runs);
  std::ranges::stable_sort(records, {}, &Record::first);
  ExternalSort::Key key;
  std::string record;
  for (const auto& [wanted_key, wanted_record] : records) {
    REQUIRE(sort.next(key, record));
    REQUIRE(key == wanted_key);
    REQUIRE(record == wanted_record);
  }
  CHECK_FALSE(sort.next(key, record));
}

TEST_CASE("records in memory and on disk are in the order of a stable sort") {
  const std::vector<Record> records = random_records(3000);
  check_sorted(records, std::size_t{1} << 20U, 0);
  check_sorted(records, 20000, 10);
}

TEST_CASE("more runs than files that may be open are merged on the way") {
  // A record a run: 600 runs, of which 256 are merged at a time.
  check_sorted(random_records(600), 1, 80);
}

TEST_CASE("nothing sorted is nothing") {
  ExternalSort sort;
  ExternalSort::Key key;
  std::string record;
  CHECK_FALSE(sort.next(key, record));
}

}  // namespace
}  // namespace silvafit
