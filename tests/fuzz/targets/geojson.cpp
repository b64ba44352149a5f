// SPDX-License-Identifier: MIT
#include "fuzz_target.hpp"
#include "silvafit/stand/window.hpp"

void silvafit::fuzz::read(std::string_view bytes) {
  const FileOfBytes file(bytes);
  stand::read_windows(file.path());
}
