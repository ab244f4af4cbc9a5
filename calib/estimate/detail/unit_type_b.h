// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/estimate/unit_rows.h"

namespace soak::calib {

/// Adds to the rows what readings do not show of their errors: the type B inputs of each sensor's curves, and those of
/// misalignment, g-sensitivity and even-order terms with the resulting 95 % half-widths. `used`: the runs that the rows
/// are from.
void state_type_b(const UnitInput& input, const std::vector<const RunInput*>& used, UnitRows& rows);

}  // namespace soak::calib
