// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/estimate/curve_data.h"
#include "calib/vocabulary/one_way.h"
#include "calib/vocabulary/warning.h"

namespace soak::calib {

/// So far from a temperature that was visited the other way too nothing is said of a row: both ways every 15 K are
/// enough.
inline constexpr double kOtherWayWithin_c = 7.5;

/// The ranges of temperature that were visited one way only, in whichever run.
///
/// A row counts for the way it was reached by and, where the run turns at it, also for the way it was left by: the
/// branches of a loop meet there. It is *one-way* if no row of the other way lies within kOtherWayWithin_c and it is
/// neither at the beginning nor at the end of its run, where a loop may close. A range reaches from such rows to where
/// a row of the other way is that near, else to the outermost row of all. Rows of unknown sweep count for no way.
[[nodiscard]] std::vector<OneWayRange> one_way_ranges(const CurveData& data);

/// "only heating was recorded from -22 to 18 °C and from 32 to 62 °C", in whole °C.
[[nodiscard]] std::string one_way_text(const std::vector<OneWayRange>& ranges);

/// What the bands of a curve hold of hysteresis at such temperatures, as a clause.
[[nodiscard]] std::string one_way_bands_text(HysteresisSource source);

/// Warning `one_way`, in whole °C: that of all sensors of a unit is the same where their thermometer is.
[[nodiscard]] Warning one_way_warning(const OneWay& one_way);

}  // namespace soak::calib
