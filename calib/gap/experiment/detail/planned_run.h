// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "calib/gap/experiment/detail/run_template.h"

namespace soak::calib::gap {

/// A plateau of a run that is yet to be made.
struct PlannedVisit {
  std::size_t copy_of = 0;  ///< visit of the template that gives positions and their times
  double plateau_c = 0.0;   ///< set point
  double temp_c = 0.0;      ///< where the unit's thermometer comes to rest
  double soak_s = 0.0;      ///< from the arrival of the air to the first position
  Sweep sweep = Sweep::unknown;
};

/// A run that is yet to be made, from one power-on to the next.
struct PlannedRun {
  std::vector<PlannedVisit> visits;
  Settling settling;
  double start_c = 0.0;   ///< of air and unit at power-on
  double turn_deg = 0.0;  ///< of the whole fixture about the vertical, clockwise seen from above
};

/// The run as a recording of it would look, with a count of 1 and a mean of 0 in every block of every sensor: readings
/// are for others to predict. The temperature follows `settling` in steps of 10 s; compressor and supply are those of
/// the template at the same moment of the visit, its mean on the way.
[[nodiscard]] LoggedRun simulate(const RunTemplate& source, const PlannedRun& plan, const std::string& label);

/// From power-on to the end of the last segment, hours.
[[nodiscard]] double hours_of(const LoggedRun& run);

}  // namespace soak::calib::gap
