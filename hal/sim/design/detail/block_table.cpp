// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/design/detail/block_table.h"

namespace soak::hal::sim {

std::vector<PlannedBlock> planned_blocks(const CampaignCourse& course) {
  std::vector<PlannedBlock> blocks;
  std::size_t rows = 0;
  for (std::size_t i = 0; i < course.moments.size(); ++i) {
    const Moment& moment = course.moments[i];
    if (moment.block < 0) continue;
    const Conditions& now = moment.conditions;
    if (rows++ % kRowsPerBlock == 0) blocks.push_back({i, now.run, moment.set_point, 0.0, now.up});
    blocks.back().temp_c += now.thermometer_c / kRowsPerBlock;
  }
  return blocks;
}

}  // namespace soak::hal::sim
