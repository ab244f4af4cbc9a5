/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/mcu/evaluate.h"

#include "calib/runtime/soak_runtime.h"

static const float kRaw[6] = {0.1f, -0.2f, 0.3f, 1.0f, -2.0f, 9.8f};

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

static void evaluate_at(const soak_cal* cal, const char* name, float temp_c, print_function print) {
  char line[256];
  char* at = append_text(line, name);
  float values[18];
  uint32_t flags = 0U;
  int i;
  const soak_status applied = soak_apply(cal, temp_c, kRaw, values, &flags);
  uint32_t worst = (uint32_t)applied;
  for (i = 0; i < 6; ++i) worst = worst * 4U + (uint32_t)soak_bias(cal, i, temp_c, &values[6 + i]);
  for (i = 0; i < 6; ++i) worst = worst * 4U + (uint32_t)soak_scale_ppm(cal, i, temp_c, &values[12 + i]);
  at = append_hex(append_text(append_float(at, temp_c), " "), worst);
  at = append_hex(append_text(at, " "), flags);
  for (i = 0; i < 18; ++i) at = append_float(at, values[i]);
  (void)append_text(at, "\n");
  print(line);
}

void evaluate_file(const char* name, const uint8_t* file, size_t size, print_function print) {
  soak_cal cal;
  int i;
  if (soak_load(&cal, file, size) != SOAK_OK) {
    print("refused\n");
    return;
  }
  for (i = 0; i <= 346; ++i) evaluate_at(&cal, name, -45.0f + 0.375f * (float)i, print);
}
