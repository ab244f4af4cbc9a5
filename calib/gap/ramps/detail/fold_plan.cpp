// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/ramps/detail/fold_plan.h"

#include <algorithm>
#include <cstddef>

namespace soak::calib::gap::reduced {
namespace {

constexpr double kLeastCommon_c = 20.0;

std::optional<FoldPlan> halves_of(const RampRecording& recording) {
  const double low_c = std::max(recording.branches[0].low_c, recording.branches[1].low_c);
  const double high_c = std::min(recording.branches[0].high_c, recording.branches[1].high_c);
  if (high_c - low_c < kLeastCommon_c) return std::nullopt;
  FoldPlan plan;
  plan.halves = true;
  plan.count = 2;
  for (std::size_t i = 0; i < recording.branch.size(); ++i) {
    const double temp_c = recording.observations.rows[i].temp_c;
    const bool common = recording.branch[i] == 0 && temp_c >= low_c && temp_c <= high_c;
    plan.fold.push_back(common ? (temp_c < 0.5 * (low_c + high_c) ? 0 : 1) : -1);
  }
  return plan;
}

}  // namespace

std::optional<FoldPlan> plan_folds(const RampRecording& recording) {
  const auto& branches = recording.branches;
  const bool both_ways = std::any_of(branches.begin(), branches.end(),
                                     [&](const Branch& branch) { return branch.sweep != branches.front().sweep; });
  if (!both_ways) return std::nullopt;
  if (branches.size() == 2) return halves_of(recording);
  FoldPlan plan;
  plan.fold = recording.branch;
  plan.count = static_cast<int>(branches.size());
  return plan;
}

}  // namespace soak::calib::gap::reduced
