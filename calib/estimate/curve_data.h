// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/vocabulary/run.h"

namespace soak::calib {

/// One estimate of one quantity (bias or scale error of one sensor) at one temperature: a row of a thermal fit.
struct CurveRow {
  int run = 0;     ///< index into CurveData::runs
  int branch = 0;  ///< monotone piece of the temperature history, numbered over all runs
  Sweep sweep = Sweep::unknown;
  double t_s = 0.0;  ///< device time within the run
  double temp_c = 0.0;
  double value = 0.0;           ///< SI, or ppm
  double standard_error = 0.0;  ///< of `value`, noise of the run's own samples only; 0 = not known
};

/// The rows of a thermal fit.
struct CurveData {
  std::vector<std::string> runs;      ///< labels
  std::vector<std::string> branches;  ///< names, "run 3 up"
  std::vector<CurveRow> rows;
  bool by_plateau = true;  ///< false: rows are blocks of a recording without plateaus
};

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
