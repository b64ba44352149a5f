// SPDX-License-Identifier: MIT
// For tests: runs a check with each instruction set of this processor, not with the best alone.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "program/vector_targets.hpp"

namespace silvafit::data {

/// Calls check(name of the instruction set) for each; afterwards the choice is as before.
template <typename Check>
void with_each_instruction_set(Check check) {
  const std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
  struct Restore {
    ~Restore() {
      hwy::SetSupportedTargetsForTest(0);
      hwy::GetChosenTarget().DeInit();
    }
  } const restore;
  for (const std::int64_t target : targets) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    check(std::string(hwy::TargetName(target)));
  }
}

}  // namespace silvafit::data
