/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/calib/runtime_c/runtime_as_c.h"

#include "calib/runtime/soak_history.h"

int runtime_as_c_apply(const uint8_t* file, size_t size, float temp_c, const float raw[6], float out[6],
                       uint32_t* flags) {
  soak_cal cal;
  const soak_status loaded = soak_load(&cal, file, size);
  if (loaded != SOAK_OK) return loaded;
  return soak_apply(&cal, temp_c, raw, out, flags);
}

int runtime_as_c_apply_moving(const uint8_t* file, size_t size, float temp_c, float temp_rate_kps, const float raw[6],
                              float out[6], uint32_t* flags) {
  soak_cal cal;
  soak_terms terms;
  soak_status loaded = soak_load(&cal, file, size);
  if (loaded != SOAK_OK) return loaded;
  loaded = soak_load_terms(&terms, &cal);
  if (loaded < 0) return loaded;
  return soak_apply_moving(&cal, &terms, temp_c, temp_rate_kps, raw, out, flags);
}

int runtime_as_c_apply_history(const uint8_t* file, size_t size, const float* path_c, size_t count, float temp_rate_kps,
                               const float raw[6], float out[6], uint32_t* flags) {
  soak_cal cal;
  soak_terms terms;
  soak_history history;
  size_t k;
  soak_status loaded = soak_load(&cal, file, size);
  if (loaded != SOAK_OK) return loaded;
  if ((loaded = soak_load_terms(&terms, &cal)) < 0 || (loaded = soak_load_history(&history, &cal)) < 0) return loaded;
  for (k = 0; k < count; ++k) (void)soak_history_step(&history, path_c[k]);
  return soak_apply_history(&cal, &terms, &history, path_c[count - 1U], temp_rate_kps, raw, out, flags);
}
