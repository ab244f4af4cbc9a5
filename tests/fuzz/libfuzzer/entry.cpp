// SPDX-License-Identifier: Apache-2.0
// What libFuzzer calls: compiled once per target, SOAK_FUZZ_TARGET is its entry function.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  (void)soak::fuzz::SOAK_FUZZ_TARGET({data, size});
  return 0;
}
