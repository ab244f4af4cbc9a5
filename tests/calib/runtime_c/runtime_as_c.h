/* SPDX-License-Identifier: Apache-2.0 */
/* The runtime compiled as C99, for comparison with the same header compiled as C++. */
#ifndef SOAK_TESTS_RUNTIME_AS_C_H_
#define SOAK_TESTS_RUNTIME_AS_C_H_

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Loads the file and corrects one sample; the status of the step that failed, else that of soak_apply. */
int runtime_as_c_apply(const uint8_t* file, size_t size, float temp_c, const float raw[6], float out[6],
                       uint32_t* flags);

/* The same with the accepted effects of the file, at a rate of temperature. */
int runtime_as_c_apply_moving(const uint8_t* file, size_t size, float temp_c, float temp_rate_kps, const float raw[6],
                              float out[6], uint32_t* flags);

/* The same with the thermal history of a way that ends at the sample's temperature. */
int runtime_as_c_apply_history(const uint8_t* file, size_t size, const float* path_c, size_t count, float temp_rate_kps,
                               const float raw[6], float out[6], uint32_t* flags);

#ifdef __cplusplus
}
#endif

#endif
