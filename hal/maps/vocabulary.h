// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>

namespace soak::hal {

/// What a device of a kind asks its map for.
struct Vocabulary {
  std::set<std::string> quantities;
  std::set<std::string> actions;
};

/// Of a chamber, whatever its controller speaks.
[[nodiscard]] inline Vocabulary chamber_vocabulary() {
  return {{"air_c", "set_point_c", "working_set_point_c", "output_percent", "control_mode", "actual_mode", "ramp_rate",
           "min_set_point_c", "max_set_point_c"},
          {"start", "stop", "ramp_on", "ramp_off"}};
}

}  // namespace soak::hal
