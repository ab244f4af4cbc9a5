// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "calib/vocabulary/sensor.h"
#include "calib/vocabulary/unit_type.h"

namespace soak::station {

/// What a type allows the noise of a sensor, in deg/s/√Hz or m/s²/√Hz: the square root of the one-sided spectrum of its
/// white part, as pre-flight judges it (docs/procedures.md). Absent where it states none.
[[nodiscard]] std::optional<double> noise_limit(const calib::UnitType& type, calib::Sensor sensor);

/// A document of `soak signal allan` of a sensor at rest, or {"reason"}, beside that limit: one of `sensors` of
/// docs/schema/http-unit-noise.schema.json. The density is √2 N: N is that of the two-sided spectrum, by
/// σ²(τ) = N²/τ for white noise. `verdict`: inside, outside, no_limit, not_known. White noise that the curve shows no
/// trace of is inside only if what may have stayed hidden is.
[[nodiscard]] nlohmann::json judged_noise(const nlohmann::json& allan, calib::Sensor sensor,
                                          std::optional<double> limit);

}  // namespace soak::station
