// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "base/result.h"

namespace soak::calib::signal_json {

/// Checks of the samples themselves, NaN where one is missing: what breaks an Allan curve without changing its shape to
/// anything but noise. All are linear in the number of samples.

/// Refuses a record whose samples never change within a stretch (gaps that are bridged do not end one).
[[nodiscard]] base::Status check_changes(std::span<const double> values);

/// Samples far off their neighbours.
struct Outliers {
  std::vector<std::size_t> at;  ///< rising
  double largest_sigma = 0.0;
};

/// Samples more than 8 sigma from the median of the five around them, sigma by the median absolute first difference;
/// none if together they add less than its statistical error to the variance of the noise from sample to sample.
[[nodiscard]] Outliers outliers(std::span<const double> values);

/// The values with the outliers replaced by the median of the five around each.
[[nodiscard]] std::vector<double> without(std::vector<double> values, const Outliers& outliers);

/// A change of level.
struct Step {
  std::size_t at = 0;   ///< index of the first sample behind it, to an eighth of the window that shows it best
  double height = 0.0;  ///< difference of the means behind and before it
};

/// The largest difference between the means of two neighbouring windows, if it stands out from what such differences
/// are in this record: of white and flicker noise and random walk they are all of one size, those of a step are not.
/// Windows of 1/16, 1/64... of the longest stretch.
[[nodiscard]] std::optional<Step> step(std::span<const double> values);

}  // namespace soak::calib::signal_json
