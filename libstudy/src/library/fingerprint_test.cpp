// SPDX-License-Identifier: MIT
#include "library/fingerprint.hpp"

#include <catch2/catch.hpp>

// Test vectors of the FNV draft.
TEST_CASE("the fingerprint is FNV-1a") {
  CHECK(silvafit::study::fingerprint("") == "fnv1a64:cbf29ce484222325");
  CHECK(silvafit::study::fingerprint("a") == "fnv1a64:af63dc4c8601ec8c");
  CHECK(silvafit::study::fingerprint("foobar") == "fnv1a64:85944171f73967e8");
}
