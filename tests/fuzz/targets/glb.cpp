// SPDX-License-Identifier: MIT
#include "fuzz_target.hpp"
#include "silvafit/tree/scene_reader.hpp"

void silvafit::fuzz::read(std::string_view bytes) { tree::read_glb(bytes).triangle_count(); }
