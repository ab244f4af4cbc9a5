// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "hal/sim/programs/program_options.h"

namespace soak::hal::sim {

/// All of soaksim but its streams and signals: serves the laboratory until `stop_fd` becomes readable. `announce` gets
/// the line for standard output when all listens and station.toml is written.
[[nodiscard]] ProgramOutcome run_soaksim(const std::vector<std::string>& arguments, int stop_fd,
                                         const std::function<void(const std::string&)>& announce);

/// All of soaksim-truth but its streams: what is true of the units of soaksim.
[[nodiscard]] ProgramOutcome run_soaksim_truth(const std::vector<std::string>& arguments);

}  // namespace soak::hal::sim
