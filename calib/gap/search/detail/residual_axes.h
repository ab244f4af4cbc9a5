// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/gap/effects/effect.h"

namespace soak::calib::gap {

/// An axis along which something unknown may sit, as free levels: it names no physics.
struct Axis {
  std::string name;  ///< "time since the fixture turned", ...
  Candidate candidate;
};

/// The axes that this campaign can show.
[[nodiscard]] std::vector<Axis> leftover_axes(const Circumstances& circumstances);

}  // namespace soak::calib::gap
