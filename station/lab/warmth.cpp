// SPDX-License-Identifier: Apache-2.0
#include "station/lab/warmth.h"

#include <algorithm>
#include <cmath>

namespace soak::station {
namespace {

constexpr double kLowest_c = 25.0;
constexpr double kMargin_c = 2.0;  ///< above the dew point
constexpr double kAirIsThere_c = 1.0;
constexpr double kSilentUnit_s = 1800.0;  ///< process time in warm air for a unit that does not tell its temperature

}  // namespace

Warmth::Warmth(double temp_c) : temp_c_(std::max(temp_c, kLowest_c)) {}

base::Result<bool> Warmth::poll(Lab& lab) {
  hal::Chamber& chamber = lab.chamber.chamber();
  if (!driving_) {
    if (chamber.can_ramp() && !chamber.set_ramp_rate(std::nullopt)) return false;
    driving_ = chamber.set_temperature(temp_c_).has_value() && chamber.start().has_value();
    return false;
  }
  const auto& reading = lab.chamber.reading();
  if (!reading) return false;
  // The controller forgot (it restarted, someone pressed its keys): tell it again.
  if (std::abs(reading->set_point_c - temp_c_) > 0.5 || !reading->running) {
    driving_ = false;
    return false;
  }
  if (reading->air_c < temp_c_ - kAirIsThere_c || reading->air_c > temp_c_ + kAirIsThere_c) {
    warm_since_s_.reset();
    return false;
  }
  if (!warm_since_s_) warm_since_s_ = lab.now_s();
  if (!is_dry(lab)) return false;
  return chamber.stop().has_value();
}

bool Warmth::is_dry(const Lab& lab) const {
  const double dry_c = lab.config.dew_point_c + kMargin_c;
  const bool rested = lab.now_s() - *warm_since_s_ >= kSilentUnit_s;
  if (lab.units.empty()) return rested;
  return std::all_of(lab.units.begin(), lab.units.end(), [&](const auto& unit) {
    return unit->streaming() && unit->temp_c() ? *unit->temp_c() > dry_c : rested;
  });
}

}  // namespace soak::station
