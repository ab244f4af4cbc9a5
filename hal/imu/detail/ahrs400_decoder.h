// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/imu/detail/frame_decoder.h"

/// What a Crossbow AHRS400 sends: packets, and the time that their timers tell.
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
class Ahrs400Decoder : public FrameDecoder {
 public:
  [[nodiscard]] std::optional<Ahrs400Packet> next();
  /// As that of all decoders; behind it the search begins again.
  bool drop_partial();
  void clear();

 private:
  /// Moves to the next byte that may begin a packet.
  void search();
  [[nodiscard]] Ahrs400Packet take();

  bool in_step_ = false;
  bool after_loss_ = true;
};

/// The time of a Crossbow AHRS400, whose packets carry a timer of 16 bits that counts down and wraps about every 51.8
/// ms. Between neighbours the timer alone tells the step. Across a gap it does not tell how often it has wrapped: that
/// is found from the host's clock, in whole wraps, at the places where something was missing. The host's clock counts
/// only where all bytes were read (what waited in the kernel arrives late), and against the best it has seen lately, so
/// that neither a busy station nor the tolerance of the unit's crystal moves a stamp.
class Ahrs400Clock {
 public:
  using HostTime = std::chrono::steady_clock::time_point;

  static constexpr double kTick_s = 0.79e-6;
  static constexpr double kWrap_s = 65536 * kTick_s;

  struct Stamp {
    std::uint16_t timer = 0;
    bool after_loss = false;
  };

  /// Takes the stamps of the packets that arrived together at `now`, oldest first. `drained`: nothing more waits.
  /// Returns the steps in ticks, each from the packet before it; that of the very first packet is 0.
  [[nodiscard]] std::vector<std::uint64_t> take(std::span<const Stamp> stamps, HostTime now, bool drained);
  /// Something may be missing before the next packet.
  void interrupt() { gap_open_ = true; }
  /// Back to the state before the first packet.
  void clear() { *this = {}; }

 private:
  /// Where a gap may lie; nothing if nowhere.
  [[nodiscard]] std::optional<std::size_t> place_of_gap(std::span<const Stamp> stamps, double batch_s,
                                                        double silence_s) const;
  void follow_host(double offset_s, double elapsed_s);

  std::optional<std::uint16_t> timer_;
  std::optional<HostTime> began_;
  HostTime heard_{};
  std::uint64_t ticks_ = 0;
  double best_offset_s_ = 0.0;  ///< host minus unit when packets arrived with the least delay
  bool gap_open_ = false;
};

}  // namespace soak::hal::imu
