// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "hal/imu/detail/protocol.h"
#include "hal/imu/detail/vectornav_frame.h"

namespace soak::hal::imu {

/// VectorNav VN-100, VN-200, VN-300 and kin on their serial port 1: binary output 1 with the time since startup,
/// acceleration, rate of turn, temperature and, where the firmware has them, saturation flags; registers are read and
/// written in lines. Nothing is stored in the unit: after a power-on it sends what it was delivered with, and an
/// asynchronous line behind the dialogue, which has turned those off, proves a restart.
///
/// The unit counts no packets: those lost are told by its time.
class VectorNavProtocol final : public Protocol {
 public:
  std::string name() const override { return "VectorNav"; }
  base::Status check(const Imu::Settings& settings) const override;

  void append(std::span<const std::uint8_t> bytes, std::chrono::steady_clock::time_point now, bool drained) override;
  base::Result<std::optional<Heard>> next() override;
  bool drop_partial() override { return decoder_.drop_partial(); }
  void clear() override { decoder_.clear(); }
  std::uint64_t garbage_bytes() const override { return decoder_.garbage_bytes(); }

  void begin(const Imu::Settings& settings) override;
  bool done() const override { return step_ == Step::done; }
  base::Bytes request() override;
  std::string_view request_name() const override;
  base::Result<bool> end_answer(std::chrono::steady_clock::duration) override { return false; }
  base::Bytes start_command() const override { return {}; }
  base::Bytes wake_up_answer() const override { return {}; }
  const ImuIdentity& identity() const override { return identity_; }
  bool found_idle() const override { return false; }
  void assume_done(const Imu::Settings& settings) override;

  const UnitPacket& packet() const override { return packet_; }
  bool advance() override;
  bool clock_empty() const override { return !last_ns_; }
  double time_s() const override { return 1e-9 * static_cast<double>(last_ns_.value_or(0)); }
  std::uint32_t lost_packets() const override { return lost_packets_; }
  void restart_clock() override;
  void interrupt() override { interrupted_ = true; }

  std::chrono::steady_clock::duration silence_limit() const override;
  bool temp_with_every_packet() const override { return true; }

 private:
  enum class Step : std::uint8_t { lines_off, model, serial, firmware, output, done };

  base::Result<Heard> take_text(std::string_view text);
  base::Result<Heard> take_error(std::string_view text);
  base::Result<Heard> take_answer(std::string_view value);
  Heard take_binary(const VectorNavMessage& message);
  [[nodiscard]] base::Status check_rate() const;
  /// Of the unit's own rate, which the model tells, to the one asked for.
  [[nodiscard]] int divisor() const;

  VectorNavDecoder decoder_;
  Imu::Settings settings_;
  Step step_ = Step::lines_off;
  bool listening_only_ = false;
  VectorNavFields asked_;
  ImuIdentity identity_;
  UnitPacket packet_;
  std::uint64_t packet_ns_ = 0;
  std::optional<std::uint64_t> last_ns_;
  bool interrupted_ = true;
  std::uint32_t lost_packets_ = 0;
};

}  // namespace soak::hal::imu
