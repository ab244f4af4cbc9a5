// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/hal/xsens_peer.h"

/// Packets of an MTi-300 that MT Manager has captured and decoded (Scottapotamas/xsens-mti, docs/mtmanager_packets.md).
namespace soak::hal::imu::test {

inline Bytes golden_with_temperature() {
  return hex(
      "FA FF 36 92 10 20 02 91 8D 10 60 04 01 36 3F A6 20 10 10 3F 35 E0 42 3F 31 CD 15 BD 9F 49 DB BD A9 38 CF 40 20 "
      "0C "
      "BD 63 5A 90 41 1D 08 D4 3E 5F AA 50 40 10 0C B9 11 68 00 3C C9 01 00 3A 0F 7D 00 40 30 0C BC 3B 29 80 3C 35 FC "
      "00 "
      "3C A4 6E 00 80 20 0C 3C AE A2 41 BB 56 D8 00 BA D5 AC 01 80 30 10 3F 80 00 00 37 DF 88 01 B6 89 80 00 B6 08 C0 "
      "00 "
      "C0 20 0C BE FB FB F2 3F 33 C4 85 BF A0 A2 C1 08 10 04 42 16 80 00 30 10 04 00 01 86 E1 E0 20 04 00 40 00 03 DD");
}

/// Without acceleration, rate and temperature.
inline Bytes golden_short() {
  return hex(
      "FA FF 36 26 10 20 02 46 82 10 60 04 01 C4 FC 3E 20 10 10 3F 71 CE 6C BE A5 6B CF 3C 61 3B D8 BD 69 1D 25 E0 20 "
      "04 "
      "00 40 00 03 12");
}

}  // namespace soak::hal::imu::test
