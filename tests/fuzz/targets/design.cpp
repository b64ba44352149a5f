// SPDX-License-Identifier: MIT
// The design of a simulated inventory.
#include "fuzz_target.hpp"
#include "silvafit/study/simulate.hpp"

void silvafit::fuzz::read(std::string_view bytes) {
  const FileOfBytes file(bytes);
  study::read_design(file.path());
}
