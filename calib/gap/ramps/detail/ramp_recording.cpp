// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/ramps/detail/ramp_recording.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "calib/estimate/branches.h"
#include "calib/segments/data_gate.h"

namespace soak::calib::gap::ramps {
namespace {

constexpr double kTurn_c = 5.0;
constexpr double kLeastSpan_c = 10.0;
constexpr std::size_t kLeastBlocks = 8;

/// Blocks of a run in the order of time, without what the data gate rejected.
std::vector<Observation> rows_of_run(const LoggedRun& run, int number) {
  std::vector<Observation> rows;
  for (const Segment& segment : accepted(run.run.segments)) {
    for (const Block& block : segment.blocks) {
      Observation& row = rows.emplace_back();
      row.run = number;
      row.t_s = block.t_s;
      row.temp_c = block.temp_c;
      row.sensor_temp_c = block.sensor_temp_c;
      row.sensor = block.sensor;
    }
  }
  std::sort(rows.begin(), rows.end(), [](const Observation& a, const Observation& b) { return a.t_s < b.t_s; });
  return rows;
}

void add_branch(const std::vector<Observation>& rows, const Branch& branch, RampRecording& recording) {
  if (branch.sweep == Sweep::unknown || branch.last - branch.first < kLeastBlocks) return;
  const auto first = rows.begin() + static_cast<std::ptrdiff_t>(branch.first);
  const auto last = rows.begin() + static_cast<std::ptrdiff_t>(branch.last);
  const auto [low, high] =
      std::minmax_element(first, last, [](const Observation& a, const Observation& b) { return a.temp_c < b.temp_c; });
  if (high->temp_c - low->temp_c < kLeastSpan_c) return;
  const int number = static_cast<int>(recording.branches.size());
  recording.branches.push_back({branch.sweep, low->temp_c, high->temp_c});
  for (auto row = first; row != last; ++row) {
    recording.observations.rows.push_back(*row);
    recording.observations.rows.back().sweep = branch.sweep;
    recording.branch.push_back(number);
  }
}

/// Whether the campaign has blocks, all of them off plateaus and in one position.
bool is_ramp(const LoggedCampaign& campaign) {
  const Segment* any = nullptr;
  for (const LoggedRun& run : campaign.runs) {
    for (const Segment& segment : run.run.segments) {
      if (segment.blocks.empty()) continue;
      if (segment.plateau_c || (any != nullptr && any->position != segment.position)) return false;
      any = &segment;
    }
  }
  return any != nullptr;
}

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

std::optional<RampRecording> ramp_recording(const LoggedCampaign& campaign) {
  if (!is_ramp(campaign)) return std::nullopt;
  RampRecording recording;
  for (std::size_t r = 0; r < campaign.runs.size(); ++r) {
    const std::vector<Observation> rows = rows_of_run(campaign.runs[r], recording.observations.run_count());
    if (rows.empty()) continue;
    recording.observations.runs.push_back(campaign.runs[r].run.label);
    recording.observations.logged.push_back(r);
    std::vector<double> temps;
    for (const Observation& row : rows) temps.push_back(row.temp_c);
    for (const Branch& branch : find_branches(temps, kTurn_c)) add_branch(rows, branch, recording);
  }
  const auto& rows = recording.observations.rows;
  const auto [low, high] = std::minmax_element(
      rows.begin(), rows.end(), [](const Observation& a, const Observation& b) { return a.temp_c < b.temp_c; });
  if (!rows.empty()) recording.observations.level_c = {low->temp_c, high->temp_c};
  return recording;
}

std::optional<FoldPlan> plan_folds(const RampRecording& recording) {
  const auto& branches = recording.branches;
  const bool both_ways = std::any_of(branches.begin(), branches.end(),
                                     [&](const RampBranch& branch) { return branch.sweep != branches.front().sweep; });
  if (!both_ways) return std::nullopt;
  if (branches.size() == 2) return halves_of(recording);
  FoldPlan plan;
  plan.fold = recording.branch;
  plan.count = static_cast<int>(branches.size());
  return plan;
}

}  // namespace soak::calib::gap::ramps
