// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/signal/allan/allan_stream.h"
#include "calib/vocabulary/sensor.h"
#include "hal/imu/imu.h"

namespace soak::station {

/// Overlapping Allan deviations at one averaging time, in printed units (deg/s, m/s²). They are given from 30
/// differences on that do not overlap (half a minute of recording at 1 s): white noise is then known to 10 %.
struct NoiseFigures {
  double tau_s = 1.0;  ///< the averaging time there is that is nearest to 1 s
  std::optional<std::array<double, 3>> gyro_dps;
  std::optional<std::array<double, 3>> accel_mps2;
};

/// Allan deviations of one unit at rest, while its run goes on: from the samples of all recordings of the present run,
/// at whatever temperature and in whatever position, rejected ones included. No difference reaches from one recording
/// to the next or across more than calib::signal::PhaseRecord::kBridge missing samples; shorter gaps are bridged.
///
/// A deviation of the document is given where at least 30 differences stand behind it, and at least as many as the
/// averaging time has samples: with fewer they overlap so much that they are hardly more than one. A single recording
/// thus carries averaging times up to a third of its length.
///
/// One thread, the engine's, feeds it and reads figures(); document() may come from any, and takes some milliseconds.
class NoiseWatch {
 public:
  /// `rate_hz`: what the unit was asked to send, finite and positive.
  explicit NoiseWatch(double rate_hz);

  /// Forgets everything: another power-on is another noise.
  void begin_run();
  /// The samples that follow do not go on where the last ones ended.
  void begin_recording();
  /// Samples of a recording, oldest first. What their device time leaves out is missing: the unit's counter says less,
  /// it also counts packets that never held a sample. A reading that is not finite is missing as well.
  void add(std::span<const hal::ImuSample> samples);

  /// Brings figures() up to date, every two seconds of host time at most: it costs as much as ten thousand samples.
  void refresh(std::chrono::steady_clock::time_point host_now);
  [[nodiscard]] const NoiseFigures& figures() const { return figures_; }

  /// docs/http-api.md: the document of GET /api/v1/noise.
  [[nodiscard]] nlohmann::json document(const std::string& serial) const;

 private:
  using Streams = std::vector<calib::signal::AllanStream>;  ///< in the order of calib::kSensors

  [[nodiscard]] std::size_t missing_before(const hal::ImuSample& sample) const;

  double rate_hz_;
  mutable std::mutex mutex_;  ///< guards streams_ and samples_
  Streams streams_;
  std::size_t samples_ = 0;
  std::optional<double> last_s_;  ///< device time of the last sample of this recording
  std::vector<double> readings_;  ///< of one sensor, missing ones as NaN
  NoiseFigures figures_;
  bool figures_are_old_ = false;
  std::chrono::steady_clock::time_point next_refresh_{};
};

}  // namespace soak::station
