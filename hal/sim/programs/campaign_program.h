// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "hal/sim/programs/program_options.h"

namespace soak::hal::sim {

/// All of soaksim-campaign but its streams; `arguments` without the program's name.
[[nodiscard]] ProgramOutcome run_campaign_program(const std::vector<std::string>& arguments);

}  // namespace soak::hal::sim
