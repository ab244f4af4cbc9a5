// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/devices/chamber.h"

namespace soak::station {

/// A unit as the guard sees it: what its own thermometer reads now, and what its type is rated for.
struct GuardedUnit {
  std::string serial;
  double temp_c = 0.0;
  std::optional<double> rated_min_c;
  std::optional<double> rated_max_c;
};

/// Judges from chamber and units together whether heating and cooling may go on: the chamber's thermometer may be
/// wrong, torn off or stuck, and then only the units' own thermometers know. Trips:
/// - a unit reads more than 5 K beyond its type's rating;
/// - a unit's temperature moves faster than 20 K/min over a minute;
/// - a unit differs from the air by more than 25 K although the air has been at its set point for half an hour;
/// - the air reads the same to the last digit for ten minutes while heating or cooling is on and the air is more than
///   2 K from the set point, or, wherever it is, while the output is at 90 % or more;
/// - heating stays at 95 % or more for an hour although the air is at its set point: the heat goes where the
/// thermometer
///   is not.
/// The last two need a map that reads `output_percent`. A single wrong number does not trip: what is judged must be
/// seen three times, over 10 s. It knows no device and no clock.
class ChamberGuard {
 public:
  using HostTime = std::chrono::steady_clock::time_point;

  /// Why heating and cooling must be switched off; nothing where all is well. `now_s`: process time, which does not go
  /// backwards. `reading`: the chamber's last one; null where there is none. `units`: those that send.
  [[nodiscard]] std::optional<std::string> look(double now_s, HostTime host, const hal::ChamberReading* reading,
                                                std::span<const GuardedUnit> units);
  /// Forgets what was seen: another campaign begins, or nobody looked for a while.
  void forget() { *this = {}; }

 private:
  /// How often and since when something has been seen without a break.
  struct Sighting {
    int looks = 0;
    double since_s = 0.0;
    HostTime since{};
    /// Whether it has now been seen often and long enough, of the computer's own time at least `host_hold`.
    bool seen(bool now_seen, double now_s, HostTime host, HostTime::duration host_hold);
  };
  struct Track {
    std::deque<std::pair<double, double>> temps;  ///< process time and °C, of a little more than the last minute
    Sighting outside;
    Sighting fast;
    Sighting apart;
  };

  [[nodiscard]] std::optional<std::string> judge(const GuardedUnit& unit, double now_s, HostTime host,
                                                 const hal::ChamberReading* reading);
  [[nodiscard]] std::optional<std::string> judge_air(double now_s, HostTime host, const hal::ChamberReading& reading);
  /// Trouble where the chamber heats all it can, and that for long, to hold its set point.
  [[nodiscard]] std::optional<std::string> judge_heating(double now_s, HostTime host,
                                                         const hal::ChamberReading& reading);

  std::map<std::string, Track> tracks_;  ///< by serial number
  std::optional<double> at_set_point_since_s_;
  std::optional<double> standing_c_;  ///< what the air reads without a change
  double standing_since_s_ = 0.0;
  HostTime standing_since_{};
  std::optional<double> full_heating_since_s_;  ///< at the set point
  HostTime full_heating_since_{};
};

}  // namespace soak::station
