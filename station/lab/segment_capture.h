// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "calib/vocabulary/sensor.h"
#include "calib/vocabulary/unit_type.h"
#include "hal/imu/imu.h"

namespace soak::station {

/// What sensor number `sensor` (calib::index_of) reads in the sample: rad/s or m/s².
inline double reading_of(const hal::ImuSample& sample, std::size_t sensor) {
  return sensor < 3 ? static_cast<double>(sample.rate_rps[sensor]) : static_cast<double>(sample.accel_mps2[sensor - 3]);
}

/// Mean and standard deviation of single samples.
struct SampleSpread {
  double mean = 0.0;
  double sigma = 0.0;
};

/// What one unit contributes to the segment that is being recorded: decides sample by sample whether it belongs to it,
/// by the unit's own device time, and keeps what must be known of it at once. The statistics of the catalog are made
/// later, from the sealed file.
class SegmentCapture {
 public:
  explicit SegmentCapture(double seconds) : seconds_(seconds) {}

  /// Whether the sample belongs to the segment. The very first sample never does: a row of phase ramp stays between two
  /// segments.
  [[nodiscard]] bool takes(const hal::ImuSample& sample);
  [[nodiscard]] bool complete() const { return complete_; }
  /// Samples were missing for more than 5 s of device time: the segment ended there.
  [[nodiscard]] bool broken() const { return broken_; }
  [[nodiscard]] std::size_t samples() const { return samples_; }
  /// Change of the unit's temperature over the segment: least-squares slope times its length. 0 below three readings.
  [[nodiscard]] double temp_change_c() const;
  [[nodiscard]] std::size_t clipped() const { return clipped_; }
  /// rad/s or m/s².
  [[nodiscard]] SampleSpread spread(calib::Sensor sensor) const;

 private:
  struct Sums {
    double first = 0.0;
    double sum = 0.0;
    double squares = 0.0;
  };

  double seconds_;
  bool passed_first_ = false;
  bool complete_ = false;
  bool broken_ = false;
  std::optional<double> start_s_;
  double end_s_ = 0.0;
  std::size_t samples_ = 0;
  std::size_t clipped_ = 0;
  std::array<Sums, calib::kSensorCount> sums_;
  std::size_t temps_ = 0;
  double first_temp_c_ = 0.0;
  double sum_t_ = 0.0, sum_temp_ = 0.0, sum_tt_ = 0.0, sum_t_temp_ = 0.0;
};

/// What one unit showed in one position of the pre-flight.
struct PreflightRecord {
  std::string unit;
  std::string position;
  calib::UnitType type;
  double asked_rate_hz = 0.0;  ///< by the procedure
  double rate_hz = 0.0;        ///< samples per second of device time
  std::size_t samples = 0;
  std::size_t clipped = 0;
  std::uint64_t lost_packets = 0;  ///< since the run began
  std::array<SampleSpread, calib::kSensorCount> spread;
};

enum class PreflightFault : std::uint8_t {
  few_samples,
  clipped,
  lost_packets,
  wrong_rate,
  not_finite,
  stuck,
  noise,
  bias,
};

struct PreflightFinding {
  PreflightFault fault = PreflightFault::few_samples;
  std::string text;  ///< one line, with unit and sensor
};

/// What would spoil the campaign: a sensor that is stuck, noisier than its type allows or far
/// from zero or whose readings are not all numbers, an end of the range that was reached, packets lost (more than 1 in
/// 1000), too few samples, a rate that is off the one that was asked for by more than a half (a unit that obeys another
/// divisor; those with a rate of their own stay within). Serial numbers and signs have been checked before: they stop
/// the pre-flight where they are wrong.
[[nodiscard]] std::vector<PreflightFinding> preflight_findings(const std::vector<PreflightRecord>& records);

}  // namespace soak::station
