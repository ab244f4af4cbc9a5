// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "hal/maps/device_map.h"

namespace soak::hal {

enum class SurveyKind : std::uint8_t { probe, quantity, alarm };

/// What one probe, quantity or alarm of a map gave.
struct SurveyEntry {
  SurveyKind kind = SurveyKind::quantity;
  std::string name;
  std::string place;            ///< "register 2820", "field 1 of 'TEMP?'"
  std::optional<double> value;  ///< of a quantity that was read and is a number
  std::string text;             ///< what was found, for people: "23.25", "auto", "not active (61)"
  std::optional<bool> active;   ///< of an alarm that was read
  std::string trouble;          ///< why it is of no use; empty = it is as it should be
};

/// A live controller as its map describes it.
struct ChamberSurvey {
  std::string description;  ///< map and address
  std::vector<SurveyEntry> entries;

  [[nodiscard]] bool sound() const;
};

/// Reads every probe, quantity and alarm of a map, each by a request of its own, and writes nothing. What fails does
/// not keep the others from being read: the link is opened again where that is needed, which takes a second or more
/// each time. A silence is asked once more. Error (device): the controller cannot be reached, or is lost and does not
/// come back.
[[nodiscard]] base::Result<ChamberSurvey> survey_chamber(const DeviceMap& map);

}  // namespace soak::hal
