/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/calib/runtime_c/runtime_as_c.h"

#include "calib/runtime/soak_runtime.h"

int runtime_as_c_apply(const uint8_t* file, size_t size, float temp_c, const float raw[6], float out[6],
                       uint32_t* flags) {
  soak_cal cal;
  const soak_status loaded = soak_load(&cal, file, size);
  if (loaded != SOAK_OK) return loaded;
  return soak_apply(&cal, temp_c, raw, out, flags);
}
