// SPDX-License-Identifier: Apache-2.0
#include "station/lab/make_safe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

#include "station/lab/dew_safe_warm_up.h"

namespace soak::station {
namespace {

constexpr double kThere_c = 1.0;
constexpr double kSameSetPoint_c = 0.5;
constexpr double kSameAir_c = 5.0;  ///< of two readings, one right after the other
constexpr int kDriveTries = 5;
constexpr int kStopTries = 10;

const hal::ChamberAlarm* alarm_that_stops(const hal::ChamberReading& reading) {
  const auto found = std::ranges::find_if(reading.alarms, &hal::ChamberAlarm::outputs_off);
  return found == reading.alarms.end() ? nullptr : &*found;
}

/// Whether two readings agree in what is decided by them: a flipped bit on the wire is neither an alarm, nor a chamber
/// that is off, nor one that is at its safe temperature.
bool agree(const hal::ChamberReading& before, const hal::ChamberReading& now) {
  return before.running == now.running && std::abs(before.air_c - now.air_c) <= kSameAir_c &&
         (alarm_that_stops(before) == nullptr) == (alarm_that_stops(now) == nullptr);
}

class SafeMaker {
 public:
  SafeMaker(hal::Chamber& chamber, double target_c, const MakeSafePatience& patience)
      : chamber_(chamber), patience_(patience) {
    made_.target_c = target_c;
  }

  base::Result<MadeSafe> run() {
    const auto reading = sure_reading();
    if (!reading) return switch_off("it cannot be read: " + reading.error().message);
    made_.reading = *reading;
    if (const auto* alarm = alarm_that_stops(*reading)) return switch_off("alarm '" + alarm->name + "'");
    if (!reading->running) return made_;
    if (std::abs(reading->air_c - made_.target_c) <= kThere_c) return switch_off("it is at its safe temperature");
    return drive();
  }

 private:
  void rest() const { std::this_thread::sleep_for(patience_.pause); }

  /// A reading that a second one confirms.
  base::Result<hal::ChamberReading> sure_reading() {
    const auto deadline = std::chrono::steady_clock::now() + patience_.silence;
    std::optional<hal::ChamberReading> before;
    for (;;) {
      auto reading = chamber_.read();
      if (reading && before && agree(*before, *reading)) return reading;
      if (std::chrono::steady_clock::now() >= deadline) {
        return reading ? base::fail(base::ErrorKind::device, "its readings contradict each other") : reading;
      }
      const bool again_at_once = reading && !before;
      before = reading ? std::optional(*reading) : std::nullopt;
      if (!again_at_once) rest();
    }
  }

  base::Result<MadeSafe> drive() {
    std::string trouble;
    for (int attempt = 0; attempt < kDriveTries; ++attempt) {
      if (attempt > 0) rest();
      // A ramp that cannot be switched off makes the way longer, not impossible.
      if (chamber_.can_ramp()) (void)chamber_.set_ramp_rate(std::nullopt);
      const auto sent = chamber_.set_temperature(made_.target_c).and_then([&] { return chamber_.start(); });
      const auto reading = chamber_.read();
      if (reading) made_.reading = *reading;
      if (sent && reading && reading->running && std::abs(reading->set_point_c - made_.target_c) <= kSameSetPoint_c) {
        made_.action = SafeAction::driven;
        return made_;
      }
      trouble = !sent      ? sent.error().message
                : !reading ? reading.error().message
                           : fmt::format("its set point is {:+.1f} °C, heating and cooling {}", reading->set_point_c,
                                         reading->running ? "on" : "off");
    }
    return switch_off(fmt::format("it does not drive to {:+.1f} °C ({})", made_.target_c, trouble));
  }

  base::Result<MadeSafe> switch_off(std::string why) {
    made_.action = SafeAction::switched_off;
    made_.why_off = std::move(why);
    std::string trouble;
    for (int attempt = 0; attempt < kStopTries; ++attempt) {
      if (attempt > 0) rest();
      const auto off = chamber_.stop();
      const auto reading = chamber_.read();
      made_.reading = reading ? std::optional(*reading) : std::nullopt;
      // What cannot be read at all has taken the command, which the controller's answer says.
      if (off && (!reading || !reading->running)) return made_;
      trouble = !off ? off.error().message : "it still says that they are on";
    }
    return base::fail(
        base::ErrorKind::device,
        fmt::format(
            "heating and cooling cannot be switched off ({}; {}): go to the chamber and switch them off by hand",
            made_.why_off, trouble),
        chamber_.description());
  }

  hal::Chamber& chamber_;
  MakeSafePatience patience_;
  MadeSafe made_;
};

}  // namespace

base::Result<MadeSafe> make_chamber_safe(hal::Chamber& chamber, double dew_point_c, const MakeSafePatience& patience) {
  return SafeMaker(chamber, safe_temp_c(0.0, dew_point_c), patience).run();
}

}  // namespace soak::station
