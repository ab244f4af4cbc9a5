// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "base/result.h"
#include "calib/vocabulary/reference.h"
#include "calib/vocabulary/warning.h"
#include "station/records/signing.h"

namespace soak::station {

/// The waiver with key and signature filled in; what is signed is calib::waiver_text(). Refuses texts of several lines.
[[nodiscard]] base::Result<calib::Waiver> signed_waiver(calib::Waiver waiver, const calib::Reference& reference,
                                                        const SecretKey& key);

/// Refuses (corrupt) a waiver whose signature is not that of its own key over its own text and this entry of the
/// register. Whether that key may sign waivers is for whoever reads the record to judge.
[[nodiscard]] base::Status check_waiver(const calib::Waiver& waiver, const calib::Reference& reference);

/// `waiver_signature` for each waiver of a calibration that check_waiver() would refuse.
[[nodiscard]] std::vector<calib::Warning> waiver_warnings(const std::vector<calib::ReferenceUse>& references);

}  // namespace soak::station
