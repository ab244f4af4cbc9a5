// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "base/result.h"
#include "nav/drive/drive.h"

namespace soak::station {

/// The fixes of a text file. A header line names the columns, in any order; more columns are passed over:
/// - RTKLIB (.pos): the header begins with %, columns stand apart by blanks, GPST is date and time (or seconds):
///   `latitude(deg) longitude(deg) height(m) sdn(m) sde(m) sdu(m) vn(m/s) ve(m/s) vu(m/s) sdvn sdve sdvu`;
/// - CSV: `t_s,latitude_deg,longitude_deg,height_m,sd_north_m,sd_east_m,sd_up_m,v_north_mps,v_east_mps,v_up_mps,
///   sd_v_north_mps,sd_v_east_mps,sd_v_up_mps`.
/// Times of dates are seconds since 1970-01-01 without leap seconds. Refuses (bad_input) a column that is missing and a
/// value that is no number, with its line.
[[nodiscard]] base::Result<std::vector<nav::GnssFix>> read_solutions(const std::filesystem::path& path);

}  // namespace soak::station
