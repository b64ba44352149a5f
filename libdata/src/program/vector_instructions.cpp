// SPDX-License-Identifier: MIT
#include "silvafit/data/vector_instructions.hpp"

#include "program/vector_targets.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "program/vector_instructions.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace silvafit::data {
namespace HWY_NAMESPACE {
namespace {

const char* name_of_target() {
#if HWY_TARGET == HWY_AVX3
  return "AVX-512";
#elif HWY_TARGET == HWY_AVX2
  return "AVX2 with FMA";
#elif HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128
  return "none";
#else
  return hwy::TargetName(HWY_TARGET);
#endif
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace silvafit::data
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace silvafit::data {
namespace {

HWY_EXPORT(name_of_target);

}  // namespace

std::string vector_instructions() { return HWY_DYNAMIC_DISPATCH(name_of_target)(); }

}  // namespace silvafit::data
#endif  // HWY_ONCE
