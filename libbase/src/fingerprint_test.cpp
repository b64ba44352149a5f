// SPDX-License-Identifier: MIT
#include "silvafit/base/fingerprint.hpp"

#include <catch2/catch.hpp>

// Test vectors of the FNV draft.
TEST_CASE("the fingerprint is FNV-1a") {
  CHECK(silvafit::fingerprint("") == "fnv1a64:cbf29ce484222325");
  CHECK(silvafit::fingerprint("a") == "fnv1a64:af63dc4c8601ec8c");
  CHECK(silvafit::fingerprint("foobar") == "fnv1a64:85944171f73967e8");
  silvafit::Fingerprint pieces;
  for (const char* piece : {"foo", "", "bar"}) pieces.add(piece);
  CHECK(pieces.text() == "fnv1a64:85944171f73967e8");
}
