// SPDX-License-Identifier: Apache-2.0
#include "calib/gap/experiment/detail/experiment_batch.h"

#include <fmt/format.h>

#include <utility>

namespace soak::calib::gap {

ExperimentBatch::ExperimentBatch(const LoggedCampaign& campaign, const CampaignModel& model, const RunTemplate& source,
                                 std::vector<Action> actions)
    : actions_(std::move(actions)), extended_(campaign, plan(source), model) {}

std::vector<LoggedRun> ExperimentBatch::plan(const RunTemplate& source) {
  std::vector<LoggedRun> planned;
  for (const Action& action : actions_) {
    double hours = 0.0;
    runs_of_.emplace_back();
    for (const PlannedRun& run : action.runs) {
      runs_of_.back().push_back(static_cast<int>(planned.size()));
      planned.push_back(simulate(source, run, fmt::format("planned {}", planned.size() + 1)));
      hours += hours_of(planned.back());
    }
    hours_.push_back(hours);
  }
  return planned;
}

std::vector<double> ExperimentBatch::gained(const NamedEffect& one, const NamedEffect& other,
                                            const std::vector<const NamedEffect*>& beside) const {
  const Discrimination between(extended_, one, other, beside);
  std::vector<double> squares;
  for (const std::vector<int>& runs : runs_of_) squares.push_back(between.gained(runs));
  return squares;
}

}  // namespace soak::calib::gap
