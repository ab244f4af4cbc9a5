/* SPDX-License-Identifier: Apache-2.0 */
/* On the microcontroller: the values of all golden files, and instructions per call. */
#include "calib/runtime/soak_history.h"
#include "tests/mcu/board.h"
#include "tests/mcu/evaluate.h"

enum { kTemperatures = 256, kInstructionsPerTick = 40 };

#define GOLDEN(name) extern const uint8_t golden_##name[], golden_##name##_end[]
GOLDEN(fis);
GOLDEN(whole);
GOLDEN(mixed);
GOLDEN(table);
GOLDEN(couplings);
GOLDEN(moving);

static soak_cal cal;
static soak_history history;
static volatile float sink;

typedef void (*work)(float temp_c);

static void nothing(float temp_c) { sink = temp_c; }

/* 100 instructions more than nothing(): shows that the counter counts. */
static void hundred_more(float temp_c) {
  sink = temp_c;
  __asm__ volatile(".rept 100\n nop\n .endr");
}

static void apply(float temp_c) {
  static const float raw[6] = {0.1f, -0.2f, 0.3f, 1.0f, -2.0f, 9.8f};
  float out[6];
  uint32_t flags;
  if (soak_apply(&cal, temp_c, raw, out, &flags) >= SOAK_OK) sink = out[0];
}

/* Each call moves the rod. */
static void history_step(float temp_c) { sink = (float)soak_history_step(&history, temp_c); }

static void history_apply(float temp_c) {
  static const float raw[6] = {0.1f, -0.2f, 0.3f, 1.0f, -2.0f, 9.8f};
  float out[6];
  uint32_t flags;
  if (soak_apply_history(&cal, NULL, &history, temp_c, 0.0f, raw, out, &flags) >= SOAK_OK) sink = out[0];
}

static void bias_of(int sensor, float temp_c) {
  float bias;
  if (soak_bias(&cal, sensor, temp_c, &bias) >= SOAK_OK) sink = bias;
}

static void gyro_bias(float temp_c) { bias_of(SOAK_GYRO_X, temp_c); }
static void accel_bias(float temp_c) { bias_of(SOAK_ACCEL_X, temp_c); }

static uint32_t instructions_of(work run) {
  uint32_t i;
  board_start_counter();
  for (i = 0; i < kTemperatures; ++i) run(-30.0f + 0.390625f * (float)i);
  return board_ticks() * kInstructionsPerTick;
}

/* Prints `count NAME instructions per call`. */
static void count(const char* name, work run) {
  const uint32_t extra = instructions_of(run) - instructions_of(nothing);
  char line[96];
  char* at = append_text(append_text(append_text(line, "count "), name), " ");
  at = append_decimal(at, (extra + kTemperatures / 2) / kTemperatures);
  (void)append_text(at, "\n");
  board_print(line);
}

static void load(const char* name, const uint8_t* file, const uint8_t* end) {
  char line[96];
  char* at = append_text(append_text(append_text(line, "load "), name), " ");
  board_start_counter();
  if (soak_load(&cal, file, (size_t)(end - file)) != SOAK_OK) board_print("refused\n");
  at = append_text(append_decimal(at, board_ticks() * kInstructionsPerTick), " instructions, bytes ");
  (void)append_text(append_decimal(at, (uint32_t)(end - file)), "\n");
  board_print(line);
}

#define EVALUATE(name) evaluate_file(#name, golden_##name, (size_t)(golden_##name##_end - golden_##name), board_print)
#define LOAD(name) load(#name, golden_##name, golden_##name##_end)

int main(void) {
  EVALUATE(fis);
  EVALUATE(whole);
  EVALUATE(mixed);
  EVALUATE(table);
  EVALUATE(couplings);
  EVALUATE(moving);
  count("hundred_more", hundred_more);
  LOAD(fis);
  count("bell_bias", gyro_bias);
  count("gaussian_bias", accel_bias);
  count("fis_apply", apply);
  LOAD(whole);
  count("whole_bell_bias", gyro_bias);
  LOAD(mixed);
  count("spline_bias", gyro_bias);
  LOAD(table);
  count("table_bias", gyro_bias);
  count("table_apply", apply);
  LOAD(moving);
  if (soak_load_history(&history, &cal) != SOAK_OK) board_print("refused\n");
  count("moving_apply", apply);
  count("history_step", history_step);
  count("history_apply", history_apply);
  return 0;
}
