// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/judge/stability.h"
#include "calib/vocabulary/position.h"
#include "calib/vocabulary/unit_type.h"
#include "hal/imu/imu.h"
#include "station/config/station_config.h"
#include "station/lab/noise_watch.h"
#include "station/lab/position_watch.h"
#include "station/lab/segment_capture.h"

namespace soak::station {

/// Process time, in seconds since soakd started: it follows the units' device time while any unit streams,
/// else the host's clock times `clock.rate`. Dwell, time-outs of the process and polling count it; link time-outs never
/// do.
class ProcessTime {
 public:
  explicit ProcessTime(double clock_rate) : rate_(clock_rate) {}

  [[nodiscard]] double now_s() const { return now_s_; }

  /// Moves on. `furthest_s`: the clock of the streaming unit that is furthest ahead (UnitClock); absent where no unit
  /// streams.
  void advance(std::chrono::steady_clock::time_point host_now, const std::optional<double>& furthest_s) {
    const std::chrono::duration<double> host_advance =
        started_ ? host_now - host_last_ : std::chrono::duration<double>{0};
    now_s_ = furthest_s ? std::max(now_s_, *furthest_s) : now_s_ + host_advance.count() * rate_;
    host_last_ = host_now;
    started_ = true;
  }

 private:
  double rate_;
  double now_s_ = 0.0;
  bool started_ = false;
  std::chrono::steady_clock::time_point host_last_;
};

/// Where one unit's clock is on process time. Units reach us one by one: each is followed by itself, or ten of
/// them would make time go ten times too fast.
class UnitClock {
 public:
  /// The unit's clock went on by `advance_s`; `restarted`: it restarted. The first time it is put at `now_s`.
  double follow(double now_s, bool restarted, double advance_s) {
    if (restarted || !at_s_) at_s_ = now_s;
    return *at_s_ += advance_s;
  }
  /// The unit does not stream: its clock is unknown until it does again.
  void lose() { at_s_.reset(); }

 private:
  std::optional<double> at_s_;
};

/// "MTi-300, firmware 1.8.2", as far as the unit tells it.
[[nodiscard]] std::string product_text(const hal::ImuIdentity& identity);

/// One unit of the campaign: its stream, what its thermometer and its inertial sensors show, and its part of the
/// segment that is being recorded.
class UnitChannel {
 public:
  /// `settings`: what the unit is asked to send.
  UnitChannel(Slot slot, std::string serial, calib::UnitType type, std::unique_ptr<hal::Imu> imu,
              const hal::Imu::Settings& settings);

  /// Receives what has arrived, opens the transport again where it broke (1 s of host time between tries). Never fails:
  /// trouble() says what is wrong.
  void poll();
  /// Closes the transport for good.
  void close();
  /// Samples of the last poll(), oldest first.
  [[nodiscard]] std::span<const hal::ImuSample> fresh() const { return fresh_; }
  /// How far the unit's clock went in the last poll(), since its restart where there was one.
  [[nodiscard]] double advance_s() const { return advance_s_; }
  /// Whether the clock restarted in the last poll().
  [[nodiscard]] bool clock_restarted() const { return clock_restarted_; }

  [[nodiscard]] const Slot& slot() const { return slot_; }
  [[nodiscard]] const std::string& serial() const { return serial_; }
  [[nodiscard]] const calib::UnitType& type() const { return type_; }
  [[nodiscard]] const hal::Imu& imu() const { return *imu_; }
  [[nodiscard]] bool streaming() const { return imu_->state() == hal::ImuState::streaming; }
  [[nodiscard]] bool simulated() const { return imu_->identity() && imu_->identity()->simulated; }
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  [[nodiscard]] const std::optional<hal::ImuSample>& latest() const { return latest_; }
  /// The last credible temperature; nothing once it is older than a minute.
  [[nodiscard]] const std::optional<double>& temp_c() const { return temp_c_; }
  [[nodiscard]] int wait_fd() const { return imu_->wait_fd(); }

  /// The unit takes part in the present run: it is waited for and recorded.
  [[nodiscard]] bool active() const { return active_; }
  void begin_run() {
    active_ = true;
    dropped_.clear();
  }
  /// It has no part in the present run any more, or gets none, for this reason; the next run tries it again.
  void drop(std::string why) {
    active_ = false;
    dropped_ = std::move(why);
  }
  /// Why it was dropped from the present run, or the last one; empty where it was not.
  [[nodiscard]] const std::string& dropped() const { return dropped_; }
  /// For how long (host time) an active unit has not streamed.
  [[nodiscard]] double silent_s() const;

  /// Power-ons that were noticed; a change in mid-run means that the unit restarted.
  [[nodiscard]] std::uint32_t power_on() const { return power_on_; }
  /// Device time of the first sample since the last power-on.
  [[nodiscard]] const std::optional<double>& first_sample_s() const { return first_sample_s_; }
  /// When the host heard it.
  [[nodiscard]] std::chrono::steady_clock::time_point first_heard() const { return first_heard_; }

  void judge_by(const calib::StabilityCriterion& criterion);
  void disturb() { judge_.disturb(); }
  void disturb(double min_window_s) { judge_.disturb(min_window_s); }
  [[nodiscard]] calib::StabilityVerdict stability() const { return judge_.verdict(); }

  /// The fixture stands (or shall stand) with `fixture_up` upwards.
  void expect_position(const std::string& fixture_up);
  [[nodiscard]] const calib::Position& position() const { return position_; }
  [[nodiscard]] const AttitudeWatch& attitude() const { return attitude_; }
  /// The fixture turns (or shall turn) at this rate in that position.
  void expect_rate(double rate_dps) { rate_.expect(position_, rate_dps); }
  [[nodiscard]] const RateWatch& rate() const { return rate_; }

  std::optional<SegmentCapture> capture;  ///< while a segment is recorded
  std::size_t recorder_index = 0;         ///< in the open run file
  UnitClock clock;
  const std::shared_ptr<NoiseWatch> noise;  ///< shared with those who ask from other threads

 private:
  void reopen();
  void take(const hal::ImuSample& sample);

  Slot slot_;
  std::string serial_;
  calib::UnitType type_;
  std::unique_ptr<hal::Imu> imu_;
  hal::Imu::Settings settings_;
  std::vector<hal::ImuSample> fresh_;
  double advance_s_ = 0.0;
  bool clock_restarted_ = false;
  std::string trouble_;
  std::chrono::steady_clock::time_point next_open_{};
  std::chrono::steady_clock::time_point streamed_{};
  std::optional<hal::ImuSample> latest_;
  std::optional<double> temp_c_;
  double temp_s_ = 0.0;  ///< device time of it
  std::uint32_t power_on_ = 0;
  std::optional<double> first_sample_s_;
  std::chrono::steady_clock::time_point first_heard_{};
  bool active_ = false;
  std::string dropped_;
  bool closed_ = false;
  calib::StabilityJudge judge_;
  AttitudeWatch attitude_;
  RateWatch rate_;
  calib::Position position_;
};

}  // namespace soak::station
