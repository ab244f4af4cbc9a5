// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

#include "hal/sim/lab/register_table.h"

namespace soak::hal::sim::test {

/// One register; -1 where it cannot be read.
inline int number_at(const RegisterTable& registers, int address) {
  std::array<std::uint16_t, 1> word{};
  return registers.read(address, word) == ModbusAnswer::done ? word[0] : -1;
}

/// The float32 at `address`, low word first.
inline double value_at(const RegisterTable& registers, int address) {
  std::array<std::uint16_t, 2> words{};
  if (registers.read(address, words) != ModbusAnswer::done) return -1e9;
  const std::uint32_t raw = static_cast<std::uint32_t>(words[1]) << 16 | words[0];
  float value = 0.0F;
  std::memcpy(&value, &raw, sizeof value);
  return static_cast<double>(value);
}

inline ModbusAnswer write_number(RegisterTable& registers, int address, std::uint16_t number) {
  return registers.write(address, std::array{number});
}

inline ModbusAnswer write_value(RegisterTable& registers, int address, float value) {
  std::uint32_t raw = 0;
  std::memcpy(&raw, &value, sizeof raw);
  return registers.write(address,
                         std::array{static_cast<std::uint16_t>(raw & 0xFFFF), static_cast<std::uint16_t>(raw >> 16)});
}

}  // namespace soak::hal::sim::test
