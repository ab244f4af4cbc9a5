// SPDX-License-Identifier: Apache-2.0
// Effects that follow the way a unit is held. catalogue.cpp says what each one is.
#include "hal/sim/unit/attitude.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>

#include "base/random.h"
#include "base/units.h"
#include "hal/sim/effects/detail/effect_makers.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

using calib::Vector3;
using Matrix = std::array<Vector3, 3>;

Vector3 product(const Matrix& matrix, const Vector3& v) {
  return {dot(matrix[0], v), dot(matrix[1], v), dot(matrix[2], v)};
}

/// "m_xy" of prefix "m", row 0 and column 1.
std::string element_name(const char* prefix, std::size_t row, std::size_t column) {
  return std::string(prefix) + '_' + "xyz"[row] + "xyz"[column];
}

/// Whether the unit rests in one of the six positions rather than being on the way.
bool rests_on_an_axis(const Vector3& up) {
  return std::max({std::abs(up[0]), std::abs(up[1]), std::abs(up[2])}) > 1.0 - 1e-9;
}

/// The up vectors in which a unit rests, from moment to moment. A half turn goes through an axis on its way: where the
/// unit has left again within kPassing_s it did not rest.
class Rests {
 public:
  void advance(const Vector3& up, double time_s) {
    if (up == now_) return;
    if (!left_s_) left_s_ = time_s;
    if (!rests_on_an_axis(up)) return;
    if (*left_s_ - came_s_ >= kPassing_s) before_ = now_;
    now_ = up;
    came_s_ = time_s;
    left_s_.reset();
  }
  /// The one before the present one; 0 in the first.
  [[nodiscard]] const Vector3& before() const { return before_; }

 private:
  static constexpr double kPassing_s = 2.0;
  Vector3 now_{};
  Vector3 before_{};
  double came_s_ = -std::numeric_limits<double>::infinity();
  std::optional<double> left_s_;
};

}  // namespace

std::unique_ptr<Effect> make_g_sensitivity(const EffectOrder& order, ShapeDraws& shape) {
  const bool all_axes = shape.toss("all_axes");
  Matrix matrix{};
  double largest = 0.0;
  for (std::size_t gyro = 0; gyro < 3; ++gyro) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double element = drawn_sign(shape.random()) * shape.random().uniform(0.4, 1.0);
      if (order.gain[gyro] == 0.0 || (!all_axes && axis != gyro)) continue;
      matrix[gyro][axis] = element;
      largest = std::max(largest, std::abs(element));
    }
  }
  for (std::size_t gyro = 0; gyro < 3; ++gyro) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (largest > 0.0) matrix[gyro][axis] /= largest;
      shape.kept(element_name("m", gyro, axis), matrix[gyro][axis]);
    }
  }
  return axis_response(SensorKind::gyros, [matrix](const Conditions& now) { return product(matrix, now.up); });
}

std::unique_ptr<Effect> make_earth_rate(const EffectOrder& order, ShapeDraws& shape) {
  EarthFrame frame;
  if (order.earth) {
    frame.latitude_deg = shape.kept("latitude_deg", order.earth->latitude_deg);
    frame.azimuth_deg = shape.kept("azimuth_deg", order.earth->azimuth_deg);
  } else {
    frame.latitude_deg = shape.within("latitude_deg", {25.0, 65.0});
    frame.azimuth_deg = shape.within("azimuth_deg", {0.0, 360.0});
  }
  // In rates of the Earth: sin φ · up + cos φ · north, the first alone on the way.
  return axis_response(SensorKind::gyros, [frame](const Conditions& now) -> Vector3 {
    if (rests_on_an_axis(now.up)) {
      calib::Position position;
      position.up = now.up;
      Vector3 rate = resting(position, frame).rate_rps;
      for (double& part : rate) part /= base::kEarthRate_rps;
      return rate;
    }
    const double vertical = std::sin(frame.latitude_deg * base::kRadPerDeg);
    return {vertical * now.up[0], vertical * now.up[1], vertical * now.up[2]};
  });
}

std::unique_ptr<Effect> make_cross_axis(const EffectOrder&, ShapeDraws& shape) {
  Matrix matrix{};
  for (std::size_t sensor = 0; sensor < 3; ++sensor) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (axis == sensor) continue;
      const double element = drawn_sign(shape.random()) * shape.random().uniform(0.5, 1.0);
      matrix[sensor][axis] = shape.kept(element_name("c", sensor, axis), element);
    }
  }
  return axis_response(SensorKind::accels, [matrix](const Conditions& now) {
    Vector3 response = product(matrix, now.up);
    for (double& part : response) part = base::kStandardGravity_mps2 * (now.element_c - 25.0) * part;
    return response;
  });
}

std::unique_ptr<Effect> make_fixture_tilt(const EffectOrder& order, ShapeDraws&) {
  // θ × f of a rotation θ of the body, whose three parts are Gaussian for each mounting.
  return axis_response(SensorKind::accels, [seed = order.seed](const Conditions& now) {
    const auto mounting = static_cast<std::uint64_t>(now.mounting);
    Vector3 tilt{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      tilt[axis] = base::hashed_gaussian(seed, mounting, axis) / std::sqrt(3.0);
    }
    Vector3 response = cross(tilt, now.up);
    for (double& part : response) part = base::kRadPerDeg * base::kStandardGravity_mps2 * part;
    return response;
  });
}

std::unique_ptr<Effect> make_scale_nonlinearity(const EffectOrder&, ShapeDraws&) {
  return axis_response(SensorKind::accels, [](const Conditions& now) -> Vector3 {
    return {now.up[0] * now.up[0], now.up[1] * now.up[1], now.up[2] * now.up[2]};
  });
}

std::unique_ptr<Effect> make_reposition_creep(const EffectOrder&, ShapeDraws& shape) {
  const Vector3 direction = drawn_direction(shape.random());
  const double decay_s = shape.spread("decay_s", {150.0, 900.0});
  return shared_response([=, clock = Stopwatch(), place = 0.0, stress = 0.0](const Conditions& now) mutable {
    const double now_at = dot(direction, now.up);
    const auto passed_s = clock.lap_s(now.time_s);
    if (passed_s) stress = stress * std::exp(-*passed_s / decay_s) + now_at - place;
    place = now_at;
    return stress;
  });
}

std::unique_ptr<Effect> make_position_memory(const EffectOrder&, ShapeDraws& shape) {
  const Vector3 direction = drawn_direction(shape.random());
  return shared_response([=, rests = Rests()](const Conditions& now) mutable {
    rests.advance(now.up, now.time_s);
    return dot(direction, rests.before());
  });
}

}  // namespace soak::hal::sim
