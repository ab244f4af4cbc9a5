// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "base/bytes.h"
#include "base/result.h"
#include "calib/curve/calibration.h"

namespace soak::calib {

/// The calibration file (docs/blob-format.md). Refuses a calibration that the format cannot carry (non-finite numbers,
/// empty curve, reversed range, too many rules), naming the sensor. A fuzzy model whose own form float32 cannot hold to
/// 1e-6 of its span (cancelling consequents, gaps between rules) is written as a cubic spline that does; refused if no
/// such spline exists.
[[nodiscard]] base::Result<base::Bytes> encode(const Calibration& calibration);

/// Reads a calibration file; curves come back with their float32 coefficients. Refuses anything malformed: bad_input
/// for what is not a calibration file or is of a newer major version, corrupt for one whose check fails.
[[nodiscard]] base::Result<Calibration> decode(std::span<const std::uint8_t> bytes);

}  // namespace soak::calib
