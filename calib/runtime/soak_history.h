/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The thermal history of a unit on the device: thermal_hysteresis of a Soak calibration file (docs/gap-terms.md), as a
 * state that the unit's thermometer drives. Beside soak_runtime.h and soak_terms.h, and as these: C99 or C++,
 * freestanding, no allocation, float32.
 *
 *     static soak_history history;                                       once, after soak_load
 *     if (soak_load_history(&history, &cal) < 0) { ... }
 *
 *     soak_history_step(&history, temp_c);                               with each reading of the thermometer
 *     soak_apply_history(&cal, &terms, &history, temp_c, temp_rate_kps, raw, out, &flags);          for each sample
 *
 * The memory h of a sensor, from -1 (cooling) to 1 (heating), tends to the sign of the way with each kelvin:
 * dh = (±1 - h)(1 - e^(-|dT| / width_c)). Turns of less than 0.5 K do not count. No clock is needed, only ways: a pause
 * between two readings counts as one way from the one temperature to the other.
 *
 * Start: soak_load_history begins with h = 0, which may be wrong by 1. Whatever came before is forgotten over the way:
 * each width_c of it, up or down, leaves 1/e, three leave 5 %. soak_history_unknown says how much of the correction is
 * not known yet. Who knows more tells it: soak_history_start, or soak_history_resume with what was kept from before.
 * What the unit went through between two readings is in neither: after a pause with turns in it, begin anew.
 */
#ifndef SOAK_HISTORY_H_
#define SOAK_HISTORY_H_

#include "soak_terms.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What the unit went through: all that changes. To keep it over a power cycle, copy it out and resume with it. */
typedef struct soak_memory {
  float followed_c; /* end of a rod that follows the thermometer with a play of 0.25 K to either side */
  float memory[SOAK_SENSORS];
  float unknown[SOAK_SENSORS]; /* how far memory may be off for want of a past, 0 to 1 */
  uint32_t begun;              /* not 0: followed_c is a temperature */
} soak_memory;

/* The members but `state` are the runtime's own. */
typedef struct soak_history {
  float width_c[SOAK_SENSORS]; /* 0: no such effect in this sensor */
  float amplitude[SOAK_SENSORS];
  float amplitude_per_c[SOAK_SENSORS];
  float reference_c[SOAK_SENSORS];
  const uint8_t* mean[SOAK_SENSORS]; /* in the file: pairs of a temperature and what the bias curve holds there */
  uint32_t means[SOAK_SENSORS];      /* pairs */
  uint32_t count;                    /* terms that were taken */
  soak_memory state;
} soak_history;

/* Files of this minor version say what their curves hold of a memory; those before it need not, and are not followed.
 */
#define SOAK_HISTORY_MINOR_VERSION 7U

/* ---- private ---- */

#define SOAK_PLAY_C 0.25f /* turns of twice that do not count */
/* The rod moves in steps of at least so much: shorter ones would be lost in the rounding of the memory. */
#define SOAK_LEAST_WAY_C 0.001953125f

/* Whether a name of the format (its length, then its letters) is mean_K_c, or mean_K without `of_temp`. */
static inline int soak_is_mean(const uint8_t* text, uint32_t number, int of_temp) {
  char name[11] = "mean_";
  uint32_t end = 5U;
  if (number >= 100U) name[end++] = (char)('0' + number / 100U);
  if (number >= 10U) name[end++] = (char)('0' + number / 10U % 10U);
  name[end++] = (char)('0' + number % 10U);
  if (of_temp) {
    name[end++] = '_';
    name[end++] = 'c';
  }
  name[end] = '\0';
  return soak_same_name(text + 1, text[0], name);
}

/* The pairs mean_1_c, mean_1, mean_2_c ... end the list of parameters. Returns their number; -1 where they break the
 * format. */
static inline int32_t soak_find_means(const soak_term_view* view, const uint8_t** pairs) {
  const uint8_t* text = view->names;
  uint32_t i, k, count;
  for (i = 0; i < view->parameters && !soak_is_mean(text, 1U, 1); ++i) text += 1U + text[0];
  *pairs = view->payload + 4U + 4U * i;
  if ((view->parameters - i) % 2U != 0U) return -1;
  count = (view->parameters - i) / 2U;
  for (k = 0; k < 2U * count; ++k, text += 1U + text[0]) {
    if (!soak_is_mean(text, k / 2U + 1U, k % 2U == 0U)) return -1;
  }
  for (k = 1; k < count; ++k) {
    if (!(soak_f32(*pairs + 8U * k) > soak_f32(*pairs + 8U * k - 8U))) return -1;
  }
  return (int32_t)count;
}

/* Takes a term in for the sensors that it acts on; returns 0 where it breaks the format. */
static inline int soak_take_history(soak_history* history, const soak_term_view* view) {
  const float width_c = soak_term_value(view, "width_c");
  const uint8_t* pairs = NULL;
  const int32_t means = soak_find_means(view, &pairs);
  uint32_t i;
  if (!(width_c > 0.0f) || means < 0) return 0;
  for (i = 0; i < SOAK_SENSORS; ++i) {
    if ((view->payload[1] >> i & 1U) == 0U) continue;
    history->width_c[i] = width_c;
    history->amplitude[i] = soak_term_value(view, "amplitude");
    history->amplitude_per_c[i] = soak_term_value(view, "amplitude_per_c");
    history->reference_c[i] = soak_term_value(view, "reference_c");
    history->mean[i] = pairs;
    history->means[i] = (uint32_t)means;
  }
  ++history->count;
  return 1;
}

/* Linear between the pairs, held beyond them; 0 without any. `at`: the interval that is looked at first, and where the
 * temperature was found: sensors often have their pairs at the same temperatures. */
static inline float soak_mean_at(const uint8_t* pairs, uint32_t count, float temp_c, uint32_t* at) {
  const uint8_t* here;
  uint32_t intervals;
  float left_c, low;
  if (count == 0U) return 0.0f;
  if (count == 1U || temp_c <= soak_f32(pairs)) return soak_f32(pairs + 4);
  if (!(temp_c <= soak_f32(pairs + 8U * count - 8U))) return soak_f32(pairs + 8U * count - 4U);
  here = pairs + 8U * (*at < count - 1U ? *at : 0U);
  if (!(temp_c > soak_f32(here) && temp_c <= soak_f32(here + 8))) {
    here = pairs;
    for (intervals = count - 1U; intervals > 1U;) {
      const uint32_t half = intervals / 2U;
      here += 8U * half * (uint32_t)(temp_c > soak_f32(here + 8U * half)); /* no jump to guess wrong */
      intervals -= half;
    }
  }
  *at = (uint32_t)(here - pairs) / 8U;
  left_c = soak_f32(here);
  low = soak_f32(here + 4);
  return low + (soak_f32(here + 12) - low) * ((temp_c - left_c) / (soak_f32(here + 8) - left_c));
}

static inline float soak_amplitude_at(const soak_history* history, uint32_t sensor, float temp_c) {
  return history->amplitude[sensor] + history->amplitude_per_c[sensor] * (temp_c - history->reference_c[sensor]);
}

static inline int soak_is_memory(float value) { return soak_is_finite(value) && soak_magnitude(value) <= 1.0f; }

/* ---- use ---- */

/* Begins anew: the unit came to its present temperature by heating (1), by cooling (-1), or nobody knows (0, and
 * whatever is not from -1 to 1). A unit that was at rest for long came from where it was before: switched on in the
 * cold after a stay at room temperature, by cooling. */
static inline void soak_history_start(soak_history* history, float memory) {
  const int known = soak_is_memory(memory) && memory != 0.0f;
  uint32_t i;
  if (history == NULL) return;
  history->state.followed_c = 0.0f;
  history->state.begun = 0U;
  for (i = 0; i < SOAK_SENSORS; ++i) {
    history->state.memory[i] = known ? memory : 0.0f;
    history->state.unknown[i] = known ? 0.0f : 1.0f;
  }
}

static inline void soak_clear_history(soak_history* history) {
  uint8_t* bytes = (uint8_t*)history;
  size_t k;
  for (k = 0; k < sizeof *history; ++k) bytes[k] = 0U;
  soak_history_start(history, 0.0f);
}

/* Reads the effect from a file that soak_load has taken, and begins with nothing known of the past. SOAK_ABSENT: the
 * file has no thermal history that a device can follow (none before format 1.7 has), and soak_apply_history does what
 * soak_apply_moving does.
 * SOAK_E_FORMAT: a term breaks the format; nothing is taken. */
SOAK_NODISCARD static inline soak_status soak_load_history(soak_history* history, const soak_cal* cal) {
  const uint8_t* file;
  uint32_t at;
  if (history == NULL) return SOAK_E_ARGUMENT;
  soak_clear_history(history);
  if (cal == NULL || cal->provenance == NULL) return SOAK_E_ARGUMENT;
  file = cal->provenance - 8U - cal->sections[0]; /* provenance is the first section */
  if (soak_u16(file + 10U) < SOAK_HISTORY_MINOR_VERSION) return SOAK_ABSENT;
  for (at = cal->sections[0]; at < cal->sections[1]; at += 8U + soak_u32(file + at + 4U)) {
    soak_term_view view;
    int good;
    if (soak_u16(file + at) != SOAK_SECTION_TERM || file[at + 2U] != 1U) continue;
    good = soak_view_term(file + at + 8U, soak_u32(file + at + 4U), &view);
    if (good && ((view.payload[0] & 1U) != 0U || !soak_is_term(&view, "thermal_hysteresis"))) continue;
    if (good) good = soak_take_history(history, &view);
    if (!good) {
      soak_clear_history(history);
      return SOAK_E_FORMAT;
    }
  }
  return history->count != 0U ? SOAK_OK : SOAK_ABSENT;
}

/* Goes on from what was kept of `state` before a power cycle; the way since counts as one. SOAK_INVALID: it is no
 * memory, and the past counts as unknown. The widths must be those that it was made with: keep the file's identity
 * beside it. */
SOAK_NODISCARD static inline soak_status soak_history_resume(soak_history* history, const soak_memory* kept) {
  int good;
  uint32_t i;
  if (history == NULL || kept == NULL) return SOAK_E_ARGUMENT;
  good =
      soak_is_finite(kept->followed_c) && kept->followed_c >= SOAK_TEMP_LOWEST && kept->followed_c <= SOAK_TEMP_HIGHEST;
  for (i = 0; i < SOAK_SENSORS; ++i) {
    good = good && soak_is_memory(kept->memory[i]) && soak_is_memory(kept->unknown[i]) && kept->unknown[i] >= 0.0f;
  }
  if (good) {
    history->state = *kept;
    return SOAK_OK;
  }
  soak_history_start(history, 0.0f);
  return SOAK_INVALID;
}

/* Takes in a reading of the unit's thermometer, °C: every one, or one every few seconds; of a noisy thermometer a mean
 * whose noise stays within 0.25 K, as what goes beyond counts as ways. SOAK_INVALID: it is not finite or no temperature
 * (below -273.15, above 1000 °C), and nothing changes. */
static inline soak_status soak_history_step(soak_history* history, float temp_c) {
  float away_c, way_c, sign, left = 1.0f;
  uint32_t i;
  if (history == NULL) return SOAK_E_ARGUMENT;
  if (!soak_is_finite(temp_c) || temp_c < SOAK_TEMP_LOWEST || temp_c > SOAK_TEMP_HIGHEST) return SOAK_INVALID;
  if (history->state.begun == 0U) {
    history->state.followed_c = temp_c;
    history->state.begun = 1U;
    return SOAK_OK;
  }
  away_c = temp_c - history->state.followed_c;
  way_c = soak_magnitude(away_c) - SOAK_PLAY_C;
  if (way_c < SOAK_LEAST_WAY_C) return SOAK_OK;
  sign = away_c > 0.0f ? 1.0f : -1.0f;
  history->state.followed_c = temp_c - sign * SOAK_PLAY_C;
  for (i = 0; i < SOAK_SENSORS; ++i) {
    const float width_c = history->width_c[i];
    if (!(width_c > 0.0f)) continue;
    /* e^(-way/width); sensors often share one width */
    if (i == 0U || width_c != history->width_c[i - 1U]) left = soak_exp2(-1.44269504f * (way_c / width_c));
    history->state.memory[i] = sign - (sign - history->state.memory[i]) * left;
    history->state.unknown[i] *= left;
  }
  return SOAK_OK;
}

/* How far the correction of a sensor may be off at temp_c (within the sensor's range) because what came before the
 * first reading is not known, rad/s or m/s²; 0 where the file has no such effect for it, or the past was told. But for
 * the play of the rod, whose end may be off by 0.25 K until the temperature has moved by 0.5 K one way, and for turns
 * that no reading showed. */
SOAK_NODISCARD static inline soak_status soak_history_unknown(const soak_history* history, int sensor, float temp_c,
                                                              float* bound) {
  if (history == NULL || bound == NULL || sensor < 0 || sensor >= SOAK_SENSORS) return SOAK_E_ARGUMENT;
  *bound = soak_nan();
  if (!soak_is_finite(temp_c)) return SOAK_INVALID;
  *bound = history->width_c[sensor] > 0.0f
               ? soak_magnitude(soak_amplitude_at(history, (uint32_t)sensor, temp_c)) * history->state.unknown[sensor]
               : 0.0f;
  return SOAK_OK;
}

/* Corrects one sample as soak_apply_moving does, and for the history: each sensor loses amplitude * h less the mean
 * that its bias curve already holds. Beyond a sensor's valid range that of its nearer end. `terms` may be null: then,
 * and where the file has none of them, as soak_apply, and temp_rate_kps is not looked at. Does not step: any number of
 * threads may apply one history while none steps it. */
SOAK_NODISCARD static inline soak_status soak_apply_history(const soak_cal* cal, const soak_terms* terms,
                                                            const soak_history* history, float temp_c,
                                                            float temp_rate_kps, const float raw[6], float out[6],
                                                            uint32_t* flags) {
  float given[6], reading[6];
  soak_status status;
  uint32_t i, at = 0U;
  if (cal == NULL || history == NULL || raw == NULL || out == NULL || flags == NULL) return SOAK_E_ARGUMENT;
  for (i = 0; i < 6U; ++i) {
    given[i] = reading[i] = raw[i];
    if (!(history->width_c[i] > 0.0f) || !soak_is_finite(temp_c)) continue;
    {
      const float at_c = soak_clamp(temp_c, cal->sensor[i].temp_min_c, cal->sensor[i].temp_max_c);
      reading[i] -= soak_amplitude_at(history, i, at_c) * history->state.memory[i] -
                    soak_mean_at(history->mean[i], history->means[i], at_c, &at);
    }
  }
  status = terms != NULL && terms->count != 0U
               ? soak_apply_moving(cal, terms, temp_c, temp_rate_kps, reading, out, flags)
               : soak_apply(cal, temp_c, reading, out, flags);
  for (i = 0; i < 6U && status >= SOAK_OK; ++i) {
    if ((*flags & (SOAK_FLAG_ABSENT(i) | SOAK_FLAG_INVALID(i))) != 0U) out[i] = given[i];
  }
  return status;
}

#ifdef __cplusplus
}
#endif

#endif /* SOAK_HISTORY_H_ */
