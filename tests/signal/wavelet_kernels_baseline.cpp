// SPDX-License-Identifier: Apache-2.0
// A second copy of the kernels without clones for newer processors, under another name: wavelet_kernels_test.cpp
// compares both.
#include "wavelet_kernels_baseline.h"

// Their headers first, under their own names; then the source as part of another namespace.
#include <cstring>

#include "base/instruction_set.h"
#include "calib/signal/wavelet/detail/kernels.h"
#undef SOAK_CLONES
#define SOAK_CLONES
#define wavelet wavelet::baseline
#include "calib/signal/wavelet/detail/kernels.cpp"  // NOLINT(bugprone-suspicious-include): the point of this file
