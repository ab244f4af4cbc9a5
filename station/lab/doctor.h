// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "db/catalog/catalog.h"
#include "station/config/station_config.h"

namespace soak::station {

enum class CheckOutcome : std::uint8_t {
  ok,
  warning,  ///< works, but somebody should know
  failed,
};

/// One thing that was looked at.
struct DoctorCheck {
  std::string subject;  ///< "slot 1", "disk"
  CheckOutcome outcome = CheckOutcome::ok;
  std::string text;                                ///< what was found, and where it failed what to do
  base::ErrorKind kind = base::ErrorKind::device;  ///< of a failure
};

/// Whether what the configuration names is there and may be used by this user: serial ports of chamber, fixture, power
/// switch and slots, USB devices. Opens none of them, so that it can look while `soakd` runs; what has a network
/// address is listed and not tried.
[[nodiscard]] std::vector<DoctorCheck> check_devices(const StationConfig& config);

/// Whether the folder can be written to, and the space that is left there.
[[nodiscard]] DoctorCheck check_disk_space(const std::filesystem::path& folder);

/// Of a folder without a catalog. `is_new`: it may be that of a station that was never started, so that this is a
/// warning; else (bad_input) it is no data folder.
[[nodiscard]] DoctorCheck missing_catalog(const std::filesystem::path& folder, bool is_new);

/// SQLite's integrity check and foreign keys.
[[nodiscard]] DoctorCheck check_database(const base::Result<db::Catalog>& catalog);

/// Whether the computer's clock is kept by a time service, and whether it stands before the newest run.
[[nodiscard]] DoctorCheck check_clock(const db::Catalog* catalog, double now_utc_s);

}  // namespace soak::station
