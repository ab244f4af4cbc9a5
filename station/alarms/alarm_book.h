// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "station/access/ration.h"

namespace soak::station {

/// What somebody is to be told of an alarm.
enum class AlarmTurn : std::uint8_t {
  began,
  ended,
  held_back,  ///< it began, but too many have begun of late
};

/// Which alarms somebody has been told of: each once when it begins and once when it ends; the end of a campaign once,
/// however it is called while the station is made safe and afterwards. One that lasts less than
/// kHolds_s is passed over; one that comes back within kStaysAway_s has not ended. Beyond kMostAtOnce in a row those
/// that begin are held back: one more is told every kOneReturnsAfter_s.
class AlarmBook {
 public:
  static constexpr double kHolds_s = 3.0;
  static constexpr double kStaysAway_s = 6.0;
  static constexpr double kMostAtOnce = 20.0;
  static constexpr double kOneReturnsAfter_s = 180.0;

  struct Entry {
    AlarmTurn turn;
    nlohmann::json alarm;  ///< of alarms_of()
  };

  /// Whether an alarm with that code, about that, may last though it is not among those that are seen.
  using MayLast = std::function<bool(std::string_view code, std::string_view about)>;

  /// What is to be told now. `alarms`: those of a status document; those that do not call are left out. `now_s`: of a
  /// clock that does not go back. What may last has not ended, unless it was gone already when that began.
  [[nodiscard]] std::vector<Entry> take(const nlohmann::json& alarms, double now_s, const MayLast& may_last);

 private:
  struct Known {
    nlohmann::json alarm;
    double since_s = 0.0;
    double seen_s = 0.0;
    bool is_told = false;
    bool is_held_back = false;
    bool was_missed = false;  ///< it was not seen when it should have been
  };

  void begin(Known& known, double now_s, std::vector<Entry>& entries);

  std::map<std::pair<std::string, std::string>, Known> known_;  ///< by code and what it is about
  Ration ration_{kMostAtOnce, kOneReturnsAfter_s};
};

/// Whether the engine turns: it publishes a status, whose clock goes on, again and again.
class EngineTurns {
 public:
  /// Long enough for the slowest device and the sealing of a run, and well before the watch switches the chamber off.
  static constexpr double kStuck_s = 60.0;

  /// Whether that version of the status has not risen for kStuck_s. `now_s`: of a clock that does not go back.
  [[nodiscard]] bool stand_still(std::uint64_t version, double now_s);

 private:
  std::optional<std::uint64_t> version_;
  double rose_s_ = 0.0;
};

}  // namespace soak::station
