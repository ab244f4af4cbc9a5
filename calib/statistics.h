// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "calib/segment.h"

namespace soak::calib {

/// Straight line y = mean_y + slope·(x − mean_x) by least squares; slope 0 where x does not vary.
struct Line {
  double mean_x = 0.0;
  double mean_y = 0.0;
  double slope = 0.0;
};
[[nodiscard]] Line fit_line(std::span<const double> x, std::span<const double> y);

/// Statistics of a stretch of equally spaced samples; NaN samples are passed over.
///
/// `variance` is that of the samples about their mean. `standard_error` is that of the mean as
/// signal::standard_error_of_mean() states it: under the correlation that the samples show, never below the Allan
/// deviation at the length of the stretch. Cost linear in the length.
[[nodiscard]] SensorStatistics describe(std::span<const double> samples);

}  // namespace soak::calib
