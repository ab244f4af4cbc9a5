// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace soak::hal::sim {

/// What a program leaves behind.
struct ProgramOutcome {
  int exit_status = 0;  ///< 0 done, else the value of the base::ErrorKind
  std::string output;   ///< for standard output
  std::string errors;   ///< for standard error
};

/// All of soaksim-campaign but its streams; `arguments` without the program's name.
[[nodiscard]] ProgramOutcome run_campaign_program(const std::vector<std::string>& arguments);

}  // namespace soak::hal::sim
