// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "tests/hal/xsens_peer.h"

/// A VectorNav, written from its manual and not from the driver's code.
namespace soak::hal::imu::test {

/// The manual's first example: yaw, pitch, roll.
inline Bytes golden_vectornav_ypr() { return hex("FA 01 08 00 93 50 2E 42 83 3E F1 3F 48 B5 04 BB 92 88"); }

/// Of the protocol notes: time since startup, temperature, acceleration, rate.
inline Bytes golden_vectornav() {
  return hex(
      "FA 05 01 00 10 06 08 1A 99 BE 1C 00 00 00 00 00 CC 41 CD CC CC 3D CD CC 4C BE C3 F5 1C C1 0A D7 23 3C 0A D7 A3 "
      "3C 8F C2 F5 3C F3 71");
}

/// Bit by bit.
inline std::uint16_t slow_crc(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0;
  for (const std::uint8_t byte : bytes) {
    crc ^= static_cast<unsigned>(byte) << 8U;
    for (int bit = 0; bit < 8; ++bit) crc = ((crc & 0x8000U) != 0 ? crc * 2 ^ 0x1021U : crc * 2) & 0xFFFFU;
  }
  return static_cast<std::uint16_t>(crc);
}

template <class T>
Bytes le(T value) {
  Bytes bytes(sizeof value);
  std::memcpy(bytes.data(), &value, sizeof value);  // of a little-endian host
  return bytes;
}

inline Bytes vectornav_frame(const Bytes& head_and_values) {
  return Bytes{0xFA} + head_and_values + u16(slow_crc(head_and_values));
}

inline Bytes line(const std::string& body) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  std::array<char, 8> end{};
  std::snprintf(end.data(), end.size(), "*%02X\r\n", sum);
  return text("$" + body + end.data());
}

/// Keeps registers, sends lines until it is told not to, and binary output 1.
class VectorNavUnit {
 public:
  std::string model = "VN-100T-CR";
  std::string serial = "0100011981";
  std::string firmware = "2.1.0.0";
  bool answers = true;
  bool knows_saturation = true;
  int error_upon_output = 0;
  std::uint64_t time_ns = 1'000'000'000;
  bool lines = true;
  int divisor = 0;      ///< of output 1; 0 = off
  unsigned common = 0;  ///< its masks
  unsigned imu = 0;
  unsigned saturation = 0;
  int sent = 0;
  std::vector<std::string> heard;

  Bytes take(std::span<const std::uint8_t> bytes) {
    pending_.insert(pending_.end(), bytes.begin(), bytes.end());
    Bytes answer;
    for (auto end = pending_.find("\r\n"); end != std::string::npos; end = pending_.find("\r\n")) {
      const auto begin = pending_.find('$');
      const auto star = pending_.find('*');
      if (begin < star && star < end) answer = answer + obey(pending_.substr(begin + 1, star - begin - 1));
      pending_.erase(0, end + 2);
    }
    return answer;
  }

  /// A line as it is delivered: 40 a second.
  Bytes async_line() {
    time_ns += 25'000'000;
    return line("VNYMR,+010.071,+000.278,-002.026,+01.0,+00.1,+01.2,+0.1,+0.2,-9.8,+0.01,-0.02,+0.03");
  }

  Bytes packet() {
    time_ns += 1'000'000'000ULL * static_cast<unsigned>(divisor) / 800;
    const auto number = static_cast<float>(sent++);
    Bytes body{0x05};
    body = body + le(static_cast<std::uint16_t>(common)) + le(static_cast<std::uint16_t>(imu)) + le(time_ns) +
           le(20.0F + number) + le(number) + le(-number) + le(9.8F) + le(0.5F * number) + le(0.25F) + le(-0.125F);
    if ((imu & 0x800U) != 0) body = body + le(static_cast<std::uint16_t>(saturation));
    return vectornav_frame(body);
  }

  Bytes packets(int count) {
    Bytes all;
    for (int i = 0; i < count; ++i) all = all + packet();
    return all;
  }

  void restart() {
    time_ns = 300'000'000;
    lines = true;
    divisor = 0;
    sent = 0;
    pending_.clear();
  }

 private:
  Bytes obey(const std::string& command) {
    heard.push_back(command);
    if (!answers) return {};
    if (command == "VNWRG,06,0") {
      lines = false;
      return line(command);
    }
    if (command == "VNRRG,01") return line(command + "," + model);
    if (command == "VNRRG,03") return line(command + "," + serial);
    if (command == "VNRRG,04") return line(command + "," + firmware);
    if (command.starts_with("VNWRG,75,")) return configure(command);
    return line("VNERR,08");
  }

  Bytes configure(const std::string& command) {
    unsigned port = 0;
    unsigned groups = 0;
    int asked = 0;
    if (std::sscanf(command.c_str(), "VNWRG,75,%u,%d,%x,%x,%x", &port, &asked, &groups, &common, &imu) != 5) {
      return line("VNERR,05");
    }
    if (error_upon_output != 0) return line("VNERR," + std::to_string(error_upon_output));
    if (!knows_saturation && (imu & 0x800U) != 0) return line("VNERR,07");
    divisor = asked;
    return line(command);
  }

  std::string pending_;
};

}  // namespace soak::hal::imu::test
