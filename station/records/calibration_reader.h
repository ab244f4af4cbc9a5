// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "base/bytes.h"
#include "base/result.h"
#include "calib/curve/calibration.h"

namespace soak::station {

/// A calibration file read from disk and checked.
struct LoadedCalibration {
  base::Bytes bytes;  ///< as they stand in the file
  calib::Calibration calibration;
};

/// Reads and checks a calibration file. Errors name the path.
[[nodiscard]] base::Result<LoadedCalibration> read_calibration(const std::filesystem::path& path);

}  // namespace soak::station
