// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "calib/gap/search/campaign_model.h"

namespace soak::calib::gap {

/// A campaign with runs appended that are yet to be made: what regressors are there. Neither copied nor moved, as its
/// parts refer to each other.
class ExtendedCampaign {
 public:
  /// `model`: fitted to the campaign's own runs; gives noise, curve and how far the curve's slope may be off.
  ExtendedCampaign(const LoggedCampaign& campaign, const std::vector<LoggedRun>& planned, const CampaignModel& model);
  ExtendedCampaign(const ExtendedCampaign&) = delete;
  ExtendedCampaign& operator=(const ExtendedCampaign&) = delete;

  [[nodiscard]] Circumstances circumstances() const { return {observations_, courses_, slope_}; }
  /// Of each observation: −1 in a run that was made, else the ordinal of the planned run.
  [[nodiscard]] const std::vector<int>& planned_run() const { return planned_run_; }
  /// Whether the model has that sensor.
  [[nodiscard]] bool has(Sensor sensor) const { return base_.at(index_of(sensor)).size() > 0; }
  /// Columns of the base in all runs, whitened.
  [[nodiscard]] Eigen::MatrixXd base(Sensor sensor) const { return whiten(sensor, base_.at(index_of(sensor))); }
  /// Per column of the base, the reciprocal standard deviation of its coefficient; 0 = free.
  [[nodiscard]] const Eigen::VectorXd& prior(Sensor sensor) const { return prior_.at(index_of(sensor)); }
  /// Whitened rows of columns that have one row per observation.
  [[nodiscard]] Eigen::MatrixXd whiten(Sensor sensor, const Eigen::MatrixXd& columns) const;
  /// Observation that whitened row i belongs to, in the order of runs.
  [[nodiscard]] const std::vector<Eigen::Index>& rows(Sensor sensor) const;

 private:
  LoggedCampaign campaign_;
  Observations observations_;
  Courses courses_;
  std::vector<int> planned_run_;
  std::array<Eigen::VectorXd, kSensorCount> slope_;
  std::array<Eigen::MatrixXd, kSensorCount> base_;
  std::array<Eigen::VectorXd, kSensorCount> prior_;
  std::vector<std::optional<Whitening>> whitening_;
};

}  // namespace soak::calib::gap
