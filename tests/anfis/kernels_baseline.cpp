// SPDX-License-Identifier: Apache-2.0
// A second copy of the kernels without clones for newer processors, under another name: kernels_test.cpp compares both.
#include "kernels_baseline.h"

// Their headers first, under their own names; then the source as part of another namespace.
#include <cmath>

#include "anfis/model/detail/inference.h"
#include "anfis/objective/kernels.h"
#include "base/instruction_set.h"
#undef SOAK_CLONES
#define SOAK_CLONES
#define training training::baseline
#include "anfis/objective/kernels.cpp"  // NOLINT(bugprone-suspicious-include): the point of this file
