// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/detail/turning_axis.h"

#include <algorithm>
#include <cmath>

namespace soak::hal::sim {
namespace {

constexpr double kAcceleration_dps2 = 50.0;

}  // namespace

double TurningAxis::since_s(Tick now) const {
  return static_cast<double>(now - start_) / static_cast<double>(kTicksPerSecond);
}

void TurningAxis::go_to(double from_deg, double angle_deg, Tick now) {
  start_ = now;
  start_deg_ = from_deg;
  end_deg_ = angle_deg;
  dps_ = start_dps_ = std::copysign(speed_dps_, angle_deg - from_deg);
  change_s_ = 0.0;
  end_s_ = std::abs(angle_deg - from_deg) / speed_dps_;
  ends_ = true;
}

void TurningAxis::turn_at(double rate_dps, Tick now) {
  const double from_deg = angle_deg(now);
  const double from_dps = this->rate_dps(now);
  start_ = now;
  start_deg_ = from_deg;
  start_dps_ = from_dps;
  dps_ = rate_dps;
  change_s_ = std::abs(rate_dps - from_dps) / kAcceleration_dps2;
  ends_ = false;
}

double TurningAxis::angle_deg(Tick now) const {
  const double t_s = since_s(now);
  if (ends_) return t_s < end_s_ ? start_deg_ + dps_ * t_s : end_deg_;
  const double changing_s = std::min(t_s, change_s_);
  const double mean_dps = 0.5 * (start_dps_ + rate_dps(now));
  return start_deg_ + mean_dps * changing_s + dps_ * (t_s - changing_s);
}

double TurningAxis::rate_dps(Tick now) const {
  const double t_s = since_s(now);
  if (ends_) return t_s < end_s_ ? dps_ : 0.0;
  return t_s < change_s_ ? start_dps_ + (dps_ - start_dps_) * t_s / change_s_ : dps_;
}

bool TurningAxis::settled(Tick now) const { return since_s(now) >= (ends_ ? end_s_ : change_s_); }

}  // namespace soak::hal::sim
