/* SPDX-License-Identifier: Apache-2.0 */
/* What the microcontroller and the host both do with a calibration file: the same source, compiled twice. */
#ifndef SOAK_TESTS_MCU_EVALUATE_H_
#define SOAK_TESTS_MCU_EVALUATE_H_

#include <stddef.h>
#include <stdint.h>

typedef void (*print_function)(const char* line);

/* Prints one line per temperature from -45 to 85 °C in steps of 3/8 °C, `NAME temp STATUS FLAGS` and 18 float32 as
 * their bits in hexadecimal: the corrected sample, the six biases, the six scale factor errors. */
void evaluate_file(const char* name, const uint8_t* file, size_t size, print_function print);

/* Appends a number to the text at `at`, in eight hexadecimal digits or as a decimal; returns the new end. */
char* append_hex(char* at, uint32_t number);
char* append_decimal(char* at, uint32_t number);
char* append_text(char* at, const char* text);

#endif
