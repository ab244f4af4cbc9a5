// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "base/result.h"
#include "calib/unit_type.h"
#include "station/procedure/procedure.h"

namespace soak::station {

/// Refuses (bad_input) a procedure whose set points, overshoot included, leave the rating of any of the unit types, or
/// the chamber's own limits; the message names every type, its rating and the first set point that leaves it. A type
/// without a rating is refused too: nobody knows what it bears.
[[nodiscard]] base::Status check_ratings(const Procedure& procedure, const std::vector<calib::UnitType>& types,
                                         std::optional<double> chamber_min_c, std::optional<double> chamber_max_c);

}  // namespace soak::station
