// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/bytes.h"
#include "base/result.h"
#include "hal/imu/detail/protocol.h"
#include "hal/imu/detail/xsens_frames.h"

namespace soak::hal::imu {

/// What a unit writes on each packet.
struct PacketStamp {
  std::uint16_t counter = 0;    ///< +1 per packet
  std::uint32_t time_fine = 0;  ///< ticks of 0.1 ms since power-on
};

/// Follows the stamps of a stream: unwraps the time, counts lost packets, notices that the unit has restarted.
class PacketTimeline {
 public:
  /// Moves on to the next packet. False, and nothing is changed, if the stamp cannot follow the last one: the time runs
  /// backwards (a wrap at 2³² ticks is none), or the counter has advanced by far more than the time allows.
  [[nodiscard]] bool advance(const PacketStamp& stamp);
  /// The next packet is the first one after a power-on.
  void restart_clock();
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

/// Fails (bad_input) unless a unit can be asked for these rates: whole numbers of Hz, 1 to 2000.
[[nodiscard]] base::Status check_rates(const Imu::Settings& settings);

/// The dialogue that makes a unit stream: into configuration, who are you, what to send, into measurement. It only
/// composes requests and judges answers; sending, waiting and repeating are the caller's.
class XsensSetup {
 public:
  explicit XsensSetup(const Imu::Settings& settings) : settings_(settings) {}

  /// Back to the first request.
  void begin();
  [[nodiscard]] bool done() const;
  /// The message to send now. Not after done().
  [[nodiscard]] base::Bytes request() const;
  /// What the current request is, for messages to the user.
  [[nodiscard]] std::string_view request_name() const;
  /// Moves on if `message` is the answer that is waited for; any other is ignored. Returns whether it was. Error
  /// `device` if the answer is malformed or offers another rate (by more than 1 %) than was asked for.
  [[nodiscard]] base::Result<bool> take(const XbusMessage& message);
  /// Complete once done().
  [[nodiscard]] const ImuIdentity& identity() const { return identity_; }

 private:
  [[nodiscard]] base::Status take_answer(Mid request, std::span<const std::uint8_t> data);
  [[nodiscard]] base::Status check_offer(std::span<const std::uint8_t> data) const;

  Imu::Settings settings_;
  std::size_t step_ = 0;
  ImuIdentity identity_;
};

/// Xsens MTi: Xbus frames (xsens_frames.h), MTData2 packets with a counter and a time since power-on, the dialogue
/// of XsensSetup. A unit that starts sends a wake-up message and waits.
class XsensProtocol final : public Protocol {
 public:
  std::string name() const override { return "Xsens MTi"; }
  base::Status check(const Imu::Settings& settings) const override { return check_rates(settings); }

  void append(std::span<const std::uint8_t> bytes, std::chrono::steady_clock::time_point now, bool drained) override;
  base::Result<std::optional<Heard>> next() override;
  bool drop_partial() override { return decoder_.drop_partial(); }
  void clear() override { decoder_.clear(); }
  std::uint64_t garbage_bytes() const override { return decoder_.garbage_bytes() + malformed_bytes_; }

  void begin(const Imu::Settings& settings) override;
  bool done() const override { return listening_only_ || setup_.done(); }
  base::Bytes request() override { return setup_.request(); }
  std::string_view request_name() const override { return setup_.request_name(); }
  base::Result<bool> end_answer(std::chrono::steady_clock::duration) override { return false; }
  base::Bytes start_command() const override { return {}; }
  base::Bytes wake_up_answer() const override { return encode_xbus(Mid::wake_up_ack); }
  const ImuIdentity& identity() const override { return setup_.identity(); }
  bool found_idle() const override { return false; }
  void assume_done(const Imu::Settings& settings) override;

  const UnitPacket& packet() const override { return packet_; }
  bool advance() override { return timeline_.advance(stamp_); }
  bool clock_empty() const override { return timeline_.empty(); }
  double time_s() const override { return timeline_.time_s(); }
  std::uint32_t lost_packets() const override { return timeline_.lost_packets(); }
  void restart_clock() override { timeline_.restart_clock(); }
  void interrupt() override { timeline_.interrupt(rate_hz_); }

  std::chrono::steady_clock::duration silence_limit() const override;
  bool temp_with_every_packet() const override { return false; }

 private:
  base::Result<Heard> take(const XbusMessage& message);
  Heard take_packet(const XbusMessage& message);

  XbusDecoder decoder_;
  XsensSetup setup_{Imu::Settings{}};
  double rate_hz_ = 0.0;
  bool listening_only_ = false;
  PacketTimeline timeline_;
  UnitPacket packet_;
  PacketStamp stamp_;
  std::uint64_t malformed_bytes_ = 0;  ///< in valid frames
};

}  // namespace soak::hal::imu
