// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "nav/outages/pipeline.h"

/// A filter whose readings go through wavelet multi-resolution analysis before [AH05 chapter 4]: three levels of db8,
/// soft thresholds level by level [AH05 eq. 4.15]. At 100 Hz what is slower than 6 Hz stays as it is. Samples are taken
/// for evenly spaced.
namespace soak::nav {

/// As it could run live: thresholds are those of the readings before the filter's start, and a solution uses no later
/// reading than its own time. The last 105 samples before it are not final yet: the filter runs over them as they were
/// read, and anew when they are. Fails as align() does, and (bad_input) where fewer than 105 samples lie before the
/// start.
[[nodiscard]] Pipeline wmra(FilterPipeline filter);

/// The thesis' way: the whole recording at once, thresholds from all of it. It looks ahead: a solution inside the
/// outage knows readings up to the outage's end, and no receiver could give it then. Fails as align() does.
[[nodiscard]] Pipeline wmra_batch(FilterPipeline filter);

/// The readings that wmra() gives to its filter once they are final: thresholds from the first `known` of them. Fails
/// as calib::signal::denoise() does.
[[nodiscard]] base::Result<std::vector<ImuSample>> smoothed_live(std::vector<ImuSample> samples, std::size_t known);

/// The readings that wmra_batch() gives to its filter, thresholds from all of them. Fails likewise.
[[nodiscard]] base::Result<std::vector<ImuSample>> smoothed_batch(std::vector<ImuSample> samples);

}  // namespace soak::nav
