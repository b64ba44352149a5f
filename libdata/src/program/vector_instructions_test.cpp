// SPDX-License-Identifier: MIT
#include "silvafit/data/vector_instructions.hpp"

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "program/each_instruction_set_test_support.hpp"

namespace silvafit::data {
namespace {

TEST_CASE("The instruction set named is the one that runs", "[vector]") {
  std::vector<std::string> named;
  with_each_instruction_set([&](const std::string& target) {
    const std::string name = vector_instructions();
    INFO(target << " is called " << name);
    CHECK(name.substr(0, 3) == (name == "none" ? "non" : target.substr(0, 3)));
    CHECK(std::ranges::find(named, name) == named.end());
    named.push_back(name);
  });
  REQUIRE_FALSE(named.empty());
}

// The kernel's list of the processor's abilities, which Highway does not read.
TEST_CASE("The best instruction set of the processor is named", "[vector]") {
  std::ifstream file("/proc/cpuinfo");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  if (text.find("flags\t") == std::string::npos) {
    WARN("skipped: no x86 processor");
    return;
  }
  const bool has_512 = text.find(" avx512dq ") != std::string::npos;
  const bool has_fma =
      text.find(" avx2 ") != std::string::npos && text.find(" fma ") != std::string::npos;
  CHECK((vector_instructions() == "AVX-512") == has_512);
  CHECK((vector_instructions() == "AVX2 with FMA") == (has_fma && !has_512));
}

}  // namespace
}  // namespace silvafit::data
