// SPDX-License-Identifier: MIT
#include "silvafit/stand/inventory.hpp"

#include "fuzz_target.hpp"

void silvafit::fuzz::read(std::string_view bytes) {
  const FileOfBytes file(bytes);
  stand::read_inventory(file.path(), {.keep_all = true});
}
