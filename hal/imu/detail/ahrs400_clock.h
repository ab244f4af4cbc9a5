// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace soak::hal::imu {

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
  /// Begins anew.
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
