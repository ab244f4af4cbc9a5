/* SPDX-License-Identifier: Apache-2.0 */
/* The deployment runtime, compiled as C99, run over one file. */
#ifndef SOAK_TESTS_FUZZ_EXERCISE_H_
#define SOAK_TESTS_FUZZ_EXERCISE_H_

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Loads the file and evaluates everything in and around the valid ranges; what soak_load() returned. *broken is a
 * promise of soak_runtime.h that did not hold, null if all did. */
int runtime_exercise(const uint8_t* file, size_t size, const char** broken);

#ifdef __cplusplus
}
#endif

#endif
