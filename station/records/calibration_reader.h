// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "calib/curve/calibration.h"
#include "calib/vocabulary/warning.h"
#include "db/catalog/catalog.h"

namespace soak::station {

/// A calibration file read from disk and checked.
struct LoadedCalibration {
  base::Bytes bytes;  ///< as they stand in the file
  calib::Calibration calibration;
};

/// Reads and checks a calibration file. Errors name the path.
[[nodiscard]] base::Result<LoadedCalibration> read_calibration(const std::filesystem::path& path);

/// What of the data that a calibration rests on was withdrawn after its fit, as this station knows it: `voided_since`
/// for its runs, and what reference_warnings() says of its references. Runs and references of another station are
/// passed over.
[[nodiscard]] base::Result<std::vector<calib::Warning>> withdrawn_since(const db::Catalog& catalog,
                                                                        const calib::Calibration& calibration);

}  // namespace soak::station
