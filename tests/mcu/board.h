/* SPDX-License-Identifier: Apache-2.0 */
/* The board that qemu emulates (mps2-an386, Cortex-M4F): text to the host, end of the program, a counter. */
#ifndef SOAK_TESTS_MCU_BOARD_H_
#define SOAK_TESTS_MCU_BOARD_H_

#include <stdint.h>

void board_print(const char* text);

/* Starts the SysTick timer from its largest value; 40 instructions to a tick under `qemu -icount shift=0` (one
 * instruction is one nanosecond there, the timer runs at 25 MHz). */
void board_start_counter(void);
/* Ticks since then, at most 2^24 - 1. */
uint32_t board_ticks(void);

#endif
