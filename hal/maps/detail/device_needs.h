// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "hal/maps/device_map.h"

/// What a device of a kind asks its map for, whatever its controller speaks.
namespace soak::hal {

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
[[nodiscard]] bool is_numbered(std::string_view name, std::initializer_list<std::string_view> beginnings);

/// Whether a device of the map's kind asks for that quantity.
[[nodiscard]] bool asks_for(const DeviceMap& map, const std::string& quantity);

/// The actions that a device of the map's kind runs.
[[nodiscard]] std::set<std::string> known_actions(const DeviceMap& map);

/// Collects what a map lacks, one sentence each, each once.
class Needs {
 public:
  explicit Needs(const DeviceMap& map) : map_(map) {}

  /// Each returns whether the map has it.
  bool quantity(const std::string& name);
  bool writable(const std::string& name);
  bool code(const std::string& name, const std::string& code);
  void note(std::string sentence);

  [[nodiscard]] const std::vector<std::string>& sentences() const { return sentences_; }

 private:
  const DeviceMap& map_;
  std::vector<std::string> sentences_;
};

/// What a map lacks to work a device of its kind, one sentence each; empty = nothing. Of a fixture that is told angles
/// the reader of its [axes] tells it.
[[nodiscard]] std::vector<std::string> device_needs(const DeviceMap& map);

}  // namespace soak::hal
