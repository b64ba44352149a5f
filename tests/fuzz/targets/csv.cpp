// SPDX-License-Identifier: MIT
#include "silvafit/data/csv.hpp"

#include "fuzz_target.hpp"

void silvafit::fuzz::read(std::string_view bytes) {
  const FileOfBytes file(bytes);
  data::read_csv_table(file.path());
}
