// SPDX-License-Identifier: Apache-2.0
#include "station/lab/warmth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace soak::station {
namespace {

constexpr double kLowest_c = 25.0;
constexpr double kMargin_c = 2.0;  ///< above the dew point
constexpr double kAirIsThere_c = 1.0;
constexpr double kSetPointTolerance_c = 0.5;
constexpr std::chrono::seconds kBetweenTries{1};
constexpr int kTries = 5;
constexpr std::chrono::seconds kBetweenLaterTries{60};
constexpr double kSilentUnit_s = 1800.0;  ///< process time in warm air for a unit that does not tell its temperature

bool answers(const Lab& lab) { return lab.chamber.reading() && lab.chamber.trouble().empty(); }

}  // namespace

Warmth::Warmth(double temp_c) : temp_c_(std::max(temp_c, kLowest_c)) {}

double Warmth::target_c(const Lab& lab) const { return std::max(temp_c_, lab.config.dew_point_c + 2.0 * kMargin_c); }

bool Warmth::drive(Lab& lab) {
  const auto now = Clock::now();
  if (now < next_try_) return false;
  const bool hears = answers(lab);
  if (hears) ++told_;
  next_try_ = now + (hears && told_ >= kTries ? kBetweenLaterTries : kBetweenTries);
  hal::Chamber& chamber = lab.chamber.chamber();
  // A ramp that cannot be switched off makes the way longer, not impossible.
  if (chamber.can_ramp()) (void)chamber.set_ramp_rate(std::nullopt);
  const auto told = chamber.set_temperature(target_c(lab)).and_then([&] { return chamber.start(); });
  if (told) {
    is_off_ = false;
    return true;
  }
  if (hears) take_refusal(lab, told.error().message);
  return false;
}

void Warmth::take_refusal(Lab& lab, const std::string& why) {
  trouble_ = why;
  if (told_ < kTries || is_off_) return;
  is_off_ = lab.chamber.chamber().stop().has_value();
  lab.log.add("device", "chamber",
              fmt::format("cannot be driven to {:+.0f} °C ({}): heating and cooling {}", target_c(lab), why,
                          is_off_ ? "are switched off" : "cannot be switched off either"));
}

bool Warmth::poll(Lab& lab) {
  if (!driving_) {
    driving_ = drive(lab);
    return !driving_ && is_off_ && is_warm_without(lab);
  }
  if (!is_on_its_way(lab)) return false;
  const double target = target_c(lab);
  if (std::abs(lab.chamber.reading()->air_c - target) > kAirIsThere_c) {
    warm_since_s_.reset();
    return false;
  }
  if (!warm_since_s_) warm_since_s_ = lab.now_s();
  return is_dry(lab) && switch_off(lab);
}

/// Whether the chamber says that it goes where it was told to. One that forgot (it restarted, someone pressed its keys)
/// is told again.
bool Warmth::is_on_its_way(const Lab& lab) {
  const auto& reading = lab.chamber.reading();
  if (!reading) return false;
  driving_ = reading->running && std::abs(reading->set_point_c - target_c(lab)) <= kSetPointTolerance_c;
  trouble_ =
      driving_ ? "" : fmt::format("it holds {:+.1f} °C, {}", reading->set_point_c, reading->running ? "on" : "off");
  return driving_;
}

/// Whether the room has warmed what the chamber did not: it is off.
bool Warmth::is_warm_without(const Lab& lab) {
  const auto& reading = lab.chamber.reading();
  if (!reading || reading->running || reading->air_c <= lab.config.dew_point_c + kMargin_c) {
    warm_since_s_.reset();
    return false;
  }
  if (!warm_since_s_) warm_since_s_ = lab.now_s();
  return is_dry(lab);
}

bool Warmth::switch_off(Lab& lab) {
  const auto now = Clock::now();
  if (now < next_stop_) return false;
  next_stop_ = now + kBetweenTries;
  const auto stopped = lab.chamber.chamber().stop();
  trouble_ = stopped ? "" : stopped.error().message;
  return stopped.has_value();
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
