// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "base/result.h"
#include "nav/drive/drive.h"
#include "nav/outages/pipeline.h"

namespace soak::nav {

/// What a filter found of all fixes of a drive, positions or velocities.
struct FixStatistics {
  /// Of the normalised innovations squared, those that the gate left out included: an outlier more or less moves it
  /// little. 2.37 where all standard deviations are right (chi-squared, three degrees of freedom); NaN without fixes.
  double median_nis = 0.0;
  std::size_t left_out = 0;  ///< by the gate
};

/// Innovations of a drive's fixes from the start of the filter on.
struct Innovations {
  std::size_t fixes = 0;
  FixStatistics position;
  FixStatistics velocity;
};

/// Runs the filter through the whole drive with all its fixes. The drive must be validate()d. Fails as align() does.
[[nodiscard]] base::Result<Innovations> innovations_of(const Drive& drive, const FilterPipeline& filter);

}  // namespace soak::nav
