/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Accepted effects of a Soak calibration file (docs/gap-terms.md) that a unit can correct from its temperature and the
 * rate at which it changes: temperature_rate, sensor_lag, cross_axis. Beside soak_runtime.h, and as that: C99 or C++,
 * freestanding, no allocation, float32. (g_sensitivity is a section of its own that soak_apply corrects already;
 * thermal_hysteresis needs a state: soak_history.h. Effects that the file marks as lab only are passed over.)
 *
 *     static soak_terms terms;                       once, after soak_load
 *     if (soak_load_terms(&terms, &cal) < 0) { ... }
 *
 *     soak_apply_moving(&cal, &terms, temp_c, temp_rate_kps, raw, out, &flags);
 *
 * temp_rate_kps: slope of the unit's thermometer in K/s, best over some four minutes, as the laboratory took it. At a
 * steady temperature the result is that of soak_apply but for cross_axis.
 */
#ifndef SOAK_TERMS_H_
#define SOAK_TERMS_H_

#include "soak_runtime.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The members are the runtime's own. */
typedef struct soak_terms {
  float per_kps[SOAK_SENSORS];       /* reading per K/s, at rate_reference_c */
  float per_kps_per_c[SOAK_SENSORS]; /* its slope against temperature */
  float rate_reference_c[SOAK_SENSORS];
  float lag_s[SOAK_SENSORS]; /* the element is where the thermometer was so long ago */
  float cross_per_c[3][3];   /* accelerometer i per specific force j and kelvin; the diagonal is 0 */
  float cross_reference_c[3];
  uint32_t count; /* effects that were taken */
} soak_terms;

/* ---- private ---- */

/* Whether text of the file equals a name. */
static inline int soak_same_name(const uint8_t* text, uint32_t length, const char* name) {
  uint32_t i;
  for (i = 0; i < length; ++i) {
    if (name[i] == '\0' || (uint8_t)name[i] != text[i]) return 0;
  }
  return name[length] == '\0';
}

/* A section 0x0022 whose lengths were checked. */
typedef struct soak_term_view {
  const uint8_t* payload;
  const uint8_t* names; /* of the parameters: length, text */
  uint32_t parameters;
} soak_term_view;

/* Returns 1 where the lengths inside the payload fit. */
static inline int soak_view_term(const uint8_t* p, uint32_t length, soak_term_view* view) {
  uint32_t at, i;
  if (length < 4U || p[2] == 0U) return 0;
  view->payload = p;
  view->parameters = p[3];
  at = 4U + 4U * view->parameters + p[2];
  if (at > length) return 0;
  view->names = p + at;
  for (i = 0; i < view->parameters; ++i) {
    if (at >= length || at + 1U + p[at] > length) return 0;
    at += 1U + p[at];
  }
  return soak_all_finite(p + 4, view->parameters);
}

static inline int soak_is_term(const soak_term_view* view, const char* name) {
  return soak_same_name(view->payload + 4U + 4U * view->parameters, view->payload[2], name);
}

/* Value of a parameter; 0 where the term has none of that name. */
static inline float soak_term_value(const soak_term_view* view, const char* name) {
  const uint8_t* text = view->names;
  uint32_t i;
  for (i = 0; i < view->parameters; ++i) {
    if (soak_same_name(text + 1, text[0], name)) return soak_f32(view->payload + 4U + 4U * i);
    text += 1U + text[0];
  }
  return 0.0f;
}

static inline void soak_take_cross_axis(soak_terms* terms, const soak_term_view* view, uint32_t axis) {
  terms->cross_per_c[axis][0] = soak_term_value(view, "x");
  terms->cross_per_c[axis][1] = soak_term_value(view, "y");
  terms->cross_per_c[axis][2] = soak_term_value(view, "z");
  terms->cross_per_c[axis][axis] = 0.0f;
  terms->cross_reference_c[axis] = soak_term_value(view, "reference_c");
}

/* Takes a term in for the sensors that it acts on; one that needs something else is passed over. */
static inline void soak_take_term(soak_terms* terms, const soak_term_view* view) {
  const int rate = soak_is_term(view, "temperature_rate");
  const int lag = soak_is_term(view, "sensor_lag");
  const int cross = soak_is_term(view, "cross_axis");
  uint32_t i;
  if ((view->payload[0] & 1U) != 0U || (!rate && !lag && !cross)) return;
  for (i = 0; i < SOAK_SENSORS; ++i) {
    if ((view->payload[1] >> i & 1U) == 0U) continue;
    if (rate) {
      terms->per_kps[i] = soak_term_value(view, "per_kps");
      terms->per_kps_per_c[i] = soak_term_value(view, "per_kps_per_c");
      terms->rate_reference_c[i] = soak_term_value(view, "reference_c");
    }
    if (lag) terms->lag_s[i] = soak_term_value(view, "factor") * soak_term_value(view, "tau_s");
    if (cross && i >= SOAK_ACCEL_X) soak_take_cross_axis(terms, view, i - SOAK_ACCEL_X);
  }
  ++terms->count;
}

/* ---- use ---- */

/* Reads the effects of a file that soak_load has taken. SOAK_ABSENT: it has none that this header evaluates, and
 * soak_apply_moving does what soak_apply does. SOAK_E_FORMAT: an effect breaks the format; nothing is taken. */
SOAK_NODISCARD static inline soak_status soak_load_terms(soak_terms* terms, const soak_cal* cal) {
  const soak_terms none = {{0.0f}, {0.0f}, {0.0f}, {0.0f}, {{0.0f}}, {0.0f}, 0U};
  const uint8_t* file;
  uint32_t at;
  if (terms == NULL || cal == NULL || cal->provenance == NULL) return SOAK_E_ARGUMENT;
  *terms = none;
  file = cal->provenance - 8U - cal->sections[0]; /* provenance is the first section */
  for (at = cal->sections[0]; at < cal->sections[1]; at += 8U + soak_u32(file + at + 4U)) {
    soak_term_view view;
    if (soak_u16(file + at) != SOAK_SECTION_TERM || file[at + 2U] != 1U) continue;
    if (!soak_view_term(file + at + 8U, soak_u32(file + at + 4U), &view)) {
      *terms = none;
      return SOAK_E_FORMAT;
    }
    soak_take_term(terms, &view);
  }
  return terms->count != 0U ? SOAK_OK : SOAK_ABSENT;
}

/* Corrects one sample as soak_apply does, and for the effects: curves are read at the temperature of the sensing
 * elements, temp_c - lag * temp_rate_kps; what the rate adds is taken off; accelerometers lose what the temperature
 * adds to their misalignment. Beyond a sensor's valid range the effects are those of its nearer end. A temp_rate_kps
 * that is not finite, or steeper than 1 K/s, counts as 0, and SOAK_INVALID is returned. The sensors of a file share one
 * lag; where they do not, that of the first one that has any is used for all. Otherwise as soak_apply. */
SOAK_NODISCARD static inline soak_status soak_apply_moving(const soak_cal* cal, const soak_terms* terms, float temp_c,
                                                           float temp_rate_kps, const float raw[6], float out[6],
                                                           uint32_t* flags) {
  const int good = soak_is_finite(temp_rate_kps) && soak_magnitude(temp_rate_kps) <= 1.0f;
  const float rate = good ? temp_rate_kps : 0.0f;
  float given[6], reading[6], at_c[6], element_c = temp_c;
  soak_status status;
  uint32_t i, j;
  if (cal == NULL || terms == NULL || raw == NULL || out == NULL || flags == NULL) return SOAK_E_ARGUMENT;
  for (i = SOAK_SENSORS; i-- > 0U;) {
    if (terms->lag_s[i] != 0.0f) element_c = temp_c - terms->lag_s[i] * rate;
  }
  for (i = 0; i < 6U; ++i) {
    given[i] = raw[i];
    at_c[i] = soak_clamp(temp_c, cal->sensor[i].temp_min_c, cal->sensor[i].temp_max_c);
    reading[i] = raw[i] - (terms->per_kps[i] + terms->per_kps_per_c[i] * (at_c[i] - terms->rate_reference_c[i])) * rate;
  }
  /* The force that the misalignment acts on is known well enough from a first pass: what is left is its square. */
  if (soak_apply(cal, element_c, reading, out, flags) < 0) return SOAK_E_ARGUMENT;
  for (i = 0; i < 3U; ++i) {
    float cross = 0.0f;
    for (j = 0; j < 3U; ++j) cross += terms->cross_per_c[i][j] * out[3U + j];
    reading[3U + i] -= cross * (at_c[3U + i] - terms->cross_reference_c[i]);
  }
  status = soak_apply(cal, element_c, reading, out, flags);
  for (i = 0; i < 6U; ++i) {
    if ((*flags & (SOAK_FLAG_ABSENT(i) | SOAK_FLAG_INVALID(i))) != 0U) out[i] = given[i];
  }
  return good ? status : SOAK_INVALID;
}

#ifdef __cplusplus
}
#endif

#endif /* SOAK_TERMS_H_ */
