/* SPDX-License-Identifier: Apache-2.0 */
/* What docs/deployment.md shows, as one program; every line of code on that page stands here. */
#include "SN-0001.h"
#include "soak_history.h"
#include "soak_terms.h"

static soak_cal cal;

static void report_fault(const char* what) { (void)what; }

/* [load] */
int calibration_start(const char* serial) {
  if (soak_load(&cal, soak_calibration_SN_0001, sizeof soak_calibration_SN_0001) != SOAK_OK) {
    report_fault("calibration refused: flying uncorrected");
    return 0;
  }
  if (!soak_is_of_unit(&cal, serial)) {
    report_fault("calibration of another unit");
    return 0;
  }
  if (cal.simulated != 0U) {
    report_fault("calibration made from simulated data");
    return 0;
  }
  if (cal.unreleased != 0U) {
    report_fault("calibration that nobody has released");
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
  if ((flags & SOAK_FLAG_SCALE(SOAK_GYRO_X)) != 0U) report_fault("gyro x: scale factor not measured here");
  return status;
}
/* [apply] */

/* [several] */
soak_status correct_several(float unit_temp_c, const float own_temps_c[6], const float raw[6], float out[6]) {
  float temps_c[6];
  uint32_t flags;
  int i;
  for (i = 0; i < SOAK_SENSORS; ++i) {
    temps_c[i] = soak_has_own_thermometer(&cal, i) ? own_temps_c[i] : unit_temp_c;
  }
  return soak_apply_temps(&cal, temps_c, raw, out, &flags);
}
/* [several] */

/* [moving] */
static soak_terms terms;

soak_status correct_moving(float temp_c, float temp_rate_kps, const float raw[6], float out[6]) {
  uint32_t flags;
  return soak_apply_moving(&cal, &terms, temp_c, temp_rate_kps, raw, out, &flags);
}
/* [moving] */

/* [history] */
static soak_history history;

int history_start(const soak_memory* kept) { /* null: nothing was kept from before the power cycle */
  if (soak_load_history(&history, &cal) < 0) return 0;
  return kept == NULL || soak_history_resume(&history, kept) == SOAK_OK;
}

void new_temperature(float temp_c) { /* each reading of the thermometer, or one every few seconds */
  if (soak_history_step(&history, temp_c) != SOAK_OK) report_fault("thermometer: no temperature");
}

soak_status correct_remembering(float temp_c, float temp_rate_kps, const float raw[6], float out[6]) {
  uint32_t flags;
  return soak_apply_history(&cal, &terms, &history, temp_c, temp_rate_kps, raw, out, &flags);
}

float gyro_x_unknown(float temp_c) { /* rad/s */
  float bound;
  return soak_history_unknown(&history, SOAK_GYRO_X, temp_c, &bound) == SOAK_OK ? bound : 0.0f;
}
/* [history] */

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
#define DEGREE 0.017453293f

/* soak eval SN-0001.soakcal --temp-c -29.5,25,90 --raw 10,-20,30,0.5,-1.5,9.75 --json */
static const float kRaw[6] = {10.0f, -20.0f, 30.0f, 0.5f, -1.5f, 9.75f};
static const struct {
  float temp_c, out[6];
  uint32_t flags;
} kVectors[] = {{-29.5f, {9.249092f, -20.830435f, 29.090039f, 0.517435f, -1.512537f, 9.674968f}, 0U},
                {25.0f, {9.417720f, -20.586863f, 29.408553f, 0.688466f, -1.310442f, 9.920073f}, 0U},
                {90.0f, {9.464351f, -20.478353f, 29.578943f, 0.783201f, -1.189622f, 10.074405f}, 0x3FU}};

int self_test(void) {
  unsigned n, i;
  for (n = 0; n < sizeof kVectors / sizeof kVectors[0]; ++n) {
    float raw[6], out[6];
    uint32_t flags;
    for (i = 0; i < 6U; ++i) raw[i] = i < 3U ? kRaw[i] * DEGREE : kRaw[i];
    if (soak_apply(&cal, kVectors[n].temp_c, raw, out, &flags) < SOAK_OK || flags != kVectors[n].flags) return 0;
    for (i = 0; i < 6U; ++i) {
      const float difference = (i < 3U ? out[i] / DEGREE : out[i]) - kVectors[n].out[i];
      if (difference > 1e-5f || difference < -1e-5f) return 0;
    }
  }
  return 1;
}
/* [vectors] */

/* [update] */
int is_update(const soak_cal* candidate, const char* serial) {
  soak_identity now, then;
  if (!soak_is_of_unit(candidate, serial) || candidate->simulated != 0U || candidate->unreleased != 0U) return 0;
  if (soak_identify(candidate, &then) != SOAK_OK) return 0;
  if (soak_identify(&cal, &now) != SOAK_OK) return 1; /* nothing is loaded */
  return then.epoch > now.epoch || (then.epoch == now.epoch && then.model_version > now.model_version);
}
/* [update] */

#ifdef DEPLOY_WITH_SODIUM /* the loader, which checks signatures */
#include <sodium.h>
#include <string.h>

/* [verify] */
/* room: 16 bytes that are free, then the `size` bytes of the file. */
int is_signed(uint8_t* room, size_t size, const uint8_t public_key[32]) {
  static const uint8_t head[8] = {0x40, 0x00, 0x01, 0x00, 0x48, 0x00, 0x00, 0x00};
  const uint8_t* file = room + 16;
  if (size < 112U || memcmp(file + size - 84, head, 8) != 0) return 0;
  memcpy(room, "soak-signature-1", 16);
  return crypto_sign_verify_detached(file + size - 68, room, 16U + size - 68U, public_key) == 0;
}
/* [verify] */

static int check_signature(void) {
#include "signed.h" /* room, key */
  if (sodium_init() < 0 || !is_signed(room, sizeof room - 16U, key)) return 0;
  room[16 + 100] ^= 1U;
  if (is_signed(room, sizeof room - 16U, key)) return 0;
  return !is_signed(room, 40U, key);
}
#else
static int check_signature(void) { return 1; }
#endif

/* [error] */
int is_exact_enough(float limit) {
  float bound;
  return soak_curve_error(&cal, SOAK_GYRO_X, 0, &bound) == SOAK_OK && bound <= limit;
}
/* [error] */

int main(void) {
  const float raw[6] = {0.01f, 0.0f, 0.0f, 0.1f, 0.0f, 9.8f};
  float out[6];
  if (calibration_start("SN-0002") || !calibration_start("SN-0001") || !self_test()) return 1;
  if (correct(25.0f, raw, out) != SOAK_OK || correct(90.0f, raw, out) != SOAK_CLAMPED) return 2;
  if (!(gyro_x_sigma(25.0f) < 0.02f) || !is_exact_enough(1e-6f)) return 3;
  if (soak_load_terms(&terms, &cal) < 0 || correct_moving(25.0f, 0.01f, raw, out) != SOAK_OK) return 5;
  if (!history_start(NULL)) return 8;
  new_temperature(25.0f);
  if (correct_remembering(25.0f, 0.01f, raw, out) != SOAK_OK || gyro_x_unknown(25.0f) != 0.0f) return 8;
  if (correct_several(25.0f, raw, raw, out) != SOAK_OK) return 6;
  if (is_update(&cal, "SN-0001") || !check_signature()) return 7;
  if (!(misalignment_sigma(0, 1) <= 0.01f) || !(accel_x_left_over(29.4f) >= 0.0f)) return 4;
  return 0;
}
