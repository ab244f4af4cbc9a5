/* SPDX-License-Identifier: Apache-2.0 */
/* Startup without a C library, and semihosting (Arm IHI 0100). */
#include "tests/mcu/board.h"

#include <stddef.h>

int main(void);

extern uint32_t stack_top[];
extern uint32_t bss_start[], bss_end[];

enum { kWriteText = 0x04, kExit = 0x18, kExitNormally = 0x20026, kExitByFault = 0x20023 };
enum { kCounterMax = 0xFFFFFF };

#define CPACR (*(volatile uint32_t*)0xE000ED88U)
#define SYST_CSR (*(volatile uint32_t*)0xE000E010U)
#define SYST_RVR (*(volatile uint32_t*)0xE000E014U)
#define SYST_CVR (*(volatile uint32_t*)0xE000E018U)

static void semihosting(int operation, const void* argument) {
  register int r0 __asm__("r0") = operation;
  register const void* r1 __asm__("r1") = argument;
  __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
}

void board_print(const char* text) { semihosting(kWriteText, text); }

void board_start_counter(void) {
  SYST_CSR = 0U;
  SYST_RVR = kCounterMax;
  SYST_CVR = 0U;
  SYST_CSR = 5U; /* on, processor clock */
}

uint32_t board_ticks(void) { return kCounterMax - SYST_CVR; }

/* What a compiler may call even in a freestanding program. */
void* memset(void* to, int value, size_t size) {
  uint8_t* at = (uint8_t*)to;
  size_t i;
  for (i = 0; i < size; ++i) at[i] = (uint8_t)value;
  return to;
}

void* memcpy(void* to, const void* from, size_t size) {
  uint8_t* at = (uint8_t*)to;
  const uint8_t* source = (const uint8_t*)from;
  size_t i;
  for (i = 0; i < size; ++i) at[i] = source[i];
  return to;
}

static void fault(void) {
  board_print("fault\n");
  semihosting(kExit, (const void*)kExitByFault);
}

static void start(void) {
  CPACR |= 0xFU << 20; /* floating-point unit */
  __asm__ volatile("dsb\n isb");
  (void)memset(bss_start, 0, (size_t)((uint8_t*)bss_end - (uint8_t*)bss_start));
  (void)main();
  semihosting(kExit, (const void*)kExitNormally);
}

typedef void (*handler)(void);

__attribute__((section(".vectors"), used)) static const struct {
  uint32_t* stack;
  handler handlers[15];
} kVectors = {stack_top, {start, fault, fault, fault, fault, fault}};
