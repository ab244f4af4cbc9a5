// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/gap/campaign/campaign.h"
#include "calib/gap/observations/observations.h"

namespace soak::calib::gap::ramps {

/// The temperatures of a branch: rows of a run between two turns of the temperature.
struct RampBranch {
  Sweep sweep = Sweep::unknown;  ///< up or down
  double low_c = 0.0;
  double high_c = 0.0;
};

/// Runs in one attitude without plateaus: their blocks as rows, and the branches that these belong to.
struct RampRecording {
  /// Its two levels are the ends of the range of temperature; cells and placements mean nothing here.
  Observations observations;
  std::vector<RampBranch> branches;
  std::vector<int> branch;  ///< of each row: index into `branches`
};

/// Blocks of all segments without a plateau that the data gate accepts, whether the recorder called them ramp or soak,
/// cut into branches where the temperature turns by more than 5 K; a branch of fewer than 8 blocks or less than 10 K is
/// dropped with its rows. Nothing where some segment lies at a plateau or the unit stood in more than one position:
/// then the campaign is not of this kind. Cost linear in blocks.
[[nodiscard]] std::optional<RampRecording> ramp_recording(const LoggedCampaign& campaign);

/// What is predicted in turn from all the rest.
struct FoldPlan {
  std::vector<int> fold;  ///< of each row; −1 = always in the training
  int count = 0;
  bool halves = false;  ///< of the one difference that two branches have
};

/// With three branches or more, each branch. With two, the lower and the upper half of the first one, where the second
/// covers it: parameters from one half of the difference between the branches must predict the other half. Nothing
/// with fewer, with branches that all go one way, and with two that share less than 20 K.
[[nodiscard]] std::optional<FoldPlan> plan_folds(const RampRecording& recording);

}  // namespace soak::calib::gap::ramps
