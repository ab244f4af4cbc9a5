// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/gap/ramps/detail/ramp_recording.h"

namespace soak::calib::gap::reduced {

/// What is left out in turn.
struct FoldPlan {
  std::vector<int> fold;  ///< of each row; −1 = always in the training
  int count = 0;
  bool halves = false;  ///< of the one difference that two branches have
};

/// With three branches or more, each branch. With two, the lower and the upper half of the first one, where the second
/// covers it: parameters from one half of the difference between the branches must predict the other half. Nothing
/// with fewer, with branches that all go one way, and with two that share less than 20 K.
[[nodiscard]] std::optional<FoldPlan> plan_folds(const RampRecording& recording);

}  // namespace soak::calib::gap::reduced
