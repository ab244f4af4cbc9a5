// SPDX-License-Identifier: Apache-2.0
#include "station/lab/attitude_watch.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/units.h"

namespace soak::station {
namespace {

constexpr double kCosineOfLimit = 0.99619;  // 5°
constexpr double kGravityShare = 0.1;
constexpr double kRest_rps = 0.0873;  // 5 °/s
constexpr double kRest_s = 2.0;

bool rests(const hal::ImuSample& sample) {
  return std::all_of(sample.rate_rps.begin(), sample.rate_rps.end(),
                     [](float rate) { return std::abs(static_cast<double>(rate)) < kRest_rps; });
}

}  // namespace

void AttitudeWatch::expect(const calib::Position& position, int sign_at_rest) {
  for (std::size_t i = 0; i < 3; ++i) up_[i] = position.up[i] * sign_at_rest;
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
  // Time that begins anew (a restart) begins the stretch anew.
  if (sample.t_s < last_s_) right_since_s_ = wrong_since_s_ = std::nullopt;
  last_s_ = sample.t_s;
  const bool still = rests(sample);
  const bool right = still && along >= kCosineOfLimit * norm &&
                     std::abs(norm - base::kStandardGravity_mps2) <= kGravityShare * base::kStandardGravity_mps2;
  const auto keep = [&](std::optional<double>& since, bool holds) {
    if (!holds) since.reset();
    if (holds && !since) since = sample.t_s;
  };
  keep(right_since_s_, right);
  keep(wrong_since_s_, still && !right);
}

Standing AttitudeWatch::standing() const {
  const auto lasts = [&](const std::optional<double>& since) { return since && last_s_ - *since >= kRest_s; };
  if (!expects_) return Standing::unknown;
  if (lasts(right_since_s_)) return Standing::right;
  return lasts(wrong_since_s_) ? Standing::wrong : Standing::turning;
}

std::string AttitudeWatch::seen() const {
  std::size_t axis = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(force_mps2_[i]) > std::abs(force_mps2_[axis])) axis = i;
  }
  return {force_mps2_[axis] < 0.0F ? '-' : '+', static_cast<char>('X' + axis)};
}

}  // namespace soak::station
