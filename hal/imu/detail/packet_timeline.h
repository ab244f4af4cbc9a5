// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

namespace soak::hal::imu {

/// What a unit writes on each packet.
struct PacketStamp {
  std::uint16_t counter = 0;    ///< +1 per packet
  std::uint32_t time_fine = 0;  ///< ticks of 0.1 ms since power-on
};

/// Follows the stamps of a stream: unwraps the time, counts lost packets, notices that the unit has begun anew.
class PacketTimeline {
 public:
  /// Moves on to the next packet. False, and nothing is changed, if the stamp cannot follow the last one: the time runs
  /// backwards (a wrap at 2³² ticks is none), or the counter has advanced by far more than the time allows.
  [[nodiscard]] bool advance(const PacketStamp& stamp);
  /// The next packet is the first one after a power-on.
  void begin_anew();
  /// The next packet follows an interruption that the station itself has made: its counter may have any value. From
  /// there on the unit is to send `rate_hz` packets per second.
  void interrupt(double rate_hz);
  /// No packet yet since power-on.
  [[nodiscard]] bool empty() const { return !last_; }

  /// Of the last packet, since power-on.
  [[nodiscard]] double time_s() const;
  /// Packets missing between the last two, by the counter (modulo 65536).
  [[nodiscard]] std::uint32_t lost_packets() const { return lost_packets_; }

 private:
  double rate_hz_ = 0.0;
  std::optional<PacketStamp> last_;
  bool counter_known_ = false;
  std::uint64_t ticks_ = 0;
  std::uint32_t lost_packets_ = 0;
};

}  // namespace soak::hal::imu
