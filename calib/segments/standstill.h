// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "calib/vocabulary/position.h"
#include "calib/vocabulary/recording.h"
#include "calib/vocabulary/sensor.h"

namespace soak::calib {

/// Rows [first, last) during which the unit rested.
struct Standstill {
  std::size_t first = 0;
  std::size_t last = 0;
  Vector3 force{};  ///< mean reading of the accelerometers, m/s²
};

/// Finds where a unit rested that was turned by hand from attitude to attitude, after the idea of Tedaldi, Pretto,
/// Menegatti, ICRA 2014: over a window the spread of the accelerometers, √(v_x + v_y + v_z) with v the variances, stays
/// below three times that of the recording's quietest windows; so does the spread of the gyros, where there are any,
/// and none of them reads 1 deg/s (beyond noise) off its usual reading at rest: a turn about the vertical is quiet for
/// accelerometers. A row belongs to a standstill if the whole window about it is quiet; so what touching the unit does
/// is left out.
///
/// Windows are of 1 s, and ten rows at least. Standstills shorter than 1 s beside half a window at each end are
/// dropped. Nothing need be known of the noise, but the unit must rest for an eighth of the time. Sensors may be in
/// memory one at a time. Memory: a tenth of the rows; cost linear in rows.
class StandstillFinder {
 public:
  explicit StandstillFinder(std::span<const double> t_s);

  /// One sample per row, NaN = missing; each sensor once at most.
  void add(Sensor sensor, std::span<const double> samples);
  /// After all sensors, in the order of time. None without three accelerometers.
  [[nodiscard]] std::vector<Standstill> find() const;

 private:
  /// Running sums over hops of rows, about the first sample.
  struct Sums {
    double count = 0.0;
    double x = 0.0;
    double squares = 0.0;
  };
  struct Channel {
    double origin = 0.0;
    double step = 0.0;  ///< output step
    std::vector<Sums> sums;
  };
  struct Moments {
    double mean = 0.0;
    double variance = 0.0;  ///< NaN where there are too few samples
  };

  [[nodiscard]] Moments moments(const Channel& channel, std::size_t first_hop, std::size_t last_hop) const;
  [[nodiscard]] std::vector<double> spreads(std::size_t first_sensor) const;
  [[nodiscard]] double threshold(const std::vector<double>& spreads, std::size_t first_sensor) const;
  void drop_turning(std::vector<bool>& quiet, double gyro_threshold) const;
  [[nodiscard]] std::vector<Standstill> collect(const std::vector<bool>& quiet) const;

  std::span<const double> t_s_;
  std::size_t rows_per_hop_ = 1;
  std::size_t windows_ = 0;
  std::array<Channel, kSensorCount> channels_;
};

/// Whether the recording may be of a session on a bench: no positions are given, it is no longer than six hours, and
/// the temperature stays within 10 K. Looks at neither sensors nor movement.
[[nodiscard]] bool may_be_bench_session(const Recording& recording);

/// Whether standstills show three attitudes or more, 10° apart or more. Less than that is a unit in one attitude.
[[nodiscard]] bool show_attitudes(std::span<const Standstill> standstills);

}  // namespace soak::calib
