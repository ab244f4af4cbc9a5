// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "hal/imu.h"
#include "hal/imu/byte_source.h"
#include "hal/imu/mt_data2.h"
#include "hal/imu/packet_timeline.h"
#include "hal/imu/xbus.h"
#include "hal/imu/xsens_setup.h"

namespace soak::hal::imu {

/// A unit of the Xsens MTi family. Device times come from the unit alone; the host's clock serves time-outs only. They
/// pass inside poll(), so poll() is to be called a few times a second also while wait_fd() stays quiet.
///
/// - Until the unit answers it is asked once a second, for as long as it takes. If it sends bytes but does not answer a
///   request within 1 s, it is asked again from the first request on; after the third repetition the device has failed.
/// - A stream without a message for 3 s is `silent` and goes on by itself. After 30 s the unit is asked again.
/// - A stream of messages that carries no sample for 3 s obeys another configuration: the unit is configured again. If
///   it has just been, the device has failed.
/// - A restart is a wake-up message of a unit that was heard before, a time or counter that begins anew, or another
///   serial number. The samples before it keep their number; what comes from then on until the unit is configured again
///   is dropped.
/// - Statistics and the count of power-ons live as long as the object, through close() and open().
class XsensImu final : public Imu {
 public:
  using Clock = std::chrono::steady_clock;

  explicit XsensImu(std::unique_ptr<ByteSource> source, std::function<Clock::time_point()> clock = Clock::now);

  base::Status open(const Settings& settings) override;
  void close() override;
  base::Status poll(std::vector<ImuSample>& samples) override;
  ImuState state() const override { return state_; }
  const std::optional<ImuIdentity>& identity() const override { return identity_; }
  const ImuStatistics& statistics() const override { return statistics_; }
  int wait_fd() const override { return source_->fd(); }
  std::string description() const override { return "Xsens MTi at " + source_->description(); }

 private:
  base::Status move_on(std::vector<ImuSample>& samples);
  base::Result<bool> receive(std::vector<ImuSample>& samples);
  base::Status send();
  void queue(const base::Bytes& message);

  base::Status take_messages(std::vector<ImuSample>& samples);
  base::Status take_message(const XbusMessage& message, std::vector<ImuSample>& samples);
  base::Status take_answer(const XbusMessage& message);
  void take_wake_up();
  void take_packet(const XbusMessage& message, std::vector<ImuSample>& samples);
  bool follow(const PacketStamp& stamp);
  void append_sample(const MtData2& packet, std::vector<ImuSample>& samples);

  base::Status watch_time(std::vector<ImuSample>& samples);
  base::Status watch_setup();
  base::Status watch_stream();

  void begin_setup();
  void ask();
  void finish_setup();
  void notice_restart();

  std::unique_ptr<ByteSource> source_;
  std::function<Clock::time_point()> clock_;
  Settings settings_;
  ImuState state_ = ImuState::closed;
  base::Error failure_;  ///< why, in state `failed`

  XbusDecoder decoder_;
  XsensSetup setup_;
  PacketTimeline timeline_;
  base::Bytes outbox_;

  Clock::time_point now_;           ///< of the current poll
  Clock::time_point deadline_;      ///< for the answer to the current request
  Clock::time_point last_bytes_;    ///< when any came
  Clock::time_point last_message_;  ///< when a valid one came
  Clock::time_point last_sample_;   ///< when one came, or when messages came again after a silence
  int attempts_ = 0;                ///< dialogues in which the unit was heard but did not answer
  bool heard_ = false;              ///< bytes came since the dialogue began
  bool unit_known_ = false;         ///< some message of this or an earlier power-on was received
  bool first_packet_ = false;       ///< none came yet since the dialogue ended
  bool sampled_ = false;            ///< a sample came since the dialogue ended

  std::uint32_t power_on_ = 0;
  std::uint64_t malformed_bytes_ = 0;  ///< in valid frames
  std::optional<float> pending_temp_c_;
  std::optional<ImuIdentity> identity_;
  ImuStatistics statistics_;
};

}  // namespace soak::hal::imu
