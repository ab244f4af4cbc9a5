/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reader of Soak calibration files (docs/blob-format.md, version 1) for microcontrollers.
 *
 * One header, C99 or C++, freestanding: it needs no C library and no mathematical function (a compiler may put in calls
 * of memcpy and memset of its own). No allocation, no input or output, no variable outside the caller's soak_cal, which
 * only soak_load writes: any number of threads may evaluate one calibration. float32 only; where a * b + c is not
 * contracted (gcc, clang: -ffp-contract=off) every machine gets the same bits. The file stays where it is, for instance
 * in flash, at any address, and must stay there unchanged as long as the soak_cal that was loaded from it is used.
 * Temperatures in °C of the unit's own thermometer, rates in rad/s, accelerations in m/s².
 *
 *     static soak_cal cal;
 *     if (soak_load(&cal, file, file_size) != SOAK_OK) { ... no calibration: fly uncorrected, and say so ... }
 *
 *     float out[6];
 *     uint32_t flags;
 *     if (soak_apply(&cal, temp_c, raw, out, &flags) != SOAK_OK) { ... flags say which sensor and why ... }
 *
 * Where a sensor was calibrated over a thermometer of its own (soak_has_own_thermometer) that sensor's temperature is
 * wanted, not the unit's: soak_apply_temps takes the six.
 */
#ifndef SOAK_RUNTIME_H_
#define SOAK_RUNTIME_H_

#include <float.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__) || defined(__clang__)
#define SOAK_NODISCARD __attribute__((warn_unused_result))
#else
#define SOAK_NODISCARD
#endif

/* Sensors, and the order of raw[6] and out[6]. */
enum { SOAK_GYRO_X, SOAK_GYRO_Y, SOAK_GYRO_Z, SOAK_ACCEL_X, SOAK_ACCEL_Y, SOAK_ACCEL_Z, SOAK_SENSORS };

/* Couplings between the sensors, for soak_coupling_sigma. */
enum { SOAK_MISALIGNMENT, SOAK_G_SENSITIVITY, SOAK_GYRO_MISALIGNMENT };

/* What the functions return. Above 0: the output is defined, but not what a full calibration gives; the worst of
 * several is returned. Below 0: the file or the arguments are refused; outputs are not written. */
typedef enum soak_status {
  SOAK_OK = 0,
  SOAK_CLAMPED = 1, /* nothing was measured at the temperature: the value is that of the nearest one that was */
  SOAK_ABSENT = 2,  /* the file has no such sensor or curve */
  SOAK_INVALID = 3, /* an input is not finite, or the correction is not usable */

  SOAK_E_ARGUMENT = -1, /* null pointer, or no such sensor */
  SOAK_E_MAGIC = -2,    /* not a Soak calibration file */
  SOAK_E_CHECK = -3,    /* truncated or damaged: size or CRC do not fit */
  SOAK_E_VERSION = -4,  /* a newer major version */
  SOAK_E_UNKNOWN = -5,  /* a critical section that this reader does not know */
  SOAK_E_FORMAT = -6    /* the check sum is right, the content breaks the format: soak_cal.error_offset says where */
} soak_status;

/* Flags of soak_apply, for sensor i of 0..5. */
#define SOAK_FLAG_CLAMPED(i) ((uint32_t)1U << (i))       /* temperature out of range, corrected as at the range's end */
#define SOAK_FLAG_ABSENT(i) ((uint32_t)1U << (8U + (i))) /* not in the file: out = raw */
#define SOAK_FLAG_INVALID(i) ((uint32_t)1U << (16U + (i))) /* not finite or not usable: out = raw */
/* An accelerometer or a gyro is invalid: misalignments and g-sensitivity leave it out, so the other sensors are less
 * exact. */
#define SOAK_FLAG_UNCOUPLED ((uint32_t)1U << 24)
/* Of soak_apply alone: sensors of the file have thermometers of their own, of which one temperature says nothing. They
 * are invalid, and raw: use soak_apply_temps. */
#define SOAK_FLAG_THERMOMETER ((uint32_t)1U << 25)
/* In the valid range, but the scale factor was not measured at this temperature: corrected with that of the nearest. */
#define SOAK_FLAG_SCALE(i) ((uint32_t)1U << (26U + (i)))

/* The members are the runtime's own. */
typedef struct soak_curve {
  const uint8_t* payload; /* null: no such curve */
  uint32_t kind;          /* section type, or SOAK_KIND_WHOLE_BELLS */
} soak_curve;

typedef struct soak_sensor {
  uint32_t present;
  float temp_min_c, temp_max_c;
  soak_curve curve[2];           /* bias, scale_ppm */
  const uint8_t* uncertainty[2]; /* payload of the uncertainty table, or null */
  const uint8_t* error_bound[2]; /* payload of the float32 error bound, or null */
  const uint8_t* table_bound[2]; /* payload of the table's bound, or null */
} soak_sensor;

typedef struct soak_cal {
  soak_sensor sensor[SOAK_SENSORS];
  const uint8_t* misalignment;      /* 9 float32, or null */
  const uint8_t* g_sensitivity;     /* 9 float32, or null */
  const uint8_t* gyro_misalignment; /* payload of the gyros' misalignment, or null */
  const uint8_t* couplings;         /* payload of the couplings' uncertainties, or null */
  const uint8_t* thermometers;      /* payload of the thermometers, or null */
  const uint8_t* provenance;        /* payload of the provenance section */
  uint32_t sections[2];             /* first byte of the first section, end of the last */
  uint32_t simulated;               /* not 0: made from simulated data; do not deploy */
  uint32_t unreleased;              /* not 0: the laboratory has not released the model */
  uint32_t error_offset;            /* after SOAK_E_FORMAT, SOAK_E_UNKNOWN: first byte of the section at fault */
} soak_cal;

/* ---- private: reading numbers ---- */

enum {
  SOAK_SECTION_PROVENANCE = 0x0001,
  SOAK_SECTION_SENSOR = 0x0010,
  SOAK_SECTION_FIS = 0x0011,
  SOAK_SECTION_SPLINE = 0x0012,
  SOAK_SECTION_TABLE = 0x0013,
  SOAK_SECTION_UNCERTAINTY = 0x0014,
  SOAK_SECTION_MISALIGNMENT = 0x0020,
  SOAK_SECTION_G_SENSITIVITY = 0x0021,
  SOAK_SECTION_TERM = 0x0022,
  SOAK_SECTION_COUPLINGS = 0x0023,
  SOAK_SECTION_THERMOMETERS = 0x0024,
  SOAK_SECTION_GYRO_MISALIGNMENT = 0x0025,
  SOAK_SECTION_ERROR_BOUND = 0x0030,
  SOAK_SECTION_TABLE_BOUND = 0x0031
};

/* A FIS of bells in each of which z^(2 slope) is multiplied out: found at loading, so that no evaluation asks again. */
enum { SOAK_KIND_WHOLE_BELLS = 0x10000 | SOAK_SECTION_FIS };

enum {
  SOAK_MAX_FILE = 1048576,
  SOAK_MAX_SECTIONS = 256,
  SOAK_MAX_RULES = 64,
  SOAK_MAX_PIECES = 1024,
  SOAK_MAX_POINTS = 4096,
  SOAK_MAX_UNCERTAINTY_POINTS = 1024,
  SOAK_MAX_RUNS = 4096,
  SOAK_MAX_TERMS = 32
};

#define SOAK_MAX_CENTRE 10000.0f
#define SOAK_MAX_MISALIGNMENT 0.2f
#define SOAK_MAX_WHOLE_SLOPE 16.0f /* up to here z^(2 slope) is multiplied out where 2 slope is a whole number */
#define SOAK_TEMP_LOWEST (-273.15f)
#define SOAK_TEMP_HIGHEST 1000.0f

static inline uint32_t soak_u16(const uint8_t* p) { return (uint32_t)p[0] | ((uint32_t)p[1] << 8); }

static inline uint32_t soak_u32(const uint8_t* p) { return soak_u16(p) | (soak_u16(p + 2) << 16); }

/* A float32 and its bits. */
typedef union soak_word {
  uint32_t bits;
  float value;
} soak_word;

static inline float soak_float_of(uint32_t bits) {
  soak_word word;
  word.bits = bits;
  return word.value;
}

static inline uint32_t soak_bits_of(float value) {
  soak_word word;
  word.value = value;
  return word.bits;
}

static inline float soak_f32(const uint8_t* p) { return soak_float_of(soak_u32(p)); }

/* By its bits: comparisons with NaN do not survive -ffast-math. */
static inline int soak_is_finite(float value) { return (soak_bits_of(value) & 0x7F800000U) != 0x7F800000U; }

static inline float soak_nan(void) { return soak_float_of(0x7FC00000U); }

static inline float soak_magnitude(float value) { return soak_float_of(soak_bits_of(value) & 0x7FFFFFFFU); }

static inline uint32_t soak_crc32c(const uint8_t* data, size_t size) {
  /* CRC of the 16 values of four bits */
  static const uint32_t table[16] = {0x00000000U, 0x105EC76FU, 0x20BD8EDEU, 0x30E349B1U, 0x417B1DBCU, 0x5125DAD3U,
                                     0x61C69362U, 0x7198540DU, 0x82F63B78U, 0x92A8FC17U, 0xA24BB5A6U, 0xB21572C9U,
                                     0xC38D26C4U, 0xD3D3E1ABU, 0xE330A81AU, 0xF36E6F75U};
  uint32_t crc = 0xFFFFFFFFU;
  size_t i;
  for (i = 0; i < size; ++i) {
    crc ^= data[i];
    crc = (crc >> 4) ^ table[crc & 15U];
    crc = (crc >> 4) ^ table[crc & 15U];
  }
  return ~crc;
}

/* ---- private: checking a section's payload; each returns 1 if it keeps the format ---- */

static inline int soak_all_finite(const uint8_t* p, uint32_t count) {
  uint32_t i;
  for (i = 0; i < count; ++i) {
    if (!soak_is_finite(soak_f32(p + 4U * i))) return 0;
  }
  return 1;
}

static inline int soak_all_between(const uint8_t* p, uint32_t count, float low, float high) {
  uint32_t i;
  if (!soak_all_finite(p, count)) return 0;
  for (i = 0; i < count; ++i) {
    const float value = soak_f32(p + 4U * i);
    if (value < low || value > high) return 0;
  }
  return 1;
}

static inline int soak_rising_temperatures(const uint8_t* p, uint32_t count) {
  uint32_t i;
  if (!soak_all_between(p, count, SOAK_TEMP_LOWEST, SOAK_TEMP_HIGHEST)) return 0;
  for (i = 1; i < count; ++i) {
    if (!(soak_f32(p + 4U * i) > soak_f32(p + 4U * i - 4U))) return 0;
  }
  return 1;
}

/* Whether `used` bytes and padding to a multiple of 4 are the whole length. */
static inline int soak_fits(uint32_t length, uint32_t used) { return length == ((used + 3U) & ~(uint32_t)3U); }

static inline int soak_check_provenance(const uint8_t* p, uint32_t length) {
  uint32_t runs;
  if (length < 32U) return 0;
  runs = soak_u16(p + 28);
  /* exponent all ones: infinity or NaN */
  if ((soak_u16(p + 14) & 0x7FF0U) == 0x7FF0U || (soak_u16(p + 22) & 0x7FF0U) == 0x7FF0U) return 0;
  return runs <= SOAK_MAX_RUNS && p[30] != 0U && soak_fits(length, 32U + 32U * runs + p[30] + p[31]);
}

static inline int soak_check_sensor(const uint8_t* p, uint32_t length) {
  return length >= 12U && soak_all_between(p + 4, 2U, SOAK_TEMP_LOWEST, SOAK_TEMP_HIGHEST) &&
         soak_f32(p + 4) <= soak_f32(p + 8) && soak_fits(length, 12U + p[1]);
}

static inline int soak_check_rule(const uint8_t* p, uint32_t membership, uint32_t order) {
  return soak_all_finite(p, 6U) && soak_magnitude(soak_f32(p)) <= SOAK_MAX_CENTRE &&
         soak_magnitude(soak_f32(p + 4)) <= SOAK_MAX_CENTRE && soak_f32(p + 8) > 0.0f &&
         (membership == 1U || soak_f32(p + 12) > 0.0f) && (order == 1U || soak_f32(p + 20) == 0.0f);
}

static inline int soak_check_fis(const uint8_t* p, uint32_t length) {
  uint32_t count, i;
  if (length < 24U || p[2] > 1U || p[3] > 1U) return 0;
  count = soak_u16(p + 4);
  if (count == 0U || count > SOAK_MAX_RULES || length != 24U + 24U * count) return 0;
  if (!soak_all_finite(p + 8, 4U) || !(soak_f32(p + 8) <= soak_f32(p + 12)) || !(soak_f32(p + 20) > 0.0f)) return 0;
  for (i = 0; i < count; ++i) {
    if (!soak_check_rule(p + 24U + 24U * i, p[2], p[3])) return 0;
  }
  return 1;
}

static inline int soak_check_spline(const uint8_t* p, uint32_t length) {
  uint32_t count;
  if (length < 4U) return 0;
  count = soak_u16(p + 2);
  return count != 0U && count <= SOAK_MAX_PIECES && length == 16U + 20U * count && soak_all_finite(p + 4, 2U) &&
         soak_f32(p + 8) > 0.0f && soak_rising_temperatures(p + 12, count + 1U) &&
         soak_all_finite(p + 16U + 4U * count, 4U * count);
}

/* Whether `count` points lie within the temperatures. One rounding on each side of the comparison, and nothing that a
 * fused multiply-add could change: all readers agree. */
static inline int soak_table_fits(float first, float step, uint32_t count) {
  return step > 0.0f && first >= SOAK_TEMP_LOWEST && (float)(count - 1U) * step <= SOAK_TEMP_HIGHEST - first;
}

static inline int soak_check_table(const uint8_t* p, uint32_t length) {
  uint32_t count;
  if (length < 20U) return 0;
  count = soak_u16(p + 2);
  if (count == 0U || count > SOAK_MAX_POINTS || length != 20U + 4U * count) return 0;
  return soak_all_finite(p + 4, 4U + count) && soak_f32(p + 8) > 0.0f &&
         soak_table_fits(soak_f32(p + 12), soak_f32(p + 16), count);
}

static inline int soak_check_uncertainty(const uint8_t* p, uint32_t length) {
  uint32_t count, columns;
  if (length < 8U) return 0;
  count = soak_u16(p + 2);
  columns = (soak_u32(p + 4) & 1U) != 0U ? 3U : 2U;
  return count != 0U && count <= SOAK_MAX_UNCERTAINTY_POINTS && length == 8U + 4U * columns * count &&
         soak_rising_temperatures(p + 8, count) &&
         soak_all_between(p + 8U + 4U * count, (columns - 1U) * count, 0.0f, FLT_MAX);
}

static inline int soak_check_misalignment(const uint8_t* p, uint32_t length) {
  return length == 36U && soak_all_between(p, 9U, -SOAK_MAX_MISALIGNMENT, SOAK_MAX_MISALIGNMENT) &&
         soak_f32(p) == 0.0f && soak_f32(p + 16) == 0.0f && soak_f32(p + 32) == 0.0f;
}

/* Flags of the gyros' misalignment: its uncertainties follow the matrix. */
#define SOAK_GYRO_UNCERTAINTIES 1U

static inline int soak_check_gyro_misalignment(const uint8_t* p, uint32_t length) {
  const uint8_t* u = p + 40;
  if (length < 40U) return 0;
  if ((soak_u32(p) & SOAK_GYRO_UNCERTAINTIES) == 0U) return length == 40U && soak_check_misalignment(p + 4, 36U);
  return length == 76U && soak_check_misalignment(p + 4, 36U) && soak_all_between(u, 9U, 0.0f, FLT_MAX) &&
         soak_f32(u) == 0.0f && soak_f32(u + 16) == 0.0f && soak_f32(u + 32) == 0.0f;
}

/* Blocks of the couplings' uncertainties: the matrices of SOAK_MISALIGNMENT and SOAK_G_SENSITIVITY, then value and
 * uncertainty of the even-order term of each accelerometer. Bit k of the payload's first word: block k is there. */
enum { SOAK_BLOCK_EVEN_ORDER = 2, SOAK_BLOCKS = 5 };

/* Bytes of the payload before this block. */
static inline uint32_t soak_bytes_before(const uint8_t* p, uint32_t block) {
  uint32_t k, bytes = 4U;
  for (k = 0; k < block; ++k) {
    if ((soak_u32(p) >> k & 1U) != 0U) bytes += k < SOAK_BLOCK_EVEN_ORDER ? 36U : 8U;
  }
  return bytes;
}

static inline const uint8_t* soak_coupling_block(const uint8_t* p, uint32_t block) {
  return (soak_u32(p) >> block & 1U) != 0U ? p + soak_bytes_before(p, block) : NULL;
}

static inline int soak_check_couplings(const uint8_t* p, uint32_t length) {
  const uint8_t* block;
  uint32_t k;
  if (length < 4U || length != soak_bytes_before(p, SOAK_BLOCKS)) return 0;
  for (k = 0; k < SOAK_BLOCKS; ++k) {
    block = soak_coupling_block(p, k);
    if (block == NULL) continue;
    if (k < SOAK_BLOCK_EVEN_ORDER && !soak_all_between(block, 9U, 0.0f, FLT_MAX)) return 0;
    if (k >= SOAK_BLOCK_EVEN_ORDER &&
        (!soak_all_finite(block, 1U) || !soak_all_between(block + 4, 1U, 0.0f, FLT_MAX))) {
      return 0;
    }
  }
  block = soak_coupling_block(p, SOAK_MISALIGNMENT);
  return block == NULL || (soak_f32(block) == 0.0f && soak_f32(block + 16) == 0.0f && soak_f32(block + 32) == 0.0f);
}

/* ---- private: taking a section into the calibration; each returns 1 if it keeps the format ---- */

/* The place that a payload of its own kind is noted in: it must still be empty. */
static inline int soak_note(const uint8_t** place, const uint8_t* payload) {
  if (*place != NULL) return 0;
  *place = payload;
  return 1;
}

/* The sensor that a payload starts with, if it is in the file and the quantity exists; else null. */
static inline soak_sensor* soak_owner(soak_cal* cal, const uint8_t* p, uint32_t length) {
  if (length < 4U || p[0] >= SOAK_SENSORS || p[1] > 1U || !cal->sensor[p[0]].present) return NULL;
  return &cal->sensor[p[0]];
}

static inline int soak_take_sensor(soak_cal* cal, const uint8_t* p, uint32_t length) {
  soak_sensor* sensor;
  if (!soak_check_sensor(p, length) || p[0] >= SOAK_SENSORS || cal->sensor[p[0]].present) return 0;
  sensor = &cal->sensor[p[0]];
  sensor->present = 1U;
  sensor->temp_min_c = soak_f32(p + 4);
  sensor->temp_max_c = soak_f32(p + 8);
  return 1;
}

/* Whether 2 slope is a whole number small enough to multiply out; slope > 0. */
static inline int soak_is_whole(float slope) {
  return slope <= SOAK_MAX_WHOLE_SLOPE && (float)(int32_t)(2.0f * slope) == 2.0f * slope;
}

static inline uint32_t soak_kind_of_fis(const uint8_t* p) {
  const uint32_t count = soak_u16(p + 4);
  uint32_t i;
  for (i = 0; i < count; ++i) {
    if (p[2] != 0U || !soak_is_whole(soak_f32(p + 24U + 24U * i + 12U))) return SOAK_SECTION_FIS;
  }
  return SOAK_KIND_WHOLE_BELLS;
}

static inline int soak_take_curve(soak_cal* cal, uint32_t type, const uint8_t* p, uint32_t length) {
  soak_sensor* sensor = soak_owner(cal, p, length);
  if (sensor == NULL) return 0;
  if (type == SOAK_SECTION_FIS && !soak_check_fis(p, length)) return 0;
  if (type == SOAK_SECTION_SPLINE && !soak_check_spline(p, length)) return 0;
  if (type == SOAK_SECTION_TABLE && !soak_check_table(p, length)) return 0;
  sensor->curve[p[1]].kind = type == SOAK_SECTION_FIS ? soak_kind_of_fis(p) : type;
  return soak_note(&sensor->curve[p[1]].payload, p);
}

static inline int soak_take_uncertainty(soak_cal* cal, const uint8_t* p, uint32_t length) {
  soak_sensor* sensor = soak_owner(cal, p, length);
  return sensor != NULL && soak_check_uncertainty(p, length) && soak_note(&sensor->uncertainty[p[1]], p);
}

static inline int soak_take_error_bound(soak_cal* cal, const uint8_t* p, uint32_t length) {
  soak_sensor* sensor = soak_owner(cal, p, length);
  return sensor != NULL && length == 12U && soak_all_between(p + 4, 2U, 0.0f, FLT_MAX) &&
         soak_note(&sensor->error_bound[p[1]], p);
}

/* Comes after the table that it belongs to. */
static inline int soak_take_table_bound(soak_cal* cal, const uint8_t* p, uint32_t length) {
  soak_sensor* sensor = soak_owner(cal, p, length);
  return sensor != NULL && sensor->curve[p[1]].kind == SOAK_SECTION_TABLE && length == 8U &&
         soak_all_between(p + 4, 1U, 0.0f, FLT_MAX) && soak_note(&sensor->table_bound[p[1]], p);
}

/* Comes after the matrices that it speaks of. */
static inline int soak_take_couplings(soak_cal* cal, const uint8_t* p, uint32_t length) {
  if (!soak_check_couplings(p, length)) return 0;
  if (soak_coupling_block(p, SOAK_MISALIGNMENT) != NULL && cal->misalignment == NULL) return 0;
  if (soak_coupling_block(p, SOAK_G_SENSITIVITY) != NULL && cal->g_sensitivity == NULL) return 0;
  return soak_note(&cal->couplings, p);
}

static inline int soak_take_provenance(soak_cal* cal, const uint8_t* p, uint32_t length) {
  if (!soak_check_provenance(p, length)) return 0;
  cal->simulated = soak_u32(p + 24) & 1U;
  cal->unreleased = soak_u32(p + 24) & 4U;
  return soak_note(&cal->provenance, p);
}

/* `head` points to the section's head; the section lies inside the file. */
static inline soak_status soak_take_section(soak_cal* cal, const uint8_t* head) {
  const uint32_t type = soak_u16(head);
  const uint32_t known_version = head[2] == 1U;
  const uint32_t length = soak_u32(head + 4);
  const uint8_t* p = head + 8;
  int good = 0;
  switch (known_version ? type : 0U) {
    case SOAK_SECTION_PROVENANCE:
      good = soak_take_provenance(cal, p, length);
      break;
    case SOAK_SECTION_SENSOR:
      good = soak_take_sensor(cal, p, length);
      break;
    case SOAK_SECTION_FIS:
    case SOAK_SECTION_SPLINE:
    case SOAK_SECTION_TABLE:
      good = soak_take_curve(cal, type, p, length);
      break;
    case SOAK_SECTION_UNCERTAINTY:
      good = soak_take_uncertainty(cal, p, length);
      break;
    case SOAK_SECTION_MISALIGNMENT:
      good = soak_check_misalignment(p, length) && soak_note(&cal->misalignment, p);
      break;
    case SOAK_SECTION_GYRO_MISALIGNMENT:
      good = soak_check_gyro_misalignment(p, length) && soak_note(&cal->gyro_misalignment, p);
      break;
    case SOAK_SECTION_G_SENSITIVITY:
      good = length == 36U && soak_all_finite(p, 9U) && soak_note(&cal->g_sensitivity, p);
      break;
    case SOAK_SECTION_COUPLINGS:
      good = soak_take_couplings(cal, p, length);
      break;
    case SOAK_SECTION_THERMOMETERS:
      good = length == 4U && soak_note(&cal->thermometers, p);
      break;
    case SOAK_SECTION_ERROR_BOUND:
      good = soak_take_error_bound(cal, p, length);
      break;
    case SOAK_SECTION_TABLE_BOUND:
      good = soak_take_table_bound(cal, p, length);
      break;
    case SOAK_SECTION_TERM: /* for those who know its name and have its input */
      good = length >= 4U;
      break;
    default:
      if (type == 0U) break;
      if ((head[3] & 1U) != 0U) return SOAK_E_UNKNOWN;
      good = 1;
      break;
  }
  return good && cal->provenance != NULL ? SOAK_OK : SOAK_E_FORMAT;
}

static inline soak_status soak_take_sections(soak_cal* cal, const uint8_t* data, uint32_t first, uint32_t end,
                                             uint32_t count) {
  uint32_t at = first, i, present = 0U;
  for (i = 0; i < count; ++i) {
    uint32_t length;
    soak_status status;
    cal->error_offset = at;
    if (end - at < 8U) return SOAK_E_FORMAT;
    length = soak_u32(data + at + 4);
    if (length % 4U != 0U || length > end - at - 8U) return SOAK_E_FORMAT;
    status = soak_take_section(cal, data + at);
    if (status != SOAK_OK) return status;
    at += 8U + length;
  }
  cal->error_offset = at;
  if (at != end) return SOAK_E_FORMAT;
  for (i = 0; i < SOAK_SENSORS; ++i) {
    const soak_sensor* sensor = &cal->sensor[i];
    uint32_t q;
    present += sensor->present;
    if (sensor->present && sensor->curve[0].payload == NULL) return SOAK_E_FORMAT;
    for (q = 0; q < 2U; ++q) {
      if (sensor->uncertainty[q] != NULL && sensor->curve[q].payload == NULL) return SOAK_E_FORMAT;
    }
  }
  return present != 0U ? SOAK_OK : SOAK_E_FORMAT;
}

static inline soak_status soak_load_checked(soak_cal* cal, const uint8_t* data, size_t size) {
  static const uint8_t magic[8] = {0x89, 0x53, 0x4F, 0x41, 0x4B, 0x0D, 0x0A, 0x1A};
  uint32_t header, count, i;
  for (i = 0; i < 8U; ++i) {
    if (size < 8U || data[i] != magic[i]) return SOAK_E_MAGIC;
  }
  if (size < 28U || size > SOAK_MAX_FILE || soak_u32(data + 12) != size) return SOAK_E_CHECK;
  if (soak_crc32c(data, size - 4U) != soak_u32(data + size - 4U)) return SOAK_E_CHECK;
  if (soak_u16(data + 8) != 1U) return SOAK_E_VERSION;
  header = soak_u32(data + 16);
  count = soak_u32(data + 20);
  if (header < 24U || header % 4U != 0U || header > size - 4U || size % 4U != 0U) return SOAK_E_FORMAT;
  if (count == 0U || count > SOAK_MAX_SECTIONS) return SOAK_E_FORMAT;
  cal->sections[0] = header;
  cal->sections[1] = (uint32_t)size - 4U;
  return soak_take_sections(cal, data, header, (uint32_t)size - 4U, count);
}

static inline void soak_clear(soak_cal* cal) {
  uint8_t* bytes = (uint8_t*)cal;
  size_t i;
  for (i = 0; i < sizeof *cal; ++i) bytes[i] = 0U;
}

/* ---- loading ---- */

/* Checks the whole file, byte for byte, and notes where things lie in it. On anything but SOAK_OK the calibration is
 * empty: every sensor is absent. Time linear in the size (about 10 cycles a byte for the check sum). */
SOAK_NODISCARD static inline soak_status soak_load(soak_cal* cal, const void* data, size_t size) {
  soak_status status;
  uint32_t offset;
  if (cal == NULL) return SOAK_E_ARGUMENT;
  soak_clear(cal);
  if (data == NULL) return SOAK_E_ARGUMENT;
  status = soak_load_checked(cal, (const uint8_t*)data, size);
  if (status != SOAK_OK) {
    offset = cal->error_offset;
    soak_clear(cal);
    cal->error_offset = offset;
  }
  return status;
}

/* ---- private: evaluation of the three kinds of curve, without centre and half range ---- */

static inline float soak_clamp(float value, float low, float high) {
  return value < low ? low : value > high ? high : value;
}

/* 2^y, relative error 1.2e-7 at most; 0 for y <= -126. y at most 126. */
static inline float soak_exp2(float y) {
  int32_t whole;
  float f, p;
  if (!(y > -126.0f)) return 0.0f;
  whole = (int32_t)(y + 256.5f) - 256;
  f = y - (float)whole; /* in -0.5..0.5 */
  p = 1.0f +
      f * (0.693147182f +
           f * (0.240226477f + f * (0.0555033237f + f * (0.00961843692f + f * (0.0013398875f + f * 0.00015353362f)))));
  return p * soak_float_of((uint32_t)(whole + 127) << 23);
}

/* log2 x for FLT_MIN <= x <= FLT_MAX, error at most 1.2e-7 of the larger of |log2 x| and 1. */
static inline float soak_log2(float x) {
  const uint32_t bits = soak_bits_of(x);
  const int32_t whole = (int32_t)((bits + (0x3F800000U - 0x3F3504F3U)) >> 23) - 127;
  const float m = soak_float_of(bits - ((uint32_t)whole << 23)); /* from sqrt(1/2) to sqrt(2) */
  const float s = (m - 1.0f) / (m + 1.0f);                       /* log2 m = 2/ln 2 (s + s^3/3 + s^5/5 ...) */
  const float q = s * s;
  return (float)whole + s * (2.88539004f + q * (0.961798847f + q * (0.576714218f + q * 0.431741714f)));
}

/* |z|^exponent, exponent at least 1; the small ones without a loop */
static inline float soak_whole_power(float z, uint32_t exponent) {
  float power = (exponent & 1U) != 0U ? soak_magnitude(z) : 1.0f;
  float square = z * z;
  if ((exponent & 2U) != 0U) power *= square;
  if (exponent < 4U) return power;
  square *= square;
  if ((exponent & 4U) != 0U) power *= square;
  for (exponent >>= 3; exponent != 0U; exponent >>= 1) {
    square *= square;
    if ((exponent & 1U) != 0U) power *= square;
  }
  return power;
}

/* mu = 1 / (1 + |z|^(2 slope)), soak_is_whole(slope) */
static inline float soak_whole_bell(float z, float slope) {
  return 1.0f / (1.0f + soak_whole_power(z, (uint32_t)(int32_t)(2.0f * slope)));
}

/* mu = 1 / (1 + |z|^(2 slope)) */
static inline float soak_bell(float z, float slope) {
  float exponent;
  if (soak_is_whole(slope)) return soak_whole_bell(z, slope);
  z = soak_magnitude(z);
  if (z < FLT_MIN) return 1.0f;
  if (z > FLT_MAX) return 0.0f;
  exponent = 2.0f * (slope * soak_log2(z));
  return exponent > 126.0f ? 0.0f : 1.0f / (1.0f + soak_exp2(exponent));
}

/* mu = exp(-z^2 / 2) */
static inline float soak_gaussian(float z) { return soak_exp2(-0.72134752f * (z * z)); }

/* T - c of a rule; the centre is in two parts, so that the first difference is exact near the centre */
static inline float soak_rule_distance(const uint8_t* rule, float t) {
  return (t - soak_f32(rule)) - soak_f32(rule + 4);
}

/* v + g d of a rule */
static inline float soak_rule_value(const uint8_t* rule, float distance) {
  return soak_f32(rule + 16) + soak_f32(rule + 20) * distance;
}

/* All strengths underflow: the value of the rule that is nearest in units of its width, the first of equals. */
static inline float soak_nearest_rule(const uint8_t* rules, uint32_t count, float t) {
  float nearest = 0.0f, least = 0.0f;
  uint32_t i;
  for (i = 0; i < count; ++i) {
    const float d = soak_rule_distance(rules + 24U * i, t);
    const float z = soak_magnitude(d / soak_f32(rules + 24U * i + 8));
    if (i != 0U && !(z < least)) continue;
    least = z;
    nearest = soak_rule_value(rules + 24U * i, d);
  }
  return nearest;
}

static inline float soak_strength(const uint8_t* rule, uint32_t kind, uint32_t membership, float z) {
  if (kind == SOAK_KIND_WHOLE_BELLS) return soak_whole_bell(z, soak_f32(rule + 12));
  return membership == 0U ? soak_bell(z, soak_f32(rule + 12)) : soak_gaussian(z);
}

/* r(T) = sum mu_i (v_i + g_i d_i) / sum mu_i; `kind` is a constant at each call, which gives each its own loop */
static inline float soak_eval_rules(const uint8_t* p, uint32_t kind, float temp_c) {
  const uint32_t count = soak_u16(p + 4);
  const float t = soak_clamp(temp_c, soak_f32(p + 8), soak_f32(p + 12));
  float numerator = 0.0f, denominator = 0.0f;
  uint32_t i;
  for (i = 0; i < count; ++i) {
    const uint8_t* rule = p + 24U + 24U * i;
    const float d = soak_rule_distance(rule, t);
    const float mu = soak_strength(rule, kind, p[2], d / soak_f32(rule + 8));
    numerator += mu * soak_rule_value(rule, d);
    denominator += mu;
  }
  return denominator > 0.0f ? numerator / denominator : soak_nearest_rule(p + 24, count, t);
}

static inline float soak_eval_fis(const uint8_t* p, uint32_t kind, float temp_c) {
  return kind == SOAK_KIND_WHOLE_BELLS ? soak_eval_rules(p, SOAK_KIND_WHOLE_BELLS, temp_c)
                                       : soak_eval_rules(p, SOAK_SECTION_FIS, temp_c);
}

/* Index of the interval of the rising numbers at p[0..intervals] that holds t; p[0] <= t. */
static inline uint32_t soak_interval(const uint8_t* p, uint32_t intervals, float t) {
  uint32_t low = 0U, high = intervals;
  while (high - low > 1U) {
    const uint32_t middle = (low + high) / 2U;
    if (soak_f32(p + 4U * middle) <= t) {
      low = middle;
    } else {
      high = middle;
    }
  }
  return low;
}

static inline float soak_eval_spline(const uint8_t* p, float temp_c) {
  const uint32_t count = soak_u16(p + 2);
  const uint8_t* knots = p + 12;
  const float t = soak_clamp(temp_c, soak_f32(knots), soak_f32(knots + 4U * count));
  const uint32_t j = soak_interval(knots, count, t);
  const uint8_t* q = knots + 4U * (count + 1U) + 16U * j;
  const float left = soak_f32(knots + 4U * j), right = soak_f32(knots + 4U * j + 4U);
  /* from the nearer end, where the difference is nearly exact */
  const float s = t - left < right - t ? -1.0f + 2.0f * ((t - left) / (right - left))
                                       : 1.0f - 2.0f * ((right - t) / (right - left));
  return soak_f32(q) + s * (soak_f32(q + 4) + s * (soak_f32(q + 8) + s * soak_f32(q + 12)));
}

static inline float soak_eval_table(const uint8_t* p, float temp_c) {
  const int32_t last = (int32_t)soak_u16(p + 2) - 1;
  const float step = soak_f32(p + 16), per_step = 1.0f / step;
  const float offset = temp_c - soak_f32(p + 12);
  const uint8_t* values = p + 20;
  const float steps = offset * per_step;
  int32_t j;
  float low;
  if (!(offset > 0.0f)) return soak_f32(values);
  if (offset >= (float)last * step) return soak_f32(values + 4 * last);
  j = steps < (float)last ? (int32_t)steps : last - 1;
  low = soak_f32(values + 4 * j);
  return low + (soak_f32(values + 4 * j + 4) - low) * ((offset - (float)j * step) * per_step);
}

/* y = C + H r(T) */
static inline float soak_eval_curve(const soak_curve* curve, float temp_c) {
  const uint8_t* p = curve->payload;
  if (curve->kind == SOAK_SECTION_SPLINE) return soak_f32(p + 4) + soak_f32(p + 8) * soak_eval_spline(p, temp_c);
  if (curve->kind == SOAK_SECTION_TABLE) return soak_f32(p + 4) + soak_f32(p + 8) * soak_eval_table(p, temp_c);
  return soak_f32(p + 16) + soak_f32(p + 20) * soak_eval_fis(p, curve->kind, temp_c);
}

/* Whether a temperature lies beyond the curve's domain, where the curve is held. */
static inline int soak_beyond_domain(const soak_curve* curve, float temp_c) {
  const uint8_t* p = curve->payload;
  if (curve->kind == SOAK_SECTION_SPLINE) {
    return temp_c < soak_f32(p + 12) || temp_c > soak_f32(p + 12 + 4U * soak_u16(p + 2));
  }
  if (curve->kind == SOAK_SECTION_TABLE) {
    const float offset = temp_c - soak_f32(p + 12);
    return offset < 0.0f || offset > (float)(soak_u16(p + 2) - 1U) * soak_f32(p + 16);
  }
  return temp_c < soak_f32(p + 8) || temp_c > soak_f32(p + 12);
}

/* Linear between the points at `temps`, held beyond them. */
static inline float soak_interpolate(const uint8_t* temps, const uint8_t* values, uint32_t count, float temp_c) {
  uint32_t j;
  float left, fraction, low;
  if (temp_c <= soak_f32(temps)) return soak_f32(values);
  if (temp_c >= soak_f32(temps + 4U * (count - 1U))) return soak_f32(values + 4U * (count - 1U));
  j = soak_interval(temps, count - 1U, temp_c);
  left = soak_f32(temps + 4U * j);
  fraction = (temp_c - left) / (soak_f32(temps + 4U * j + 4U) - left);
  low = soak_f32(values + 4U * j);
  return low + (soak_f32(values + 4U * j + 4U) - low) * fraction;
}

/* The sensor's valid range applied to *temp_c. */
static inline soak_status soak_limit_temperature(const soak_sensor* sensor, float* temp_c) {
  const float given = *temp_c;
  if (!soak_is_finite(given)) return SOAK_INVALID;
  *temp_c = soak_clamp(given, sensor->temp_min_c, sensor->temp_max_c);
  return given < sensor->temp_min_c || given > sensor->temp_max_c ? SOAK_CLAMPED : SOAK_OK;
}

static inline soak_status soak_quantity(const soak_cal* cal, int sensor, int quantity, float temp_c, float* value) {
  soak_status status;
  if (cal == NULL || value == NULL || sensor < 0 || sensor >= SOAK_SENSORS) return SOAK_E_ARGUMENT;
  *value = soak_nan();
  if (cal->sensor[sensor].curve[quantity].payload == NULL) return SOAK_ABSENT;
  status = soak_limit_temperature(&cal->sensor[sensor], &temp_c);
  if (status == SOAK_INVALID) return SOAK_INVALID;
  *value = soak_eval_curve(&cal->sensor[sensor].curve[quantity], temp_c);
  if (!soak_is_finite(*value)) {
    *value = soak_nan();
    return SOAK_INVALID;
  }
  /* the valid range is that of the bias; the scale may rest on fewer temperatures */
  if (quantity == 1 && soak_beyond_domain(&cal->sensor[sensor].curve[1], temp_c)) return SOAK_CLAMPED;
  return status;
}

/* ---- whose calibration it is ---- */

/* What the file says of its unit and of itself. The texts lie in the file, are UTF-8 and do not end with a zero. */
typedef struct soak_identity {
  const char* serial;
  const char* unit_type;
  uint32_t serial_length, unit_type_length; /* bytes */
  int32_t epoch;         /* counts the unit's repairs and re-flashes: a file of an earlier one is out of date */
  int32_t model_version; /* counts within the epoch: of two files the greater is the newer */
} soak_identity;

/* SOAK_ABSENT, and identity is not written: no file is loaded. */
SOAK_NODISCARD static inline soak_status soak_identify(const soak_cal* cal, soak_identity* identity) {
  const uint8_t* p;
  if (cal == NULL || identity == NULL) return SOAK_E_ARGUMENT;
  p = cal->provenance;
  if (p == NULL) return SOAK_ABSENT;
  identity->serial = (const char*)(p + 32U + 32U * soak_u16(p + 28));
  identity->serial_length = p[30];
  identity->unit_type = identity->serial + p[30];
  identity->unit_type_length = p[31];
  identity->epoch = (int32_t)soak_u32(p);
  identity->model_version = (int32_t)soak_u32(p + 4);
  return SOAK_OK;
}

/* 1 where the file is of the unit with this serial number (a text that ends with a zero, compared byte for byte), else
 * 0, also without a file. */
SOAK_NODISCARD static inline int soak_is_of_unit(const soak_cal* cal, const char* serial) {
  const uint8_t* text;
  uint32_t i;
  if (cal == NULL || cal->provenance == NULL || serial == NULL) return 0;
  text = cal->provenance + 32U + 32U * soak_u16(cal->provenance + 28);
  for (i = 0; i < cal->provenance[30]; ++i) {
    if (serial[i] == '\0' || (uint8_t)serial[i] != text[i]) return 0;
  }
  return serial[i] == '\0';
}

/* 1 where a sensor of the file was calibrated over a thermometer of its own, else 0: over the unit's. Whoever asks for
 * anything of this sensor means the temperature of that thermometer. */
SOAK_NODISCARD static inline int soak_has_own_thermometer(const soak_cal* cal, int sensor) {
  if (cal == NULL || sensor < 0 || sensor >= SOAK_SENSORS || cal->thermometers == NULL) return 0;
  return cal->sensor[sensor].present && (soak_u32(cal->thermometers) >> sensor & 1U) != 0U;
}

/* ---- evaluation ---- */

/* Bias at temp_c, of the thermometer that the sensor was calibrated over, in rad/s or m/s². SOAK_CLAMPED: the value
 * belongs to the nearer end of the valid range. SOAK_ABSENT, SOAK_INVALID: the value is NaN. */
SOAK_NODISCARD static inline soak_status soak_bias(const soak_cal* cal, int sensor, float temp_c, float* value) {
  return soak_quantity(cal, sensor, 0, temp_c, value);
}

/* Scale factor error at temp_c in ppm; SOAK_ABSENT (NaN) where it is unknown. SOAK_CLAMPED: it was not measured there,
 * in the valid range or beyond it; the value is that of the nearest temperature at which it was. Else as soak_bias. */
SOAK_NODISCARD static inline soak_status soak_scale_ppm(const soak_cal* cal, int sensor, float temp_c, float* value) {
  return soak_quantity(cal, sensor, 1, temp_c, value);
}

/* Half-widths (95 %) of the bias at temp_c: ci95 of the mean curve over all power-ons, pi95 of one fresh power-on (NaN
 * where the file does not give it). Of one run (soak_is_of_one_run) ci95 is that of this power-on's curve: it does not
 * hold the scatter from power-on to power-on, and there is no pi95. SOAK_CLAMPED: they hold at the nearer end of the
 * valid range, nothing is known outside. */
SOAK_NODISCARD static inline soak_status soak_uncertainty(const soak_cal* cal, int sensor, float temp_c, float* ci95,
                                                          float* pi95) {
  const uint8_t* p;
  uint32_t count;
  soak_status status;
  if (cal == NULL || ci95 == NULL || pi95 == NULL || sensor < 0 || sensor >= SOAK_SENSORS) return SOAK_E_ARGUMENT;
  *ci95 = soak_nan();
  *pi95 = soak_nan();
  p = cal->sensor[sensor].uncertainty[0];
  if (p == NULL) return SOAK_ABSENT;
  status = soak_limit_temperature(&cal->sensor[sensor], &temp_c);
  if (status == SOAK_INVALID) return SOAK_INVALID;
  count = soak_u16(p + 2);
  *ci95 = soak_interpolate(p + 8, p + 8U + 4U * count, count, temp_c);
  if ((soak_u32(p + 4) & 1U) != 0U) *pi95 = soak_interpolate(p + 8, p + 8U + 8U * count, count, temp_c);
  return status;
}

/* 1 where the file says that the half-widths of soak_uncertainty come from one run, else 0: they do not hold the
 * scatter from power-on to power-on, which nobody knows. Files before format 1.6 do not say it. */
SOAK_NODISCARD static inline int soak_is_of_one_run(const soak_cal* cal, int sensor) {
  if (cal == NULL || sensor < 0 || sensor >= SOAK_SENSORS || cal->sensor[sensor].uncertainty[0] == NULL) return 0;
  return (soak_u32(cal->sensor[sensor].uncertainty[0] + 4) & 2U) != 0U;
}

/* Largest difference over the valid range of soak_bias (quantity 0) or soak_scale_ppm (quantity 1) from the curve that
 * the laboratory fitted, in the unit of the value: what float32 costs (the largest found on a fine grid), and where the
 * file has the table form what that costs (proven). SOAK_ABSENT, and NaN: the file does not say. */
SOAK_NODISCARD static inline soak_status soak_curve_error(const soak_cal* cal, int sensor, int quantity, float* bound) {
  const soak_sensor* owner;
  if (cal == NULL || bound == NULL || sensor < 0 || sensor >= SOAK_SENSORS || quantity < 0 || quantity > 1) {
    return SOAK_E_ARGUMENT;
  }
  *bound = soak_nan();
  owner = &cal->sensor[sensor];
  if (owner->error_bound[quantity] == NULL) return SOAK_ABSENT;
  *bound = soak_f32(owner->error_bound[quantity] + 4);
  if (owner->table_bound[quantity] != NULL) *bound += soak_f32(owner->table_bound[quantity] + 4);
  return SOAK_OK;
}

/* Standard uncertainties (k = 1) of the entries of a coupling, row by row: SOAK_MISALIGNMENT (row: accelerometer,
 * column: specific force; the diagonal is 0), SOAK_G_SENSITIVITY (row: gyro; (rad/s)/(m/s²)), SOAK_GYRO_MISALIGNMENT
 * (row: gyro, column: rate; the diagonal is 0). SOAK_ABSENT, and NaN: the file does not say. */
SOAK_NODISCARD static inline soak_status soak_coupling_sigma(const soak_cal* cal, int coupling, float sigma[9]) {
  const uint8_t* block = NULL;
  uint32_t i;
  if (cal == NULL || sigma == NULL || coupling < SOAK_MISALIGNMENT || coupling > SOAK_GYRO_MISALIGNMENT) {
    return SOAK_E_ARGUMENT;
  }
  if (coupling == SOAK_GYRO_MISALIGNMENT) {
    const uint8_t* p = cal->gyro_misalignment;
    if (p != NULL && (soak_u32(p) & SOAK_GYRO_UNCERTAINTIES) != 0U) block = p + 40;
  } else if (cal->couplings != NULL) {
    block = soak_coupling_block(cal->couplings, (uint32_t)coupling);
  }
  for (i = 0; i < 9U; ++i) sigma[i] = block != NULL ? soak_f32(block + 4U * i) : soak_nan();
  return block != NULL ? SOAK_OK : SOAK_ABSENT;
}

/* Even-order term of an accelerometer and its standard uncertainty, 1/(m/s²): its reading holds value * (f² - g²), f
 * the specific force along its axis. soak_apply leaves that in. SOAK_ABSENT, and NaN: the file does not say. */
SOAK_NODISCARD static inline soak_status soak_even_order(const soak_cal* cal, int sensor, float* value, float* sigma) {
  const uint8_t* block;
  if (cal == NULL || value == NULL || sigma == NULL || sensor < SOAK_ACCEL_X || sensor >= SOAK_SENSORS) {
    return SOAK_E_ARGUMENT;
  }
  block = cal->couplings == NULL
              ? NULL
              : soak_coupling_block(cal->couplings, (uint32_t)(SOAK_BLOCK_EVEN_ORDER + sensor - SOAK_ACCEL_X));
  *value = block != NULL ? soak_f32(block) : soak_nan();
  *sigma = block != NULL ? soak_f32(block + 4) : soak_nan();
  return block != NULL ? SOAK_OK : SOAK_ABSENT;
}

/* The valid range of a sensor in °C. */
SOAK_NODISCARD static inline soak_status soak_temp_range(const soak_cal* cal, int sensor, float* min_c, float* max_c) {
  if (cal == NULL || min_c == NULL || max_c == NULL || sensor < 0 || sensor >= SOAK_SENSORS) return SOAK_E_ARGUMENT;
  if (!cal->sensor[sensor].present) return SOAK_ABSENT;
  *min_c = cal->sensor[sensor].temp_min_c;
  *max_c = cal->sensor[sensor].temp_max_c;
  return SOAK_OK;
}

/* ---- private: correction ---- */

/* reading = raw - b and 1 + S ppm of one sensor; returns 0, with flags, where it must stay uncorrected. */
static inline int soak_prepare(const soak_cal* cal, uint32_t i, float temp_c, float raw, float* reading, float* gain,
                               uint32_t* flags) {
  float bias = 0.0f, scale_ppm = 0.0f;
  soak_status status = soak_bias(cal, (int)i, temp_c, &bias);
  soak_status scale_status;
  *reading = raw;
  *gain = 1.0f;
  if (!soak_is_finite(raw)) *flags |= SOAK_FLAG_INVALID(i);
  if (status == SOAK_ABSENT) *flags |= SOAK_FLAG_ABSENT(i);
  if (status == SOAK_INVALID) *flags |= SOAK_FLAG_INVALID(i);
  if (status == SOAK_CLAMPED) *flags |= SOAK_FLAG_CLAMPED(i);
  if (!soak_is_finite(raw) || status == SOAK_ABSENT || status == SOAK_INVALID) return 0;
  scale_status = soak_scale_ppm(cal, (int)i, temp_c, &scale_ppm);
  if (scale_status == SOAK_ABSENT) scale_ppm = 0.0f;
  if (scale_status == SOAK_INVALID || soak_magnitude(scale_ppm) > 500000.0f) {
    *flags |= SOAK_FLAG_INVALID(i);
    return 0;
  }
  if (scale_status == SOAK_CLAMPED && status == SOAK_OK) *flags |= SOAK_FLAG_SCALE(i);
  *reading = raw - bias;
  *gain = 1.0f + scale_ppm * 1e-6f;
  return 1;
}

/* x = K^-1 y by Cramer's rule; K is near the unit matrix: its diagonal is at least 0.5, the rest at most 0.2 */
static inline void soak_solve3(float k[3][3], const float y[3], float x[3]) {
  const float c00 = k[1][1] * k[2][2] - k[1][2] * k[2][1];
  const float c01 = k[1][2] * k[2][0] - k[1][0] * k[2][2];
  const float c02 = k[1][0] * k[2][1] - k[1][1] * k[2][0];
  const float determinant = k[0][0] * c00 + k[0][1] * c01 + k[0][2] * c02;
  x[0] =
      (y[0] * c00 + y[1] * (k[0][2] * k[2][1] - k[0][1] * k[2][2]) + y[2] * (k[0][1] * k[1][2] - k[0][2] * k[1][1])) /
      determinant;
  x[1] =
      (y[0] * c01 + y[1] * (k[0][0] * k[2][2] - k[0][2] * k[2][0]) + y[2] * (k[0][2] * k[1][0] - k[0][0] * k[1][2])) /
      determinant;
  x[2] =
      (y[0] * c02 + y[1] * (k[0][1] * k[2][0] - k[0][0] * k[2][1]) + y[2] * (k[0][0] * k[1][1] - k[0][1] * k[1][0])) /
      determinant;
}

/* f = K(T)^-1 (raw - b(T)); returns which of force[3] are usable for g-sensitivity, as bits. */
static inline uint32_t soak_apply_accels(const soak_cal* cal, const float temps_c[6], const float raw[6], float out[6],
                                         uint32_t* flags) {
  float reading[3], gain[3], k[3][3], force[3];
  uint32_t usable = 0U, corrected = 0U, i, j;
  for (i = 0; i < 3U; ++i) {
    corrected |= (uint32_t)soak_prepare(cal, 3U + i, temps_c[3U + i], raw[3U + i], &reading[i], &gain[i], flags) << i;
    if ((*flags & SOAK_FLAG_INVALID(3U + i)) == 0U) usable |= 1U << i;
  }
  for (i = 0; i < 3U; ++i) {
    if ((usable >> i & 1U) == 0U) reading[i] = 0.0f;
    for (j = 0; j < 3U; ++j) {
      const int coupled = cal->misalignment != NULL && (corrected >> i & 1U) != 0U && (usable >> j & 1U) != 0U;
      k[i][j] = i == j ? gain[i] : coupled ? soak_f32(cal->misalignment + 4U * (3U * i + j)) : 0.0f;
    }
  }
  soak_solve3(k, reading, force);
  for (i = 0; i < 3U; ++i) {
    if ((corrected >> i & 1U) == 0U) continue;
    out[3U + i] = force[i];
    if (!soak_is_finite(force[i])) { /* the input is finite, but beyond what float32 can carry */
      out[3U + i] = raw[3U + i];
      *flags |= SOAK_FLAG_INVALID(3U + i);
      usable &= ~(1U << i);
    }
  }
  return usable;
}

/* w = K(T)^-1 (raw - b(T) - G f), without misalignment (raw - b(T) - G f) / (1 + S); returns 1 where all three gyros
 * take part in it */
static inline int soak_apply_gyros(const soak_cal* cal, const float temps_c[6], const float raw[6], float out[6],
                                   uint32_t usable_forces, uint32_t* flags) {
  float reading[3], gain[3], k[3][3], rate[3];
  uint32_t usable = 0U, corrected = 0U, i, j;
  for (i = 0; i < 3U; ++i) {
    corrected |= (uint32_t)soak_prepare(cal, i, temps_c[i], raw[i], &reading[i], &gain[i], flags) << i;
    if ((*flags & SOAK_FLAG_INVALID(i)) == 0U) usable |= 1U << i;
    for (j = 0; j < 3U && (corrected >> i & 1U) != 0U; ++j) {
      if (cal->g_sensitivity == NULL || (usable_forces >> j & 1U) == 0U) continue;
      reading[i] -= soak_f32(cal->g_sensitivity + 4U * (3U * i + j)) * out[3U + j];
    }
    rate[i] = reading[i] / gain[i];
  }
  if (cal->gyro_misalignment != NULL) {
    for (i = 0; i < 3U; ++i) {
      if ((usable >> i & 1U) == 0U) reading[i] = 0.0f;
      for (j = 0; j < 3U; ++j) {
        const int coupled = (corrected >> i & 1U) != 0U && (usable >> j & 1U) != 0U;
        k[i][j] = i == j ? gain[i] : coupled ? soak_f32(cal->gyro_misalignment + 4U + 4U * (3U * i + j)) : 0.0f;
      }
    }
    soak_solve3(k, reading, rate);
  }
  for (i = 0; i < 3U; ++i) {
    if ((corrected >> i & 1U) == 0U) continue;
    if (soak_is_finite(rate[i])) {
      out[i] = rate[i];
    } else {
      *flags |= SOAK_FLAG_INVALID(i);
      usable &= ~(1U << i);
    }
  }
  return usable == 7U;
}

/* ---- correction ---- */

/* Corrects one sample of all six sensors: raw and out in rad/s and m/s², order gyro x y z, accel x y z; they may be the
 * same array. temps_c[i] is the temperature of the thermometer that sensor i was calibrated over, its own or the unit's
 * (soak_has_own_thermometer). Always writes out and flags: a sensor that cannot be corrected passes through unchanged,
 * with its flag. Returns SOAK_OK only if no flag is set; else the worst of SOAK_CLAMPED, SOAK_ABSENT, SOAK_INVALID.
 * flags must not be null. */
SOAK_NODISCARD static inline soak_status soak_apply_temps(const soak_cal* cal, const float temps_c[6],
                                                          const float raw[6], float out[6], uint32_t* flags) {
  float given[6];
  uint32_t usable, i;
  int whole_triad;
  if (cal == NULL || temps_c == NULL || raw == NULL || out == NULL || flags == NULL) return SOAK_E_ARGUMENT;
  for (i = 0; i < 6U; ++i) given[i] = raw[i];
  for (i = 0; i < 6U; ++i) out[i] = given[i];
  *flags = 0U;
  usable = soak_apply_accels(cal, temps_c, given, out, flags);
  if (usable != 7U && (cal->misalignment != NULL || cal->g_sensitivity != NULL)) *flags |= SOAK_FLAG_UNCOUPLED;
  whole_triad = soak_apply_gyros(cal, temps_c, given, out, usable, flags);
  if (!whole_triad && cal->gyro_misalignment != NULL) *flags |= SOAK_FLAG_UNCOUPLED;
  if ((*flags & 0x003F0000U) != 0U) return SOAK_INVALID;
  if ((*flags & 0x00003F00U) != 0U) return SOAK_ABSENT;
  return *flags != 0U ? SOAK_CLAMPED : SOAK_OK;
}

/* The same where one temperature is known, that of the unit's thermometer. Sensors with thermometers of their own are
 * left raw, with SOAK_FLAG_INVALID and SOAK_FLAG_THERMOMETER: their curves say nothing of this temperature. */
SOAK_NODISCARD static inline soak_status soak_apply(const soak_cal* cal, float temp_c, const float raw[6], float out[6],
                                                    uint32_t* flags) {
  float temps_c[6];
  uint32_t others = 0U;
  soak_status status;
  int i;
  for (i = 0; i < SOAK_SENSORS; ++i) {
    const int own = soak_has_own_thermometer(cal, i);
    temps_c[i] = own ? soak_nan() : temp_c;
    if (own) others = SOAK_FLAG_THERMOMETER;
  }
  status = soak_apply_temps(cal, temps_c, raw, out, flags);
  if (status >= SOAK_OK) *flags |= others;
  return status;
}

#ifdef __cplusplus
}
#endif

#endif /* SOAK_RUNTIME_H_ */
