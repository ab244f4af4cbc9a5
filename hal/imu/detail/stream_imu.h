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
#include "hal/imu/detail/protocol.h"
#include "hal/imu/imu.h"
#include "hal/links/detail/byte_source.h"

namespace soak::hal::imu {

/// A unit that speaks `protocol` over `source`, whichever these are. The host's clock serves time-outs only (and a
/// protocol whose own clock is ambiguous across gaps). They pass inside poll(), so poll() is to be called a few times a
/// second also while wait_fd() stays quiet.
///
/// - Until the unit answers it is asked once a second, for as long as it takes. If it sends bytes but does not answer a
///   request within 1 s, it is asked again from the first request on; after the third repetition the device has failed.
/// - A stream without a message for 3 s is `silent` and goes on by itself. When the protocol's patience is over (30 s
/// for
///   an Xsens MTi) the unit is asked again.
/// - A stream of messages that carries no sample for 3 s obeys another configuration: the unit is configured again. If
///   it has just been, the device has failed.
/// - The times of the samples of one power-on rise: a packet whose stamp is that of the sample before (sent twice) is
///   passed over.
/// - A restart is a wake-up message of a unit that was heard before, a time or counter that starts again, another
///   serial number, or a unit that stands idle though it was told to stream. The samples before it keep their number;
///   what comes from then on until the unit is configured again is dropped.
/// - A source that cannot answer (a recording) is not asked: its stream is taken as it is, without an identity.
/// - Statistics and the count of power-ons live as long as the object, through close() and open().
class StreamImu final : public Imu {
 public:
  using Clock = std::chrono::steady_clock;

  StreamImu(std::unique_ptr<ByteSource> source, std::unique_ptr<Protocol> protocol,
            std::function<Clock::time_point()> clock = Clock::now);

  base::Status open(const Settings& settings) override;
  void close() override;
  base::Status poll(std::vector<ImuSample>& samples) override;
  ImuState state() const override { return state_; }
  const std::optional<ImuIdentity>& identity() const override { return identity_; }
  const ImuStatistics& statistics() const override { return statistics_; }
  int wait_fd() const override { return source_->fd(); }
  std::string description() const override { return protocol_->name() + " at " + source_->description(); }

 private:
  base::Status move_on(std::vector<ImuSample>& samples);
  base::Result<bool> receive(std::vector<ImuSample>& samples);
  base::Status send();
  void queue(const base::Bytes& message);

  base::Status take_messages(std::vector<ImuSample>& samples);
  void take_message(Protocol::Heard message, std::vector<ImuSample>& samples);
  void move_dialogue_on();
  void take_wake_up();
  void take_packet(std::vector<ImuSample>& samples);
  bool follow();
  void append_sample(const UnitPacket& packet, std::vector<ImuSample>& samples);
  void take_temperature(const UnitPacket& packet);

  base::Status watch_time(std::vector<ImuSample>& samples);
  base::Status watch_setup();
  base::Status watch_stream();

  void begin_setup();
  void ask();
  void finish_setup();
  void notice_restart();

  std::unique_ptr<ByteSource> source_;
  std::unique_ptr<Protocol> protocol_;
  std::function<Clock::time_point()> clock_;
  Settings settings_;
  ImuState state_ = ImuState::closed;
  base::Error failure_;  ///< why, in state `failed`

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
  std::optional<float> pending_temp_c_;
  std::uint32_t pending_lost_ = 0;  ///< packets lost since the last sample
  std::optional<double> sample_s_;  ///< device time of the last sample since power-on
  double next_temp_s_ = 0.0;        ///< device time before which readings of the thermometer are passed over
  std::optional<ImuIdentity> identity_;
  ImuStatistics statistics_;
};

}  // namespace soak::hal::imu
