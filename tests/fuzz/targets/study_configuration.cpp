// SPDX-License-Identifier: MIT
#include "silvafit/study/study_configuration.hpp"

#include "fuzz_target.hpp"

void silvafit::fuzz::read(std::string_view bytes) {
  const FileOfBytes file(bytes);
  study::read_study_configuration(file.path());
}
