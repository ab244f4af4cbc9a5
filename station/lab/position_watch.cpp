// SPDX-License-Identifier: Apache-2.0
#include "station/lab/position_watch.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base/units.h"

namespace soak::station {
namespace {

constexpr double kCosineOf5Degrees = 0.99619;
constexpr double kGravityShare = 0.1;
constexpr double kRest_rps = 0.0873;  // 5 °/s
constexpr double kRest_s = 2.0;

constexpr double kRateWindow_s = 2.0;
constexpr double kRateOffset_dps = 2.0;
constexpr double kRateShareAlong = 0.02;
constexpr double kRateShareAcross = 0.05;

bool is_still(const hal::ImuSample& sample) {
  return std::all_of(sample.rate_rps.begin(), sample.rate_rps.end(),
                     [](float rate) { return std::abs(static_cast<double>(rate)) < kRest_rps; });
}

}  // namespace

void AttitudeWatch::expect(const calib::Position& position, int sign_at_rest) {
  for (std::size_t i = 0; i < 3; ++i) up_[i] = position.up[i] * sign_at_rest;
  sign_at_rest_ = sign_at_rest;
  expects_ = true;
  right_since_s_.reset();
  wrong_since_s_.reset();
}

void AttitudeWatch::add(const hal::ImuSample& sample) {
  force_mps2_ = sample.accel_mps2;
  double norm = 0.0;
  double along = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto force = static_cast<double>(sample.accel_mps2[i]);
    norm += force * force;
    along += force * up_[i];
  }
  norm = std::sqrt(norm);
  // A clock that begins again (a restart) ends the stretch.
  if (sample.t_s < last_s_) right_since_s_ = wrong_since_s_ = std::nullopt;
  last_s_ = sample.t_s;
  const bool still = is_still(sample);
  const bool right = still && along >= kCosineOf5Degrees * norm &&
                     std::abs(norm - base::kStandardGravity_mps2) <= kGravityShare * base::kStandardGravity_mps2;
  const auto follow = [&](std::optional<double>& since, bool holds) {
    if (!holds) since.reset();
    if (holds && !since) since = sample.t_s;
  };
  follow(right_since_s_, right);
  follow(wrong_since_s_, still && !right);
}

Attitude AttitudeWatch::state() const {
  const auto lasts = [&](const std::optional<double>& since) { return since && last_s_ - *since >= kRest_s; };
  if (!expects_) return Attitude::unknown;
  if (lasts(right_since_s_)) return Attitude::right;
  return lasts(wrong_since_s_) ? Attitude::wrong : Attitude::turning;
}

std::string AttitudeWatch::up_axis() const {
  std::size_t axis = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(force_mps2_[i]) > std::abs(force_mps2_[axis])) axis = i;
  }
  const bool down = (force_mps2_[axis] < 0.0F) == (sign_at_rest_ > 0);
  return {down ? '-' : '+', static_cast<char>('X' + axis)};
}

void RateWatch::expect(const calib::Position& position, double rate_dps) {
  up_ = position.up;
  expected_dps_ = rate_dps;
  expects_ = true;
  right_ = false;
  measured_dps_.reset();
  samples_ = 0;
}

void RateWatch::add(const hal::ImuSample& sample) {
  if (!expects_) return;
  // A clock that begins again (a restart) begins another window.
  if (samples_ == 0 || sample.t_s < last_s_) {
    window_begin_s_ = sample.t_s;
    sum_rps_ = {};
    samples_ = 0;
  }
  last_s_ = sample.t_s;
  for (std::size_t i = 0; i < 3; ++i) sum_rps_[i] += static_cast<double>(sample.rate_rps[i]);
  ++samples_;
  if (sample.t_s - window_begin_s_ < kRateWindow_s) return;
  judge();
  samples_ = 0;
}

void RateWatch::judge() {
  double along = 0.0;
  double square = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double mean_dps = sum_rps_[i] / samples_ * base::kDegPerRad;
    along += mean_dps * up_[i];
    square += mean_dps * mean_dps;
  }
  const double across = std::sqrt(std::max(square - along * along, 0.0));
  const double size = std::abs(expected_dps_);
  measured_dps_ = along;
  right_ = std::abs(along - expected_dps_) <= kRateOffset_dps + kRateShareAlong * size &&
           across <= kRateOffset_dps + kRateShareAcross * size;
}

}  // namespace soak::station
