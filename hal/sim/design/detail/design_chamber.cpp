// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/design/detail/design_chamber.h"

#include <algorithm>
#include <cmath>

namespace soak::hal::sim {
namespace {

constexpr double kAirTime_s = 60.0;
constexpr double kLoadTime_s = 1200.0;
constexpr double kUnitToAir_s = 200.0;
constexpr double kUnitToLoad_s = 2000.0;
constexpr double kLongestStep_s = 5.0;
constexpr double kCompressorCycle_s = 400.0;

/// Share of time that the compressor runs.
double compressor_duty(double air_c) { return std::clamp(0.5 - 0.006 * (air_c - 25.0), 0.25, 0.75); }

}  // namespace

DesignChamber::DesignChamber(double room_c, base::Random random) : room_c_(room_c), random_(random) {
  rest();
  stays_s_ = drawn_stay_s();
}

void DesignChamber::rest() {
  target_c_ = set_point_c_ = air_c_ = load_c_ = unit_c_ = room_c_;
  ramp_kps_ = 0.0;
}

void DesignChamber::set_target(double target_c, double ramp_kps) {
  target_c_ = target_c;
  ramp_kps_ = ramp_kps;
}

void DesignChamber::advance(double duration_s) {
  while (duration_s > 0.0) {
    const double step_s = std::min(duration_s, kLongestStep_s);
    step(step_s);
    duration_s -= step_s;
  }
}

void DesignChamber::step(double duration_s) {
  const double to_go_c = target_c_ - set_point_c_;
  set_point_c_ += std::clamp(to_go_c, -ramp_kps_ * duration_s, ramp_kps_ * duration_s);
  const double unit_kps = (air_c_ - unit_c_) / kUnitToAir_s + (load_c_ - unit_c_) / kUnitToLoad_s;
  load_c_ += duration_s / kLoadTime_s * (air_c_ - load_c_);
  air_c_ += duration_s / kAirTime_s * (set_point_c_ - air_c_);
  unit_c_ += duration_s * unit_kps;
  stays_s_ -= duration_s;
  if (stays_s_ <= 0.0) {
    compressor_runs_ = !compressor_runs_;
    stays_s_ += drawn_stay_s();
  }
}

double DesignChamber::drawn_stay_s() {
  const double duty = compressor_duty(air_c_);
  const double mean_s = kCompressorCycle_s * (compressor_runs_ ? duty : 1.0 - duty);
  return -mean_s * std::log(1.0 - random_.uniform());
}

}  // namespace soak::hal::sim
