/* SPDX-License-Identifier: Apache-2.0 */
/* What docs/deployment.md shows, as one program; every line of code on that page stands here. */
#include "SN-0001.h"
#include "soak_terms.h"

static soak_cal cal;

static void report_fault(const char* what) { (void)what; }

/* [load] */
int calibration_start(void) {
  if (soak_load(&cal, soak_calibration_SN_0001, sizeof soak_calibration_SN_0001) != SOAK_OK) {
    report_fault("calibration refused: flying uncorrected");
    return 0;
  }
  if (cal.simulated != 0U) {
    report_fault("calibration made from simulated data");
    return 0;
  }
  return 1;
}
/* [load] */

/* [apply] */
soak_status correct(float temp_c, const float raw[6], float out[6]) {
  uint32_t flags;
  const soak_status status = soak_apply(&cal, temp_c, raw, out, &flags);
  if (status == SOAK_OK) return status;
  if ((flags & SOAK_FLAG_CLAMPED(SOAK_GYRO_X)) != 0U) report_fault("gyro x: temperature out of range");
  if ((flags & SOAK_FLAG_ABSENT(SOAK_GYRO_X)) != 0U) report_fault("gyro x: not calibrated, raw");
  if ((flags & SOAK_FLAG_INVALID(SOAK_GYRO_X)) != 0U) report_fault("gyro x: not usable, raw");
  return status;
}
/* [apply] */

/* [moving] */
static soak_terms terms;

soak_status correct_moving(float temp_c, float temp_rate_kps, const float raw[6], float out[6]) {
  uint32_t flags;
  return soak_apply_moving(&cal, &terms, temp_c, temp_rate_kps, raw, out, &flags);
}
/* [moving] */

/* [uncertainty] */
float gyro_x_sigma(float temp_c) {
  float ci95, pi95;
  const soak_status status = soak_uncertainty(&cal, SOAK_GYRO_X, temp_c, &ci95, &pi95);
  if (status != SOAK_OK) return 0.02f; /* rad/s: what the data sheet says of an uncalibrated unit */
  return pi95 / 1.96f;
}

float misalignment_sigma(int row, int column) {
  float sigma[9];
  if (soak_coupling_sigma(&cal, SOAK_MISALIGNMENT, sigma) != SOAK_OK) return 0.01f; /* rad: what the data sheet says */
  return sigma[3 * row + column];
}

float accel_x_left_over(float force_mps2) {
  float value, sigma;
  if (soak_even_order(&cal, SOAK_ACCEL_X, &value, &sigma) != SOAK_OK) return 0.0f;
  const float excess = force_mps2 * force_mps2 - 9.80665f * 9.80665f;
  return ((value < 0.0f ? -value : value) + sigma) * (excess < 0.0f ? -excess : excess);
}
/* [uncertainty] */

/* [vectors] */
static const struct {
  float temp_c, bias_dps;
} kVectors[] = {{-29.5f, 0.750908f}, {25.0f, 0.582280f}};

int self_test(void) {
  unsigned i;
  for (i = 0; i < sizeof kVectors / sizeof kVectors[0]; ++i) {
    float bias;
    if (soak_bias(&cal, SOAK_GYRO_X, kVectors[i].temp_c, &bias) != SOAK_OK) return 0;
    const float difference = bias * 57.29578f - kVectors[i].bias_dps;
    if (difference > 1e-5f || difference < -1e-5f) return 0;
  }
  return 1;
}
/* [vectors] */

/* [error] */
int is_exact_enough(float limit) {
  float bound;
  return soak_curve_error(&cal, SOAK_GYRO_X, 0, &bound) == SOAK_OK && bound <= limit;
}
/* [error] */

int main(void) {
  const float raw[6] = {0.01f, 0.0f, 0.0f, 0.1f, 0.0f, 9.8f};
  float out[6];
  if (!calibration_start() || !self_test()) return 1;
  if (correct(25.0f, raw, out) != SOAK_OK || correct(90.0f, raw, out) != SOAK_CLAMPED) return 2;
  if (!(gyro_x_sigma(25.0f) < 0.02f) || !is_exact_enough(1e-6f)) return 3;
  if (soak_load_terms(&terms, &cal) < 0 || correct_moving(25.0f, 0.01f, raw, out) != SOAK_OK) return 5;
  if (!(misalignment_sigma(0, 1) <= 0.01f) || !(accel_x_left_over(29.4f) >= 0.0f)) return 4;
  return 0;
}
