// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "hal/sim/lab/simulated_chamber.h"

namespace soak::hal::sim {

/// The answer of an ESPEC P300 that controls the chamber to a line, both without their ends: TEMP?, MODE?, ALARM?,
/// MON?, "TEMP, S25.0", "MODE,CONSTANT", "MODE,STANDBY"; "NA:..." to anything else.
[[nodiscard]] std::string espec_answer(SimulatedChamber& chamber, std::string_view line);

}  // namespace soak::hal::sim
