// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "base/result.h"
#include "calib/estimate/moves.h"
#include "calib/estimate/site.h"
#include "calib/estimate/six_position.h"
#include "calib/vocabulary/segment.h"
#include "calib/vocabulary/unit_type.h"

namespace soak::calib {

/// Estimation of one unit in one session at one temperature, in attitudes that nobody knows (is_found_rest()).
///
/// Accelerometers: calibrate_triad(), raw = K·f + b with an upper triangular K = diag(1 + S) + M, whose axes are the
/// accelerometers' own: z the input axis of the z accelerometer, y in the plane of those of y and z. The entries of M
/// below the diagonal are 0 by that choice, and so is their error. Where the attitudes do not show all of M, none of it
/// is stated and it counts as 0 (a warning says so).
///
/// Gyros: at rest raw = b + G·f + d·τ + Ω_v up + e, weighted least squares over the attitudes, with a line in time τ
/// from ten attitudes on. Ω_v is subtracted where the latitude is known. e holds noise and the horizontal rotation of
/// the Earth, whose direction is not known; residuals beyond that (χ² above its 80 % quantile) inflate the errors.
///
/// One PlateauEstimate per sensor. Refuses (bad_input) what calibrate_triad() refuses, an accelerometer that reads 20 %
/// off gravity, and attitudes without all three accelerometers.
[[nodiscard]] base::Result<SixPositionEstimate> estimate_attitudes(std::span<const Segment> segments,
                                                                   const Place& place, const UnitType& type);

/// Adds what movements between rests show of the gyros (estimate_gains()): their scale errors, where no rate position
/// has shown them, and their misalignment. The accelerometers' part of `estimate` says where up is in each rest;
/// nothing is added where it does not know their bias and scale. Warns of what stands in the way (docs/fit.md:
/// `turns_...`). Refuses gyros that contradict the movements.
[[nodiscard]] base::Status add_gains(std::span<const Segment> segments, std::span<const Move> moves,
                                     const UnitType& type, SixPositionEstimate& estimate);

}  // namespace soak::calib
