// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/gap/experiment/detail/discrimination.h"
#include "calib/gap/experiment/detail/experiment_actions.h"

namespace soak::calib::gap {

/// Actions simulated together: regressors of all of them are made once. Neither copied nor moved.
class ExperimentBatch {
 public:
  ExperimentBatch(const LoggedCampaign& campaign, const CampaignModel& model, const RunTemplate& source,
                  std::vector<Action> actions);

  [[nodiscard]] const std::vector<Action>& actions() const { return actions_; }
  /// Of the chamber, per action.
  [[nodiscard]] const std::vector<double>& hours() const { return hours_; }
  /// Squared distance between the two that each action adds.
  [[nodiscard]] std::vector<double> gained(const NamedEffect& one, const NamedEffect& other,
                                           const std::vector<const NamedEffect*>& beside) const;

 private:
  /// Simulates the actions' runs and notes which are whose.
  std::vector<LoggedRun> plan(const RunTemplate& source);

  std::vector<Action> actions_;
  std::vector<double> hours_;
  std::vector<std::vector<int>> runs_of_;
  ExtendedCampaign extended_;
};

}  // namespace soak::calib::gap
