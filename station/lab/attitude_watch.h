// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>

#include "calib/vocabulary/position.h"
#include "hal/imu/imu.h"

namespace soak::station {

/// What a unit's own sensors say of how it stands.
enum class Standing { unknown, turning, wrong, right };

/// Judges by a unit's accelerometers and gyros whether it has come to rest in the position that it should stand in:
/// the specific force within 5° of the expected direction and within 10 % of gravity, each rate below 5 °/s, for two
/// seconds of device time without a break. Samples from before a turn therefore never pass for the new position.
class AttitudeWatch {
 public:
  /// `sign_at_rest`: +1 where the axis that points up reads +g.
  void expect(const calib::Position& position, int sign_at_rest);
  void add(const hal::ImuSample& sample);
  [[nodiscard]] Standing standing() const;
  /// The axis that reads the largest part of gravity, as a position's label; for messages.
  [[nodiscard]] std::string seen() const;

 private:
  calib::Vector3 up_{};
  bool expects_ = false;
  std::optional<double> right_since_s_;
  std::optional<double> wrong_since_s_;
  double last_s_ = 0.0;
  std::array<float, 3> force_mps2_{};
};

}  // namespace soak::station
