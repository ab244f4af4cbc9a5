// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <string>

#include "tests/hal/xsens_peer.h"

/// A Crossbow AHRS400, written from its manual and not from the driver's code.
namespace soak::hal::imu::test {

/// The packet of the protocol notes: 100 °/s and 2 g; 1.0, -2.0, 0.5 °/s; 0, 0, -1 g; 25 °C; time 65535.
inline Bytes golden_ahrs400() { return hex("FF 00 DA FE 4B 00 6D 00 00 00 00 D5 55 0D A7 00 00 1B 4F 06 34 FF FF 10"); }

inline Bytes ahrs400_packet(const std::array<int, 11>& words) {
  Bytes packet{0xFF};
  unsigned sum = 0;
  for (const int word : words) packet = packet + u16(static_cast<unsigned>(word) & 0xFFFFU);
  for (std::size_t i = 1; i < packet.size(); ++i) sum += packet[i];
  packet.push_back(static_cast<std::uint8_t>(sum % 256));
  return packet;
}

/// Obeys its one-byte commands. Its time runs as the test lets it.
class Ahrs400Unit {
 public:
  std::uint32_t serial = 9911750;  ///< the manual's example
  std::string version = "AHRS400CC-100 ver 1.15";
  bool answers = true;
  bool bare_serial = false;  ///< four bytes without header and sum
  char mode = 'v';           ///< v voltage, s scaled
  bool continuous = false;
  double time_s = 0.0;  ///< since its power-on
  std::string heard;
  int sent = 0;

  Bytes take(std::span<const std::uint8_t> bytes) {
    Bytes answer;
    for (const std::uint8_t byte : bytes) answer = answer + obey(static_cast<char>(byte));
    return answer;
  }

  /// The packet of now; the rate of roll tells its number.
  Bytes packet() {
    const auto ticks = static_cast<std::uint64_t>(std::floor(time_s / 0.79e-6));
    const int timer = static_cast<int>(65535 - ticks % 65536);
    return ahrs400_packet({sent++ % 30000, 0, 0, 0, 0, -10923, 0, 0, 0, 0x0634, timer});
  }

  /// `count` packets, one every `step_s`.
  Bytes packets(int count, double step_s = 0.0155) {
    Bytes all;
    for (int i = 0; i < count; ++i) {
      time_s += step_s;
      all = all + packet();
    }
    return all;
  }

  void restart() {
    mode = 'v';
    continuous = false;
    time_s = 0.0;
    sent = 0;
  }

 private:
  Bytes obey(char command) {
    heard += command;
    if (!answers) return {};
    switch (command) {
      case 'R':
        mode = 'v';
        continuous = false;
        return {'H'};
      case 'S': {
        Bytes number = u32(serial);
        if (bare_serial) return number;
        const unsigned sum = number[0] + number[1] + number[2] + number[3];
        return Bytes{0xFF} + number + Bytes{static_cast<std::uint8_t>(sum % 256)};
      }
      case 'v':
        return text(version);
      case 'c':
        mode = 's';
        return {'C'};
      case 'C':
        continuous = true;
        return {};
      default:
        return {};
    }
  }
};

}  // namespace soak::hal::imu::test
