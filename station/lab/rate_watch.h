// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/vocabulary/position.h"
#include "hal/imu/imu.h"

namespace soak::station {

/// Judges by a unit's gyros whether it turns steadily as it should: over two seconds of device time, the mean rate
/// about its upward direction within 2 deg/s and 2 % of what is expected (a bias and a scale error of its own are no
/// fault of the fixture), and that across it within 2 deg/s and 5 %. Begun anew by expect(): samples from before never
/// count.
class RateWatch {
 public:
  void expect(const calib::Position& position, double rate_dps);
  void add(const hal::ImuSample& sample);
  /// The last two seconds say so.
  [[nodiscard]] bool right() const { return right_; }
  /// The last mean about the upward direction, for messages.
  [[nodiscard]] std::optional<double> seen_dps() const { return seen_dps_; }

 private:
  void judge();
  void begin_window(double t_s);

  calib::Vector3 up_{};
  double expected_dps_ = 0.0;
  double begun_s_ = 0.0;
  double last_s_ = 0.0;
  calib::Vector3 sum_rps_{};
  int samples_ = 0;
  bool expects_ = false;
  bool right_ = false;
  std::optional<double> seen_dps_;
};

}  // namespace soak::station
