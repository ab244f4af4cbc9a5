// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "hal/imu/detail/mt_data2.h"
#include "hal/imu/detail/packet_timeline.h"
#include "hal/imu/detail/protocol.h"
#include "hal/imu/detail/xbus.h"
#include "hal/imu/detail/xsens_setup.h"

namespace soak::hal::imu {

/// Xsens MTi: Xbus frames (xbus.h), MTData2 packets (mt_data2.h) with a counter and a time since power-on, the dialogue
/// of xsens_setup.h. A unit that starts sends a wake-up message and waits.
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
  base::Result<bool> take_quiet(std::chrono::steady_clock::duration) override { return false; }
  base::Bytes last_word() const override { return {}; }
  base::Bytes wake_up_answer() const override { return encode_xbus(Mid::wake_up_ack); }
  const ImuIdentity& identity() const override { return setup_.identity(); }
  bool found_idle() const override { return false; }
  void assume_done(const Imu::Settings& settings) override;

  const UnitPacket& packet() const override { return packet_; }
  bool advance() override { return timeline_.advance(stamp_); }
  bool clock_empty() const override { return timeline_.empty(); }
  double time_s() const override { return timeline_.time_s(); }
  std::uint32_t lost_packets() const override { return timeline_.lost_packets(); }
  void begin_anew() override { timeline_.begin_anew(); }
  void interrupt() override { timeline_.interrupt(rate_hz_); }

  std::chrono::steady_clock::duration patience() const override;
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
