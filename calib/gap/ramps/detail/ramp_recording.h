// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/gap/campaign/campaign.h"
#include "calib/gap/observations/observations.h"

namespace soak::calib::gap::reduced {

/// Rows of a run between two turns of the temperature.
struct Branch {
  Sweep sweep = Sweep::unknown;  ///< up or down
  double low_c = 0.0;
  double high_c = 0.0;
};

/// Runs in one attitude without plateaus: their blocks as rows, and the branches that these belong to.
struct RampRecording {
  Observations observations;  ///< levels, cells and placements mean nothing here
  std::vector<Branch> branches;
  std::vector<int> branch;  ///< of each row: index into `branches`
};

/// Blocks of all segments without a plateau, cut into branches where the temperature turns by more than 5 K; a branch
/// of fewer than 8 blocks or less than 10 K is left out with its rows. Segments that the data gate rejected are left
/// out. Nothing where some segment lies at a plateau or the unit stood in more than one position: then the campaign is
/// not of this kind. Cost linear in blocks.
[[nodiscard]] std::optional<RampRecording> ramp_recording(const LoggedCampaign& campaign);

}  // namespace soak::calib::gap::reduced
