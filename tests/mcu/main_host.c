/* SPDX-License-Identifier: Apache-2.0 */
/* mcu_host NAME FILE...: what the microcontroller prints of the same files. */
#include <stdio.h>

#include "tests/mcu/evaluate.h"

enum { kLargest = 65536 };

static void print(const char* line) { (void)fputs(line, stdout); }

int main(int count, char** arguments) {
  static uint8_t bytes[kLargest];
  int i;
  for (i = 1; i + 1 < count; i += 2) {
    FILE* file = fopen(arguments[i + 1], "rb");
    size_t size;
    if (file == NULL) return 1;
    size = fread(bytes, 1, sizeof bytes, file);
    (void)fclose(file);
    evaluate_file(arguments[i], bytes, size, print);
  }
  return 0;
}
