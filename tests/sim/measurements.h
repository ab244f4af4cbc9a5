// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include "hal/sim/electronics/detail/xbus_device.h"

namespace soak::hal::sim::test {

/// All messages in a sequence of bytes.
inline std::vector<XbusMessage> messages_in(const base::Bytes& bytes) {
  XbusParser parser;
  parser.feed(bytes);
  std::vector<XbusMessage> messages;
  while (auto message = parser.next()) messages.push_back(*message);
  return messages;
}

/// What an MTData2 message holds.
struct Measurement {
  int counter = -1;
  std::int64_t time_100us = -1;
  std::optional<std::array<double, 3>> accel_mps2;
  std::optional<std::array<double, 3>> gyro_rps;
  std::optional<double> temp_c;
  std::optional<std::uint32_t> status;
};

inline std::uint32_t big_endian(std::span<const std::uint8_t> bytes) {
  std::uint32_t value = 0;
  for (const std::uint8_t byte : bytes) value = value << 8 | byte;
  return value;
}

inline double float_at(std::span<const std::uint8_t> bytes) {
  const std::uint32_t raw = big_endian(bytes.first(4));
  float value = 0.0F;
  std::memcpy(&value, &raw, sizeof value);
  return static_cast<double>(value);
}

inline Measurement measurement_of(const XbusMessage& message) {
  Measurement measurement;
  const std::span<const std::uint8_t> data(message.data);
  for (std::size_t at = 0; at + 3 <= data.size(); at += 3U + data[at + 2]) {
    const auto value = data.subspan(at + 3, data[at + 2]);
    switch (big_endian(data.subspan(at, 2))) {
      case 0x1020:
        measurement.counter = static_cast<int>(big_endian(value));
        break;
      case 0x1060:
        measurement.time_100us = big_endian(value);
        break;
      case 0x4020:
        measurement.accel_mps2 = {float_at(value), float_at(value.subspan(4)), float_at(value.subspan(8))};
        break;
      case 0x8020:
        measurement.gyro_rps = {float_at(value), float_at(value.subspan(4)), float_at(value.subspan(8))};
        break;
      case 0x0810:
        measurement.temp_c = float_at(value);
        break;
      case 0xE020:
        measurement.status = big_endian(value);
        break;
      default:
        break;
    }
  }
  return measurement;
}

/// The MTData2 messages among all in a sequence of bytes.
inline std::vector<Measurement> measurements_in(const base::Bytes& bytes) {
  std::vector<Measurement> measurements;
  for (const XbusMessage& message : messages_in(bytes)) {
    if (message.id == 0x36) measurements.push_back(measurement_of(message));
  }
  return measurements;
}

}  // namespace soak::hal::sim::test
