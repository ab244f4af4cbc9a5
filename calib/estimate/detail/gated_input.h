// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/model/unit_fit.h"
#include "calib/vocabulary/warning.h"

namespace soak::calib {

/// What the data gate leaves of a unit's runs, and what it says of them.
struct GatedInput {
  UnitInput input;  ///< accepted() segments; a run without any is left out
  std::vector<Warning> warnings;
};

/// One warning per code: that of the first run that has it, and how many more runs do.
[[nodiscard]] GatedInput leave_out_rejected(const UnitInput& input);

}  // namespace soak::calib
