// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "base/random.h"
#include "calib/vocabulary/recording.h"

/// A unit that is turned by hand on a bench, with known truth. Shares nothing with calib or hal/sim: rotations are
/// products of closed-form rotation matrices, rates their exact derivatives, nothing is integrated.
namespace soak::calib::test {

using Matrix = std::array<Vector3, 3>;

inline Vector3 times(const Matrix& m, const Vector3& v) {
  Vector3 out{};
  for (std::size_t i = 0; i < 3; ++i) out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
  return out;
}
inline Vector3 transposed_times(const Matrix& m, const Vector3& v) {
  Vector3 out{};
  for (std::size_t i = 0; i < 3; ++i) out[i] = m[0][i] * v[0] + m[1][i] * v[1] + m[2][i] * v[2];
  return out;
}
inline Matrix product(const Matrix& a, const Matrix& b) {
  Matrix out{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) out[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
  }
  return out;
}
inline Vector3 unit(const Vector3& v) {
  const double length = std::hypot(v[0], v[1], v[2]);
  return {v[0] / length, v[1] / length, v[2] / length};
}
inline Vector3 crossed(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Rodrigues: rotation by an angle about a unit vector.
inline Matrix rotation(const Vector3& n, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  Matrix r{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) r[i][j] = (1.0 - c) * n[i] * n[j] + (i == j ? c : 0.0);
  }
  r[0][1] -= s * n[2];
  r[0][2] += s * n[1];
  r[1][0] += s * n[2];
  r[1][2] -= s * n[0];
  r[2][0] -= s * n[1];
  r[2][1] += s * n[0];
  return r;
}

/// raw = K·x + b of both triads, and the gyros' response to force.
struct HandTruth {
  Matrix accel_gain = {{{1.004, 0.006, -0.004}, {0.0, 0.997, 0.008}, {0.0, 0.0, 1.002}}};
  Vector3 accel_bias = {0.15, -0.08, 0.21};
  Matrix gyro_gain = {{{1.012, 0.004, -0.007}, {-0.005, 0.991, 0.003}, {0.006, -0.002, 1.005}}};
  Vector3 gyro_bias = {0.012, -0.02, 0.007};  ///< rad/s
  Matrix g_sensitivity = {{{2e-4, -1e-4, 5e-5}, {0.0, 1e-4, -2e-4}, {1e-4, 5e-5, -1e-4}}};
};

/// What is done, and how well.
struct HandOptions {
  double rate_hz = 100.0;
  double rest_s = 6.0;
  double move_s = 2.5;
  double turn_s = 6.0;
  double accel_noise = 0.02;  ///< of a sample, m/s²
  double gyro_noise = 0.002;  ///< of a sample, rad/s
  double gyro_walk = 2e-5;    ///< rad/s per √s: the bias wanders
  double wobble_rad = 0.1;    ///< of the axis while the unit is moved
  double hand_mps2 = 3.0;     ///< accelerations of the hand
  double return_rad = 0.003;  ///< how well a turn comes back to its place
  double gravity_mps2 = 9.81;
  double earth_rps = 7.292115e-5;
  double latitude_rad = 0.9;
};

/// Records one session: rests and moves one after the other.
class HandSession {
 public:
  HandSession(HandTruth truth, const HandOptions& options, std::uint64_t seed)
      : truth_(std::move(truth)), options_(options), random_(seed) {
    recording_.run_id = "session";
    recording_.unit = "U";
    attitude_ = rotation(unit({random_.gaussian(), random_.gaussian(), random_.gaussian()}), random_.uniform(0.0, 6.0));
  }

  /// `label`: as the recording names the position; empty names none.
  void rest(const std::string& label = "") { record(options_.rest_s, {}, 0.0, {}, 0.0, label, std::nullopt); }

  /// To an attitude in which that vector of the body points up, by the shortest way and with the hand's wobble. Where
  /// there is none, any.
  void tilt_to(const Vector3& up_body) {
    const Vector3 now = up();
    const Vector3 target = unit(up_body);
    Vector3 axis = crossed(target, now);  // body axis: turns `target` to where up is now
    const double angle =
        std::atan2(std::hypot(axis[0], axis[1], axis[2]), now[0] * target[0] + now[1] * target[1] + now[2] * target[2]);
    if (std::hypot(axis[0], axis[1], axis[2]) < 1e-6) axis = crossed(now, {now[1] + 0.3, now[2] - 0.2, now[0] + 0.1});
    move(unit(axis), angle);
    // The wobble is over: the attitude is exactly the target but for the hand's aim.
  }

  /// About the vertical, in place, and back to it within `return_rad`.
  void turn(double angle_rad) {
    const double really = angle_rad + options_.return_rad * random_.gaussian();
    record(options_.turn_s, up(), really, {}, 0.0, "", std::abs(angle_rad));
    attitude_ = product(attitude_, rotation(up(), really));
  }

  /// What was recorded; the gyros' bias wandered about that of the truth, which is its mean over the session.
  [[nodiscard]] Recording recording() const {
    Recording settled = recording_;
    const auto rows = static_cast<double>(recording_.rows());
    for (std::size_t k = 0; k < 3; ++k) {
      for (double& x : settled.sensor[k]) x -= drift_sum_[k] / rows;
    }
    return settled;
  }
  /// Up in body axes.
  [[nodiscard]] Vector3 up() const { return transposed_times(attitude_, {0.0, 0.0, 1.0}); }

 private:
  void move(const Vector3& axis, double angle) {
    const Vector3 other = unit(crossed(axis, {random_.gaussian(), random_.gaussian(), random_.gaussian()}));
    record(options_.move_s, axis, angle, other, options_.wobble_rad, "", std::nullopt);
    attitude_ = product(attitude_, rotation(axis, angle));
  }

  /// R(t) = R0·exp(axis·θ s(t))·exp(other·w(t)), s from 0 to 1 and w from 0 to 0, both with zero rates at the ends.
  void record(double length_s, const Vector3& axis, double angle, const Vector3& other, double wobble,
              const std::string& label, std::optional<double> stated_rad) {
    const auto rows = static_cast<std::size_t>(std::lround(length_s * options_.rate_hz));
    for (std::size_t i = 0; i < rows; ++i) {
      const double x = static_cast<double>(i) / static_cast<double>(rows);
      const double pi = std::numbers::pi;
      const double s = x - std::sin(2.0 * pi * x) / (2.0 * pi);
      const double s_rate = (1.0 - std::cos(2.0 * pi * x)) / length_s;
      const double w = wobble * std::pow(std::sin(pi * x), 2);
      const double w_rate = wobble * pi * std::sin(2.0 * pi * x) / length_s;
      const Matrix first = angle != 0.0 ? rotation(axis, angle * s) : Matrix{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
      const Matrix second = wobble != 0.0 ? rotation(other, w) : Matrix{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
      const Vector3 carried = transposed_times(second, axis);
      Vector3 rate{};
      for (std::size_t k = 0; k < 3; ++k) rate[k] = angle * s_rate * carried[k] + w_rate * other[k];
      sample(product(product(attitude_, first), second), rate, angle != 0.0 ? std::sin(pi * x) : 0.0, label,
             stated_rad);
    }
  }

  void sample(const Matrix& attitude, const Vector3& rate, double motion, const std::string& label,
              const std::optional<double>& stated_rad) {
    const double dt = 1.0 / options_.rate_hz;
    Vector3 force = transposed_times(attitude, {0.0, 0.0, options_.gravity_mps2});
    const Vector3 earth = transposed_times(attitude, {0.0, options_.earth_rps * std::cos(options_.latitude_rad),
                                                      options_.earth_rps * std::sin(options_.latitude_rad)});
    Vector3 turning{};
    for (std::size_t k = 0; k < 3; ++k) {
      force[k] += motion * options_.hand_mps2 * random_.gaussian();
      turning[k] = rate[k] + earth[k];
      drift_[k] += options_.gyro_walk * std::sqrt(dt) * random_.gaussian();
      drift_sum_[k] += drift_[k];
    }
    const Vector3 accel = times(truth_.accel_gain, force);
    const Vector3 gyro = times(truth_.gyro_gain, turning);
    const Vector3 pull = times(truth_.g_sensitivity, force);
    auto& sensor = recording_.sensor;
    for (std::size_t k = 0; k < 3; ++k) {
      sensor[k].push_back(gyro[k] + truth_.gyro_bias[k] + pull[k] + drift_[k] +
                          options_.gyro_noise * random_.gaussian());
      sensor[3 + k].push_back(accel[k] + truth_.accel_bias[k] + options_.accel_noise * random_.gaussian());
    }
    recording_.t_s.push_back(static_cast<double>(recording_.t_s.size()) * dt);
    recording_.temp_c.push_back(24.0 + 0.8 * (1.0 - std::exp(-recording_.t_s.back() / 200.0)) +
                                0.02 * random_.gaussian());
    note(label, stated_rad);
  }

  void note(const std::string& label, const std::optional<double>& stated_rad) {
    if (!label.empty()) {
      if (recording_.position.empty()) recording_.position.assign(recording_.t_s.size() - 1, -1);
      const auto known = std::ranges::find(recording_.positions, label, &Position::label);
      recording_.position.push_back(static_cast<std::int32_t>(known - recording_.positions.begin()));
      if (known == recording_.positions.end()) recording_.positions.push_back(*position_named(label));
    } else if (!recording_.position.empty()) {
      recording_.position.push_back(-1);
    }
    if (recording_.auxiliary.empty()) recording_.auxiliary.push_back({"turn_deg", {}});
    recording_.auxiliary[0].values.push_back(stated_rad ? *stated_rad * 180.0 / std::numbers::pi : std::nan(""));
  }

  HandTruth truth_;
  HandOptions options_;
  base::Random random_;
  Recording recording_;
  Matrix attitude_{};
  Vector3 drift_{};
  Vector3 drift_sum_{};
};

}  // namespace soak::calib::test
