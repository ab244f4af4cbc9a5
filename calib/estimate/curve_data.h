// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
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
  double freedoms = 0.0;        ///< degrees of freedom of that; 0 = many
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

/// How far constants that were measured at one temperature hold.
struct ConstantValidity {
  double temp_min_c = 0.0;  ///< lowest and highest temperature of the sessions
  double temp_max_c = 0.0;
  double within_c = 0.0;  ///< beyond them, as the unit's type says
  /// Largest change per kelvin that the type states, of bias and of scale error, in the units of their curves.
  std::optional<double> bias_per_k = std::nullopt;
  std::optional<double> scale_per_k = std::nullopt;
};

}  // namespace soak::calib
