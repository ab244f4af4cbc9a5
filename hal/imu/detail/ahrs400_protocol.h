// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "hal/imu/detail/ahrs400_decoder.h"
#include "hal/imu/detail/protocol.h"
#include "hal/imu/imu.h"

namespace soak::hal::imu {

/// Crossbow AHRS400 in scaled mode: packets of 24 bytes whose timer tells the time modulo 51.8 ms (ahrs400_decoder.h),
/// commands of one byte. Begins to count the time with the first packet: the unit does not say when it was switched on.
///
/// - No answer has an end of its own: one is complete when the line has been quiet for 0.1 s.
/// - Before the dialogue it listens: a unit that streams has kept its power since it was told to, one that stands idle
/// has
///   lost it.
/// - The unit sends at a rate of its own, at most 70 packets a second and not evenly. Lost packets are counted by its
///   time, against the mean step.
/// - `clipped`: a number at full scale of its format; the unit has no flag.
class Ahrs400Protocol final : public Protocol {
 public:
  explicit Ahrs400Protocol(const Ahrs400Ranges& ranges) : ranges_(ranges) {}

  std::string name() const override { return "Crossbow AHRS400"; }
  base::Status check(const Imu::Settings& settings) const override;

  void append(std::span<const std::uint8_t> bytes, std::chrono::steady_clock::time_point now, bool drained) override;
  base::Result<std::optional<Heard>> next() override;
  bool drop_partial() override;
  void clear() override;
  std::uint64_t garbage_bytes() const override { return decoder_.garbage_bytes() + passed_over_; }

  void begin(const Imu::Settings& settings) override;
  bool done() const override { return step_ == Step::done; }
  base::Bytes request() override;
  std::string_view request_name() const override;
  base::Result<bool> end_answer(std::chrono::steady_clock::duration quiet) override;
  base::Bytes start_command() const override;
  base::Bytes wake_up_answer() const override { return {}; }
  const ImuIdentity& identity() const override { return identity_; }
  bool found_idle() const override { return found_idle_; }
  void assume_done(const Imu::Settings& settings) override;

  const UnitPacket& packet() const override { return packet_; }
  bool advance() override;
  bool clock_empty() const override { return !has_time_; }
  double time_s() const override { return Ahrs400Clock::kTick_s * static_cast<double>(ticks_); }
  std::uint32_t lost_packets() const override { return lost_packets_; }
  void restart_clock() override;
  void interrupt() override {
    clock_.interrupt();
    interrupted_ = true;
  }

  std::chrono::steady_clock::duration silence_limit() const override;
  bool temp_with_every_packet() const override { return true; }

 private:
  enum class Step : std::uint8_t { listen, ping, serial, version, scaled, done };
  struct Dated {
    Ahrs400Packet packet;
    std::uint64_t step = 0;  ///< ticks since the one before it
  };

  void decode(std::chrono::steady_clock::time_point now, bool drained);
  /// Judges what has come since the request; false if it is no answer to it.
  bool take_answer();
  bool take_serial();
  void count_loss();
  void fill_packet(const Ahrs400Packet& packet);

  Ahrs400Ranges ranges_;
  Step step_ = Step::done;
  bool told_to_stream_ = false;
  bool found_idle_ = false;
  bool heard_stream_ = false;  ///< while listening
  base::Bytes answer_;
  ImuIdentity identity_;

  Ahrs400Decoder decoder_;
  Ahrs400Clock clock_;
  std::deque<Dated> packets_;
  Dated current_;
  UnitPacket packet_;
  std::uint64_t passed_over_ = 0;  ///< bytes while nobody listened to the stream
  std::uint64_t ticks_ = 0;
  bool has_time_ = false;
  bool interrupted_ = false;  ///< the station itself did not listen before the next packet: none of that time is lost
  double mean_step_ = 0.0;    ///< ticks, of steps without a loss; 0 = not known
  std::uint32_t lost_packets_ = 0;
};

}  // namespace soak::hal::imu
