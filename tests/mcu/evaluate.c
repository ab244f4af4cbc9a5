/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/mcu/evaluate.h"

#include "calib/runtime/soak_history.h"

static const float kRaw[6] = {0.1f, -0.2f, 0.3f, 1.0f, -2.0f, 9.8f};
static const float kTempRate_kps = 0.015625f; /* 0.94 K/min */

char* append_text(char* at, const char* text) {
  while (*text != '\0') *at++ = *text++;
  *at = '\0';
  return at;
}

char* append_hex(char* at, uint32_t number) {
  int shift;
  for (shift = 28; shift >= 0; shift -= 4) *at++ = "0123456789abcdef"[(number >> shift) & 15U];
  *at = '\0';
  return at;
}

char* append_decimal(char* at, uint32_t number) {
  if (number >= 10U) at = append_decimal(at, number / 10U);
  *at++ = (char)('0' + (int)(number % 10U));
  *at = '\0';
  return at;
}

static char* append_float(char* at, float value) { return append_hex(append_text(at, " "), soak_bits_of(value)); }

static char* append_floats(char* at, const float* values, int count) {
  int i;
  for (i = 0; i < count; ++i) at = append_float(at, values[i]);
  return at;
}

/* A status and flags. */
static char* append_state(char* at, uint32_t status, uint32_t flags) {
  return append_hex(append_text(append_hex(append_text(at, " "), status), " "), flags);
}

static void evaluate_at(const soak_cal* cal, const soak_terms* terms, soak_history* history, const char* name,
                        float temp_c, print_function print) {
  char line[512];
  char* at = append_text(line, name);
  float values[42];
  uint32_t flags = 0U, moving_flags = 0U, history_flags = 0U, bands = 0U;
  int i;
  const soak_status applied = soak_apply(cal, temp_c, kRaw, values, &flags);
  const soak_status moving = soak_apply_moving(cal, terms, temp_c, kTempRate_kps, kRaw, values + 18, &moving_flags);
  uint32_t worst = (uint32_t)applied;
  for (i = 0; i < 6; ++i) worst = worst * 4U + (uint32_t)soak_bias(cal, i, temp_c, &values[6 + i]);
  for (i = 0; i < 6; ++i) worst = worst * 4U + (uint32_t)soak_scale_ppm(cal, i, temp_c, &values[12 + i]);
  for (i = 0; i < 6; ++i) {
    bands = bands * 4U + (uint32_t)soak_uncertainty(cal, i, temp_c, &values[24 + i], &values[30 + i]);
  }
  bands = bands * 4U + (uint32_t)soak_history_step(history, temp_c);
  bands = bands * 4U +
          (uint32_t)soak_apply_history(cal, terms, history, temp_c, kTempRate_kps, kRaw, values + 36, &history_flags);
  at = append_state(append_float(at, temp_c), worst, flags);
  at = append_state(at, (uint32_t)moving * 65536U + bands, moving_flags * 65536U + history_flags);
  (void)append_text(append_floats(at, values, 42), "\n");
  print(line);
}

/* What the file says once, whatever the temperature. */
static void evaluate_constants(const soak_cal* cal, const soak_terms* terms, const char* name, print_function print) {
  char line[512];
  float values[36];
  uint32_t status = 0U;
  int i;
  status = status * 4U + (uint32_t)soak_coupling_sigma(cal, SOAK_MISALIGNMENT, values);
  status = status * 4U + (uint32_t)soak_coupling_sigma(cal, SOAK_G_SENSITIVITY, values + 9);
  for (i = 0; i < 3; ++i) {
    status = status * 4U + (uint32_t)soak_even_order(cal, SOAK_ACCEL_X + i, &values[18 + i], &values[21 + i]);
  }
  for (i = 0; i < 12; ++i) status = status * 2U + (soak_curve_error(cal, i / 2, i % 2, &values[24 + i]) != SOAK_OK);
  (void)append_text(
      append_floats(append_state(append_text(append_text(line, name), " constants"), status, terms->count), values, 36),
      "\n");
  print(line);
}

void evaluate_file(const char* name, const uint8_t* file, size_t size, print_function print) {
  soak_cal cal;
  soak_terms terms;
  soak_history history;
  int i;
  if (soak_load(&cal, file, size) != SOAK_OK || soak_load_terms(&terms, &cal) < 0 ||
      soak_load_history(&history, &cal) < 0) {
    print("refused\n");
    return;
  }
  evaluate_constants(&cal, &terms, name, print);
  for (i = 0; i <= 346; ++i) evaluate_at(&cal, &terms, &history, name, -45.0f + 0.375f * (float)i, print);
}
