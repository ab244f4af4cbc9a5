// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "calib/estimate/six_position.h"
#include "calib/vocabulary/sensor.h"

/// Runs that were cut short and went on under a label of their own: "R02" and "R02.2".
namespace soak::calib {

/// The run that a part is of, by its name: "week-1/R02" of "week-1/R02" and of "week-1/R02.2".
[[nodiscard]] std::string_view run_of_part(std::string_view name);

/// Whether other parts of a run show all of a sensor that the positions of one part do not: its scale error at the same
/// temperatures (within 1 K), its couplings, its even-order term. `names`: of the runs of all estimates; `part`: which
/// of them. Never of a run in one part, nor where no estimate is of the part that bears the run's own name: "day.1" and
/// "day.2" are two runs unless there is a "day".
[[nodiscard]] bool shown_by_other_parts(const std::vector<std::string>& names,
                                        const std::vector<SixPositionEstimate>& estimates, std::size_t part,
                                        Sensor sensor);

}  // namespace soak::calib
