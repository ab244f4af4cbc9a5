// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "anfis/data/training_data.h"
#include "anfis/model/membership.h"
#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/curve/curve_fit.h"
#include "calib/curve/families.h"
#include "calib/estimate/curve_data.h"

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

/// Rows of one sensor, and which of them in different runs belong together.
struct PlacedRows {
  CurveData data;
  /// Of each row: the same number for rows of different runs at the same plateau and sweep, at most once in a run.
  std::vector<int> place;
  VarianceComponents components;  ///< of all rows
  PartStructure structure;
};

/// Error of the curves that parts of a campaign give, squared units of the rows.
struct SquaredError {
  double value = 0.0;           ///< unbiased: below 0 where noise says so
  double standard_error = 0.0;  ///< of `value`, over campaigns
  double row_variance = 0.0;    ///< of a held-out row about what the runs share
};

/// Fits the structure to the kept rows of several seeded choices of `runs` runs, and judges each on all rows of the
/// other runs (chamber_time.h says how). Nothing where fewer than two runs are left over, the kept rows carry no
/// curve, or the runs have no place in common.
[[nodiscard]] std::optional<SquaredError> subsampled_error(const PlacedRows& rows, const std::vector<bool>& keep,
                                                           int runs, std::uint64_t seed);

/// One number of runs and its error.
struct TrendPoint {
  int runs = 0;
  SquaredError error;
};

/// Error with `runs` runs by weighted least squares of a + b / runs, a and b not below 0; its standard error is that of
/// the last point. Nothing without points.
[[nodiscard]] std::optional<SquaredError> extrapolated_error(const std::vector<TrendPoint>& points, int runs);

}  // namespace soak::calib
