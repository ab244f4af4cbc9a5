// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/detail/two_axis_fixture.h"

#include <cmath>
#include <utility>

#include "base/units.h"

namespace soak::hal::sim {
namespace {

using calib::Vector3;

constexpr int kOuterRequest = 0;
constexpr int kInnerRequest = 2;
constexpr int kRateRequest = 4;
constexpr int kCommand = 6;
constexpr int kOuterAngle = 10;
constexpr int kInnerAngle = 12;
constexpr int kRate = 14;
constexpr int kStatus = 16;
constexpr int kIdentification = 32;
constexpr int kIdentity = 0x5441;

constexpr int kGoToAngles = 1;
constexpr int kTurnAtRate = 2;
constexpr std::pair<double, double> kOuterLimits_deg = {-5.0, 185.0};
constexpr std::pair<double, double> kInnerLimits_deg = {-180.0, 180.0};
constexpr std::pair<double, double> kRateLimits_dps = {-200.0, 200.0};

/// What a vector that is fixed in the room is in the axes of a body that was turned by `angle_deg` about +X.
Vector3 seen_after_tilt(const Vector3& v, double angle_deg) {
  const double c = std::cos(angle_deg * base::kRadPerDeg);
  const double s = std::sin(angle_deg * base::kRadPerDeg);
  return {v[0], c * v[1] + s * v[2], c * v[2] - s * v[1]};
}

/// The same about +Z.
Vector3 seen_after_turn(const Vector3& v, double angle_deg) {
  const double c = std::cos(angle_deg * base::kRadPerDeg);
  const double s = std::sin(angle_deg * base::kRadPerDeg);
  return {c * v[0] + s * v[1], c * v[1] - s * v[0], v[2]};
}

/// Of the Earth, in the axes of the fixture at 0, 0: x forward, y to the left, z up.
Vector3 earth_rate_rps(const std::optional<EarthFrame>& earth) {
  if (!earth) return {};
  const double latitude = earth->latitude_deg * base::kRadPerDeg;
  const double azimuth = earth->azimuth_deg * base::kRadPerDeg;
  const double north_rps = base::kEarthRate_rps * std::cos(latitude);
  return {north_rps * std::cos(azimuth), north_rps * std::sin(azimuth), base::kEarthRate_rps * std::sin(latitude)};
}

RegisterTable::ValueWriter kept_in(double& value, std::pair<double, double> limits) {
  return {[limits](double asked) { return asked >= limits.first && asked <= limits.second; },
          [&value](double asked) { value = asked; }};
}

}  // namespace

TwoAxisFixture::TwoAxisFixture(double turn_s_per_rad, const std::optional<EarthFrame>& earth)
    : earth_(earth), outer_(base::kDegPerRad / turn_s_per_rad), inner_(base::kDegPerRad / turn_s_per_rad) {
  add_registers();
}

void TwoAxisFixture::add_registers() {
  constexpr auto high = RegisterTable::FirstWord::high;
  registers_.add_value(
      kOuterRequest, [this] { return asked_outer_deg_; }, kept_in(asked_outer_deg_, kOuterLimits_deg), high);
  registers_.add_value(
      kInnerRequest, [this] { return asked_inner_deg_; }, kept_in(asked_inner_deg_, kInnerLimits_deg), high);
  registers_.add_value(kRateRequest, [this] { return asked_dps_; }, kept_in(asked_dps_, kRateLimits_dps), high);
  registers_.add_number(kCommand, 1, [] { return 0; },
                        {[](int command) { return command == kGoToAngles || command == kTurnAtRate; },
                         [this](int command) { carry_out(command); }});
  registers_.add_value(kOuterAngle, [this] { return outer_.angle_deg(now_); }, {}, high);
  registers_.add_value(kInnerAngle, [this] { return inner_deg(); }, {}, high);
  registers_.add_value(kRate, [this] { return inner_.rate_dps(now_); }, {}, high);
  registers_.add_number(kStatus, 1, [this] { return outer_.settled(now_) && inner_.settled(now_) ? 0 : 1; });
  registers_.add_number(kIdentification, 1, [] { return kIdentity; });
}

void TwoAxisFixture::carry_out(int command) {
  if (command == kTurnAtRate) {
    inner_.turn_at(asked_dps_, now_);
    return;
  }
  outer_.go_to(outer_.angle_deg(now_), asked_outer_deg_, now_);
  inner_.go_to(inner_deg(), asked_inner_deg_, now_);
}

double TwoAxisFixture::inner_deg() const { return std::remainder(inner_.angle_deg(now_), 360.0); }

Attitude TwoAxisFixture::attitude() const {
  const double tilt_deg = outer_.angle_deg(now_);
  const double turn_deg = inner_.angle_deg(now_);
  const Vector3 room_rate_rps = earth_rate_rps(earth_);
  const double tilting_rps = outer_.rate_dps(now_) * base::kRadPerDeg;
  // The outer axis adds its rate in the room's axes, the inner one in those of the fixture.
  const Vector3 carried_rps = {room_rate_rps[0] + tilting_rps, room_rate_rps[1], room_rate_rps[2]};
  Attitude attitude{seen_after_turn(seen_after_tilt({0.0, 0.0, 1.0}, tilt_deg), turn_deg),
                    seen_after_turn(seen_after_tilt(carried_rps, tilt_deg), turn_deg)};
  attitude.rate_rps[2] += inner_.rate_dps(now_) * base::kRadPerDeg;
  return attitude;
}

}  // namespace soak::hal::sim
