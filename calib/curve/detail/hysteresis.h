// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "calib/curve/calibration.h"
#include "calib/curve/sweep_gap.h"
#include "calib/estimate/curve_data.h"

namespace soak::calib {

/// Compares residuals of rows on the way up with those on the way down, bin by bin of temperature. The noise of a
/// difference is its scatter between runs, pooled over the bins, as slow noise within a run hides from the rows' own
/// standard errors; one run alone has nothing but those. Nothing where no temperature was visited both ways in the same
/// run.
[[nodiscard]] std::optional<SweepGap> find_sweep_gap(const CurveData& data, const Curve& curve);

}  // namespace soak::calib
