/* SPDX-License-Identifier: Apache-2.0 */
/* read_calibration FILE TEMP_C: bias of all sensors at a temperature, by the reader that firmware uses. */
#include <stdio.h>
#include <stdlib.h>

#include "calib/runtime/soak_runtime.h"

int main(int argc, char** argv) {
  static unsigned char bytes[1 << 20];
  static soak_cal cal;
  if (argc != 3) return 2;
  FILE* file = fopen(argv[1], "rb");
  if (file == NULL) return 2;
  const size_t size = fread(bytes, 1, sizeof bytes, file);
  fclose(file);
  if (soak_load(&cal, bytes, size) != SOAK_OK) return 4;
  const float temp_c = strtof(argv[2], NULL);
  for (int sensor = SOAK_GYRO_X; sensor < SOAK_SENSORS; ++sensor) {
    float bias = 0.0F; /* rad/s, m/s2; outside of the valid range the value at its nearer end, and SOAK_CLAMPED */
    const soak_status status = soak_bias(&cal, sensor, temp_c, &bias);
    if (status == SOAK_OK || status == SOAK_CLAMPED) printf("%d %.9g\n", sensor, (double)bias);
  }
  return 0;
}
