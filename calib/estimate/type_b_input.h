// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace soak::calib {

/// A contribution to a curve's uncertainty that the scatter of the runs does not show (JCGM 100:2008, 4.3): standard
/// uncertainty √(constant² + (per_kelvin·db/dT)²), the same in every run, so no number of runs lessens it.
struct TypeBInput {
  std::string name = {};       ///< as Contribution::name
  bool stated = true;          ///< false: nobody has said how large it is
  double constant = 0.0;       ///< in the unit of the curve
  double temperature_c = 0.0;  ///< standard uncertainty of the temperature that the curve is drawn over
  std::string basis = {};      ///< as Contribution::basis
};

}  // namespace soak::calib
