// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "calib/gap/base/campaign_model.h"
#include "calib/gap/experiment/detail/experiment_actions.h"
#include "calib/gap/search/search.h"

namespace soak::calib::gap {

/// A campaign with runs appended that are yet to be made: what regressors are there. Neither copied nor moved, as its
/// parts refer to each other.
class ExtendedCampaign {
 public:
  /// `model`: fitted to the campaign's own runs; gives noise, curve and how far the curve's slope may be off.
  ExtendedCampaign(const LoggedCampaign& campaign, const std::vector<LoggedRun>& planned, const CampaignModel& model);
  ExtendedCampaign(const ExtendedCampaign&) = delete;
  ExtendedCampaign& operator=(const ExtendedCampaign&) = delete;

  [[nodiscard]] RegressorInputs regressor_inputs() const { return {observations_, history_, slope_}; }
  /// Of each observation: −1 in a run that was made, else the ordinal of the planned run.
  [[nodiscard]] const std::vector<int>& proposed_run() const { return proposed_run_; }
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
  TemperatureHistory history_;
  std::vector<int> proposed_run_;
  std::array<Eigen::VectorXd, kSensorCount> slope_;
  std::array<Eigen::MatrixXd, kSensorCount> base_;
  std::array<Eigen::VectorXd, kSensorCount> prior_;
  std::vector<std::optional<Whitening>> whitening_;
};

/// How far apart two explanations of a campaign are, and how much farther a planned run would set them.
///
/// The distance from one to the other is the part of the first one's prediction, whitened, that the base with the
/// other's columns cannot follow, whatever its parameters and the best of its shapes; it is what a χ² of the wrong
/// explanation would grow by. The prediction holds the parameters that were estimated from the runs made.
class Discrimination {
 public:
  /// `beside`: effects that belong to the base in either case.
  Discrimination(const ExtendedCampaign& extended, const NamedEffect& one, const NamedEffect& other,
                 const std::vector<const NamedEffect*>& beside);

  /// By how much the squared distance grows with the given planned runs, of the two directions the lesser; 0 where that
  /// is below what rounding could make of it.
  [[nodiscard]] double gained(const std::vector<int>& proposed_runs) const;

 private:
  struct Shape {
    Eigen::Index first = 0;  ///< column
    Eigen::Index count = 0;
  };
  /// All shapes of an effect and its prediction, as columns beside the base.
  struct Side {
    bool shared = false;
    std::vector<Shape> shapes;
    Eigen::Index prediction = 0;
  };
  /// Scalar products of the whitened columns (base, shapes, predictions), one matrix per run: that of all runs made
  /// first.
  struct SensorProducts {
    std::vector<Eigen::MatrixXd> of_run;
    Eigen::Index base = 0;  ///< the first so many columns
    Eigen::VectorXd prior;
  };
  using Products = std::array<Eigen::MatrixXd, kSensorCount>;

  void add(const ExtendedCampaign& extended, Sensor sensor, const Eigen::MatrixXd& base,
           const Eigen::MatrixXd& columns);
  [[nodiscard]] Products beside_the_base(const std::vector<int>& proposed_runs) const;
  [[nodiscard]] static double distance(const Products& products, const Side& from, const Side& to);

  std::array<SensorProducts, kSensorCount> sensor_;
  std::array<Side, 2> side_;
};

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
