// SPDX-License-Identifier: Apache-2.0
#include "station/lab/warmth.h"

#include <algorithm>
#include <cmath>

namespace soak::station {
namespace {

using std::chrono::steady_clock;

constexpr double kLowest_c = 25.0;
constexpr double kMargin_c = 2.0;  ///< above the dew point
constexpr double kAirIsThere_c = 1.0;
constexpr std::chrono::seconds kBetweenTries{1};
constexpr double kSilentUnit_s = 1800.0;  ///< process time in warm air for a unit that does not tell its temperature

}  // namespace

Warmth::Warmth(double temp_c) : temp_c_(std::max(temp_c, kLowest_c)) {}

double Warmth::target_c(const Lab& lab) const { return std::max(temp_c_, lab.config.dew_point_c + 2.0 * kMargin_c); }

bool Warmth::drive(Lab& lab) {
  const auto now = steady_clock::now();
  if (now < next_try_) return false;
  next_try_ = now + kBetweenTries;
  hal::Chamber& chamber = lab.chamber.chamber();
  // A ramp that cannot be switched off makes the way longer, not impossible.
  if (chamber.can_ramp()) (void)chamber.set_ramp_rate(std::nullopt);
  return chamber.set_temperature(target_c(lab)).has_value() && chamber.start().has_value();
}

bool Warmth::poll(Lab& lab) {
  if (!driving_) {
    driving_ = drive(lab);
    return false;
  }
  const double target = target_c(lab);
  const auto& reading = lab.chamber.reading();
  if (!reading) return false;
  // The controller forgot (it restarted, someone pressed its keys): tell it again.
  if (std::abs(reading->set_point_c - target) > 0.5 || !reading->running) {
    driving_ = false;
    return false;
  }
  if (std::abs(reading->air_c - target) > kAirIsThere_c) {
    warm_since_s_.reset();
    return false;
  }
  if (!warm_since_s_) warm_since_s_ = lab.now_s();
  if (!is_dry(lab)) return false;
  return lab.chamber.chamber().stop().has_value();
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
