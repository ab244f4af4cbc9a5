/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/fuzz/runtime_c/exercise.h"

#include <math.h>
#include <string.h>

#include "calib/runtime/soak_history.h"

static int same_bits(float a, float b) {
  uint32_t bits_of_a, bits_of_b;
  memcpy(&bits_of_a, &a, sizeof a);
  memcpy(&bits_of_b, &b, sizeof b);
  return bits_of_a == bits_of_b;
}

static int has_value(soak_status status) { return status == SOAK_OK || status == SOAK_CLAMPED; }

static const char* check_sensor(const soak_cal* cal, int sensor, float temp_c) {
  float value, low, high, ci95, pi95;
  soak_status status = soak_bias(cal, sensor, temp_c, &value);
  if (status < 0) return "soak_bias refuses no sensor of a loaded file";
  if (has_value(status) != soak_is_finite(value)) return "a bias is finite exactly if the status says so";
  if (soak_temp_range(cal, sensor, &low, &high) == SOAK_OK) {
    if (!(low <= high)) return "the valid range is not empty";
    if (status == SOAK_OK && !(temp_c >= low && temp_c <= high)) return "a clamped temperature is reported";
    if (status == SOAK_ABSENT) return "a sensor of the file has a bias curve";
  } else if (status != SOAK_ABSENT) {
    return "a sensor that is not in the file is absent";
  }
  status = soak_scale_ppm(cal, sensor, temp_c, &value);
  if (has_value(status) != soak_is_finite(value)) return "a scale error is finite exactly if the status says so";
  status = soak_uncertainty(cal, sensor, temp_c, &ci95, &pi95);
  if (has_value(status) && !(ci95 >= 0.0f)) return "a stated uncertainty is not negative";
  return NULL;
}

static const char* check_sample(const soak_cal* cal, float temp_c, const float raw[6]) {
  float out[6];
  uint32_t flags, i;
  const soak_status status = soak_apply(cal, temp_c, raw, out, &flags);
  if ((status == SOAK_OK) != (flags == 0U)) return "soak_apply is OK exactly if no flag is set";
  for (i = 0; i < 6U; ++i) {
    const int uncorrected = (flags & (SOAK_FLAG_ABSENT(i) | SOAK_FLAG_INVALID(i))) != 0U;
    if (uncorrected && !same_bits(out[i], raw[i])) return "an uncorrected sensor passes unchanged";
    if (!uncorrected && !soak_is_finite(out[i])) return "a corrected sensor is finite";
    if (!soak_is_finite(raw[i]) && (flags & SOAK_FLAG_INVALID(i)) == 0U)
      return "a raw value that is not finite has its flag";
  }
  return NULL;
}

/* With the temperature of each sensor known, and with one: which says why it leaves the others raw. */
static const char* check_thermometers(const soak_cal* cal, float temp_c, const float raw[6]) {
  float temps_c[6], out[6], of_one[6];
  uint32_t flags, flags_of_one, i;
  int own = 0;
  soak_status status;
  for (i = 0; i < 6U; ++i) temps_c[i] = temp_c;
  for (i = 0; i < 6U; ++i) own |= soak_has_own_thermometer(cal, (int)i);
  status = soak_apply_temps(cal, temps_c, raw, out, &flags);
  if ((status == SOAK_OK) != (flags == 0U)) return "soak_apply_temps is OK exactly if no flag is set";
  if (soak_apply(cal, temp_c, raw, of_one, &flags_of_one) < SOAK_OK) return "soak_apply refuses no loaded file";
  if (((flags_of_one & SOAK_FLAG_THERMOMETER) != 0U) != own) return "a thermometer that is not given is told";
  for (i = 0; i < 6U; ++i) {
    if (own && soak_has_own_thermometer(cal, (int)i) && !same_bits(of_one[i], raw[i])) return "its sensor stays raw";
    if (!own && !same_bits(of_one[i], out[i])) return "six equal temperatures are one";
  }
  return own || flags == flags_of_one ? NULL : "six equal temperatures have the flags of one";
}

static const char* check_identity(const soak_cal* cal) {
  soak_identity identity;
  char serial[256];
  uint32_t i;
  if (soak_identify(cal, &identity) != SOAK_OK) return soak_is_of_unit(cal, "") ? "no file is of no unit" : NULL;
  if (identity.serial_length == 0U) return "a file names its unit";
  for (i = 0; i < identity.serial_length; ++i) serial[i] = identity.serial[i];
  serial[i] = '\0';
  /* a zero inside ends the text before the file's does */
  if (strlen(serial) == i && !soak_is_of_unit(cal, serial)) return "a file is of its unit";
  serial[i - 1U] = '\0';
  return soak_is_of_unit(cal, serial) ? "a part of a serial number is another unit" : NULL;
}

static const char* check_temperature(const soak_cal* cal, float temp_c) {
  static const float samples[3][6] = {{0.1f, -0.2f, 0.3f, 1.0f, -2.0f, 9.8f},
                                      {0.0f, NAN, 1e30f, 0.0f, -INFINITY, 9.8f},
                                      {FLT_MAX, -FLT_MAX, FLT_MIN, FLT_MAX, FLT_MAX, -FLT_MAX}};
  const char* broken = NULL;
  uint32_t i;
  for (i = 0; i < 6U && broken == NULL; ++i) broken = check_sensor(cal, (int)i, temp_c);
  for (i = 0; i < 3U && broken == NULL; ++i) broken = check_sample(cal, temp_c, samples[i]);
  for (i = 0; i < 3U && broken == NULL; ++i) broken = check_thermometers(cal, temp_c, samples[i]);
  return broken;
}

static const char* check_couplings(const soak_cal* cal) {
  float sigma[9], value;
  int i, k;
  for (k = SOAK_MISALIGNMENT; k <= SOAK_G_SENSITIVITY; ++k) {
    const soak_status status = soak_coupling_sigma(cal, k, sigma);
    for (i = 0; i < 9; ++i) {
      if ((status == SOAK_OK) != (sigma[i] >= 0.0f)) return "a coupling has a sigma exactly if the status says so";
    }
    if (status == SOAK_OK && (k == SOAK_MISALIGNMENT ? cal->misalignment : cal->g_sensitivity) == NULL) {
      return "a stated sigma has its coupling";
    }
  }
  for (i = SOAK_ACCEL_X; i <= SOAK_ACCEL_Z; ++i) {
    const soak_status status = soak_even_order(cal, i, &value, sigma);
    if ((status == SOAK_OK) != soak_is_finite(value)) return "an even-order term is finite exactly if it is stated";
    if ((status == SOAK_OK) != (sigma[0] >= 0.0f)) return "an even-order term has a sigma exactly if it is stated";
  }
  return NULL;
}

static const char* check_moving(const soak_cal* cal) {
  static const float samples[2][6] = {{0.1f, -0.2f, 0.3f, 1.0f, -2.0f, 9.8f},
                                      {FLT_MAX, NAN, 1e30f, 0.0f, -INFINITY, 9.8f}};
  static const float rates[] = {0.0f, 0.01f, -1.0f, 5.0f, NAN};
  soak_terms terms;
  float out[6];
  uint32_t flags, i, k, n;
  if (soak_load_terms(&terms, cal) < 0 && terms.count != 0U) return "refused effects are not taken";
  for (n = 0; n < 2U; ++n) {
    for (k = 0; k < 5U; ++k) {
      const soak_status status = soak_apply_moving(cal, &terms, 20.0f, rates[k], samples[n], out, &flags);
      if (k > 2U && status != SOAK_INVALID) return "a rate that cannot be is told";
      for (i = 0; i < 6U; ++i) {
        const int uncorrected = (flags & (SOAK_FLAG_ABSENT(i) | SOAK_FLAG_INVALID(i))) != 0U;
        if (uncorrected && !same_bits(out[i], samples[n][i])) return "a sensor without correction passes unchanged";
        if (!uncorrected && !soak_is_finite(out[i])) return "a sensor with correction is finite";
      }
    }
  }
  return NULL;
}

static const char* check_history(const soak_cal* cal) {
  static const float sample[6] = {0.1f, -0.2f, 0.3f, 1.0f, -2.0f, 9.8f};
  static const float path_c[] = {20.0f, NAN, 900.0f, -273.0f, 1e9f, 19.0f, 19.1f, 60.0f};
  soak_history history;
  float out[6], bound;
  uint32_t flags, i, k;
  if (soak_load_history(&history, cal) < 0 && history.count != 0U) return "refused terms are not taken";
  for (k = 0; k < sizeof path_c / sizeof path_c[0]; ++k) {
    const soak_status stepped = soak_history_step(&history, path_c[k]);
    const soak_status status = soak_apply_history(cal, NULL, &history, path_c[k], 0.0f, sample, out, &flags);
    if (status < SOAK_OK) return "soak_apply_history refuses no loaded file";
    if ((stepped == SOAK_INVALID) != !(path_c[k] >= -273.15f && path_c[k] <= 1000.0f))
      return "what is no temperature is told";
    for (i = 0; i < 6U; ++i) {
      const int uncorrected = (flags & (SOAK_FLAG_ABSENT(i) | SOAK_FLAG_INVALID(i))) != 0U;
      if (!(soak_magnitude(history.state.memory[i]) <= 1.0f)) return "a memory lies from -1 to 1";
      if (!(history.state.unknown[i] >= 0.0f && history.state.unknown[i] <= 1.0f)) return "what is unknown is a share";
      if (uncorrected && !same_bits(out[i], sample[i])) return "a sensor without correction passes unchanged";
      if (!uncorrected && !soak_is_finite(out[i])) return "a sensor with correction is finite";
      if (soak_history_unknown(&history, (int)i, 20.0f, &bound) == SOAK_OK && bound < 0.0f)
        return "a bound is not negative";
    }
  }
  return NULL;
}

static const char* check_everything(const soak_cal* cal) {
  static const float fixed[] = {-300.0f, -29.9f, 0.0f, 20.0f, 1e-40f, 1e9f, -FLT_MAX, NAN, INFINITY};
  const char* broken = check_couplings(cal);
  uint32_t i, k;
  if (broken == NULL) broken = check_identity(cal);
  if (broken == NULL && cal->provenance != NULL) broken = check_moving(cal);
  if (broken == NULL && cal->provenance != NULL) broken = check_history(cal);
  for (i = 0; i < sizeof fixed / sizeof fixed[0] && broken == NULL; ++i) broken = check_temperature(cal, fixed[i]);
  for (i = 0; i < 6U; ++i) {
    const float low = cal->sensor[i].temp_min_c, high = cal->sensor[i].temp_max_c;
    if (i > 0U && low == cal->sensor[i - 1U].temp_min_c && high == cal->sensor[i - 1U].temp_max_c) continue;
    for (k = 0; k <= 4U && broken == NULL; ++k) broken = check_temperature(cal, low + (high - low) * 0.25f * (float)k);
  }
  return broken;
}

int runtime_exercise(const uint8_t* file, size_t size, const char** broken) {
  soak_cal cal;
  const soak_status status = soak_load(&cal, file, size);
  *broken = check_everything(&cal);
  if (*broken == NULL && status != SOAK_OK) {
    uint32_t i;
    for (i = 0; i < 6U; ++i) {
      if (cal.sensor[i].present) *broken = "a refused file leaves every sensor absent";
    }
  }
  if (*broken == NULL && cal.error_offset > size) *broken = "the place of an error lies in the file";
  return status;
}
