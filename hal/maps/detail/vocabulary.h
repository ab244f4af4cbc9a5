// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <set>
#include <string>
#include <string_view>

namespace soak::hal {

/// What a device of a kind asks its map for.
struct Vocabulary {
  std::set<std::string> quantities;
  std::set<std::string> actions;
};

/// Of a chamber, whatever its controller speaks; beside these its numbered ones.
[[nodiscard]] inline Vocabulary chamber_vocabulary() {
  return {{"air_c", "set_point_c", "working_set_point_c", "output_percent", "control_mode", "actual_mode", "ramp_rate",
           "min_set_point_c", "max_set_point_c", "air_rh_percent"},
          {"start", "stop", "ramp_on", "ramp_off"}};
}

/// Quantities of output n, each followed by its number: docs/register-maps.md says what they mean.
inline constexpr const char* kOutput = "output_";
inline constexpr const char* kChamberOutput = "unit_power_";  ///< in a chamber's map
inline constexpr const char* kState = "state_";
inline constexpr const char* kCurrentTrip = "current_trip_";
inline constexpr const char* kVoltageTrip = "voltage_trip_";
inline constexpr const char* kSetVoltage = "set_v_";
inline constexpr const char* kCurrentLimit = "limit_a_";
inline constexpr const char* kVoltage = "measured_v_";
inline constexpr const char* kCurrent = "measured_a_";

/// Whether the name is one of the beginnings with a number from 1 after it.
[[nodiscard]] inline bool is_numbered(std::string_view name, std::initializer_list<std::string_view> beginnings) {
  for (const std::string_view beginning : beginnings) {
    if (!name.starts_with(beginning)) continue;
    const std::string_view number = name.substr(beginning.size());
    return !number.empty() && number.front() != '0' && number.find_first_not_of("0123456789") == number.npos;
  }
  return false;
}

/// Whether a power switch or supply asks its map for that quantity.
[[nodiscard]] inline bool is_power_quantity(std::string_view name) {
  return is_numbered(name,
                     {kOutput, kState, kCurrentTrip, kVoltageTrip, kSetVoltage, kCurrentLimit, kVoltage, kCurrent});
}

/// Whether a device of kind "chamber" or "power" asks its map for that quantity.
[[nodiscard]] inline bool asks_for(std::string_view kind, const std::string& name) {
  if (kind == "power") return is_power_quantity(name);
  return kind == "chamber" && (chamber_vocabulary().quantities.contains(name) || is_numbered(name, {kChamberOutput}));
}

}  // namespace soak::hal
