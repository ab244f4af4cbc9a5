// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "base/bytes.h"

namespace soak::hal::imu {

inline constexpr std::size_t kAhrs400PacketSize = 24;

/// Numbers of one packet in scaled mode, as sent.
struct Ahrs400Packet {
  std::array<std::int16_t, 3> rate{};
  std::array<std::int16_t, 3> accel{};
  std::uint16_t temp = 0;   ///< of the thermometer's converter, 12 bits of 5 V
  std::uint16_t timer = 0;  ///< counts down, 0.79 µs per step
  bool after_loss = false;  ///< something was missing or damaged before it
};

/// A number of a sensor at full scale of its format: it was at its rail.
[[nodiscard]] constexpr bool at_rail(std::int16_t number) { return number == 32767 || number <= -32767; }

/// °C that `number` stands for (AHRS400 manual: (V − 1.375)·44.44 with 5 V in 4096 steps).
[[nodiscard]] constexpr float ahrs400_temp_c(std::uint16_t number) {
  return static_cast<float>((number * 5.0 / 4096.0 - 1.375) * 44.44);
}

/// SI or degrees that `number` stands for, of a sensor with nominal range `range`: the format reaches to one and a half
/// times that.
[[nodiscard]] constexpr double ahrs400_scaled(std::int16_t number, double range) {
  return number * range * 1.5 / 32768.0;
}

/// Finds the packets of a Crossbow AHRS400 in scaled mode in a stream that may be split and damaged anywhere: header
/// FF, 22 bytes of big-endian numbers, their sum modulo 256. FF also occurs inside packets and the sum holds by chance
/// once in 256, so a packet counts only if another header follows where one should (as soon as that byte is there), and
/// after a loss only two good packets in a row end the search. Keeps at most two packets besides what the last append()
/// brought.
class Ahrs400Decoder {
 public:
  /// Takes bytes. next() is to be called until it has no more before the next append().
  void append(std::span<const std::uint8_t> bytes);
  [[nodiscard]] std::optional<Ahrs400Packet> next();
  /// Gives up what is pending byte by byte; next() may then find packets behind it. False if nothing was pending.
  bool drop_partial();
  void clear();

  [[nodiscard]] std::uint64_t garbage_bytes() const { return garbage_bytes_; }
  [[nodiscard]] std::size_t pending_bytes() const { return buffer_.size() - begin_; }

 private:
  [[nodiscard]] std::span<const std::uint8_t> pending() const { return std::span(buffer_).subspan(begin_); }
  /// Moves to the next byte that may begin a packet.
  void search();
  void skip_garbage(std::size_t count);
  [[nodiscard]] Ahrs400Packet take();

  base::Bytes buffer_;
  std::size_t begin_ = 0;  ///< of what is not yet decoded
  std::uint64_t garbage_bytes_ = 0;
  bool in_step_ = false;
  bool after_loss_ = true;
};

}  // namespace soak::hal::imu
