// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "hal/devices/survey.h"
#include "hal/maps/device_map.h"

namespace soak::station {

/// "tcp 10.0.0.7:502", "serial /dev/ttyUSB0 at 9600 baud, 8N1": where the controller of a map is.
[[nodiscard]] std::string address_text(const hal::DeviceMap& map);

/// "probe", "quantity", "alarm".
[[nodiscard]] std::string kind_text(hal::SurveyKind kind);

/// What a live controller said: docs/schema/chamber-probe.schema.json.
[[nodiscard]] nlohmann::json survey_document(const hal::DeviceMap& map, const hal::ChamberSurvey& survey);

}  // namespace soak::station
