// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "calib/vocabulary/recording.h"

namespace soak::hal::sim {

/// First line of a CSV file, with its line end.
inline constexpr std::string_view kCsvHeader =
    "t_s,run,phase,sweep,plateau_c,position,chamber_c,temp_c,gx_dps,gy_dps,gz_dps,ax_mps2,ay_mps2,az_mps2\n";

/// Appends one line per row of a recording that simulate_run() made. Decimals are fixed: 1e-5 deg/s, 1e-5 m/s², 1e-4
/// °C.
void append_csv_rows(const calib::Recording& recording, std::string& csv);

}  // namespace soak::hal::sim
