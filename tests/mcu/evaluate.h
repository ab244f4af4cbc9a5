/* SPDX-License-Identifier: Apache-2.0 */
/* What the microcontroller and the host both do with a calibration file: the same source, compiled twice. */
#ifndef SOAK_TESTS_MCU_EVALUATE_H_
#define SOAK_TESTS_MCU_EVALUATE_H_

#include <stddef.h>
#include <stdint.h>

typedef void (*print_function)(const char* line);

/* Prints what a file says; numbers are float32 as their bits in hexadecimal. First a line `NAME constants STATUS TERMS`
 * and 36 numbers: standard uncertainties of misalignment and g-sensitivity (9 each), even-order terms and theirs (3
 * each), errors of the curves of bias and scale (12). Then one line per temperature from -45 to 85 °C in steps of 3/8
 * °C, `NAME temp STATUS FLAGS STATUS FLAGS` and 42 numbers: the corrected sample, the six biases, the six scale factor
 * errors, the sample as soak_apply_moving corrects it at 1/64 K/s, ci95 and pi95 of the six biases, the sample as
 * soak_apply_history corrects it after the way from -45 °C up. */
void evaluate_file(const char* name, const uint8_t* file, size_t size, print_function print);

/* Appends a number to the text at `at`, in eight hexadecimal digits or as a decimal; returns the new end. */
char* append_hex(char* at, uint32_t number);
char* append_decimal(char* at, uint32_t number);
char* append_text(char* at, const char* text);

#endif
