// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/unit_type.h"
#include "station/config/procedure.h"

namespace soak::station {

/// What is wrong with a procedure whose set points, overshoot included, leave the rating of any of the unit types: one
/// text per type, with its rating and the first set point that leaves it. The temperature at which a run ends is a set
/// point too. A type without a rating is a finding: nobody knows what it bears.
[[nodiscard]] std::vector<std::string> rating_findings(const Procedure& procedure,
                                                       const std::vector<calib::UnitType>& types);

/// Refuses (bad_input) a procedure with such findings, and one whose set points leave the chamber's own limits. One
/// finding per line.
[[nodiscard]] base::Status check_ratings(const Procedure& procedure, const std::vector<calib::UnitType>& types,
                                         std::optional<double> chamber_min_c, std::optional<double> chamber_max_c);

}  // namespace soak::station
