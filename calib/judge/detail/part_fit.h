// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "anfis/data/training_data.h"
#include "anfis/model/membership.h"
#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/curve/curve_fit.h"

namespace soak::calib {

/// What is fitted to a part of a campaign: the structure that the whole campaign led to.
struct PartStructure {
  Family family = Family::spline;
  int rules = 0;  ///< of the ANFIS
  anfis::Shape shape = anfis::Shape::bell;
};

/// The structure of a curve as deployed.
[[nodiscard]] PartStructure structure_of(const CurveFit& fit);

struct PartCurve {
  Curve curve;
  double parameters = 1.0;  ///< at least so many describe its shape
};

/// Fits that structure. With fewer temperatures than its rules need the ANFIS has as many rules as a search would try
/// (two temperatures more than consequents); under two rules, and for a polynomial with too few temperatures, the
/// smoothing spline stands in.
[[nodiscard]] base::Result<PartCurve> fit_part(const anfis::TrainingData& rows, const PartStructure& structure);

}  // namespace soak::calib
