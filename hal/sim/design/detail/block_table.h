// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "calib/vocabulary/sensor.h"
#include "hal/sim/design/detail/campaign_course.h"

namespace soak::hal::sim {

/// One block of a minute in one position of one visit.
struct PlannedBlock {
  std::size_t first_moment = 0;  ///< of kRowsPerBlock that follow each other
  int run = 0;                   ///< index into CampaignCourse::runs
  int set_point = 0;
  double temp_c = 0.0;  ///< mean of the thermometer, without noise
  calib::Vector3 up{};
};

/// All blocks of the plan, also those of a visit that is dropped, in order of time.
[[nodiscard]] std::vector<PlannedBlock> planned_blocks(const CampaignCourse& course);

/// One number per block, for each sensor; empty = nothing happens to the sensor.
using BlockValues = std::array<std::vector<double>, calib::kSensorCount>;

}  // namespace soak::hal::sim
