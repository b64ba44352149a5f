// SPDX-License-Identifier: MIT
// The instruction sets that vector code is compiled for.
//
// Include this before anything else of Highway. A source with such code is compiled once for each
// of them, and the best one that the processor has is chosen when the program runs (Highway's
// dynamic dispatch). The baseline of the build is always among them. On x86-64 these are the
// baseline, SSE4, AVX2 with FMA, and AVX-512. Omitted are sets that are no faster for doubles
// (SSSE3, AVX3_DL), and vectors whose length is unknown when compiling (SVE, RISC-V), because our
// arrays of vectors need it; ARM uses NEON.
//
// Code inside HWY_NAMESPACE may use Highway and plain functions of C only. The linker could merge
// any other template that is compiled there with the same template of ordinary sources, and those
// would then run instructions that the processor lacks.
#pragma once

#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)

#include <hwy/targets.h>
