// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "calib/deploy/export.h"
#include "calib/deploy/export_kalibr.h"

namespace soak::station {

/// The members "cubic" and "notes" of docs/schema/export.schema.json: what the cubics lose, in deg/s and m/s².
[[nodiscard]] nlohmann::json losses_document(const calib::AutopilotFile& file);
/// The same as a table with the notes under it.
[[nodiscard]] std::string losses_text(const calib::AutopilotFile& file);

/// The member "noise": the values that kalibr reads.
[[nodiscard]] nlohmann::json noise_document(const calib::KalibrSource& source, const calib::KalibrFile& file);
[[nodiscard]] std::string noise_text(const calib::KalibrSource& source, const calib::KalibrFile& file);

}  // namespace soak::station
