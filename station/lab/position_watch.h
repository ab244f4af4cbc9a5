// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "calib/vocabulary/position.h"
#include "hal/imu/imu.h"

/// Whether a unit stands and turns as it should, by its own sensors. Samples from before a call of expect() never
/// count.
namespace soak::station {

/// What a unit's accelerometers and gyros say about its position.
enum class Attitude : std::uint8_t { unknown, turning, wrong, right };

/// Judges whether a unit has come to rest in the position that it should have: the specific force within 5° of the
/// expected direction and within 10 % of gravity, each rate below 5 °/s, for two seconds of device time without a
/// break.
class AttitudeWatch {
 public:
  /// `sign_at_rest`: +1 where the axis that points up reads +g.
  void expect(const calib::Position& position, int sign_at_rest);
  void add(const hal::ImuSample& sample);
  [[nodiscard]] Attitude state() const;
  /// The face that is up, as a position's label: of the axis that reads the largest part of gravity.
  [[nodiscard]] std::string up_axis() const;

 private:
  calib::Vector3 up_{};
  int sign_at_rest_ = 1;
  bool expects_ = false;
  std::optional<double> right_since_s_;
  std::optional<double> wrong_since_s_;
  double last_s_ = 0.0;
  std::array<float, 3> force_mps2_{};
};

/// Judges by a unit's gyros whether it turns steadily as it should: over two seconds of device time, the mean rate
/// about its upward direction within 2 deg/s and 2 % of what is expected (a bias and a scale error of its own are no
/// fault of the fixture), and that across it within 2 deg/s and 5 %.
class RateWatch {
 public:
  void expect(const calib::Position& position, double rate_dps);
  void add(const hal::ImuSample& sample);
  /// The last two seconds were right.
  [[nodiscard]] bool right() const { return right_; }
  /// The last mean about the upward direction, for messages.
  [[nodiscard]] std::optional<double> measured_dps() const { return measured_dps_; }

 private:
  void judge();

  calib::Vector3 up_{};
  double expected_dps_ = 0.0;
  double window_begin_s_ = 0.0;
  double last_s_ = 0.0;
  calib::Vector3 sum_rps_{};
  int samples_ = 0;  ///< in the window; 0 = the next sample begins one
  bool expects_ = false;
  bool right_ = false;
  std::optional<double> measured_dps_;
};

}  // namespace soak::station
