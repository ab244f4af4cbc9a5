// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "calib/gap/base/campaign_model.h"

namespace soak::calib::gap {

/// What a sensor reads in a placement, in the mean, beyond the model.
struct Reading {
  int run = 0;
  double begin_s = 0.0;
  double end_s = 0.0;
  double value = 0.0;
};

/// The placements of one sensor, a row and a reading each.
struct PlacementMeans {
  Observations observations;
  std::vector<Reading> readings;
  double blocks = 0.0;  ///< of a placement, in the mean
};

/// `left`: what a model leaves of the sensor's readings, one per observation; NaN where there is none.
[[nodiscard]] PlacementMeans placement_means(const Observations& all, const Eigen::VectorXd& left, Sensor sensor);

/// Chance that the wander of a sensor's noise only looks like telegraph noise, a bias that jumps to and fro between two
/// levels: by their covariance the two are the same. Over the means of placements two models are compared, the wander
/// of the model's noise (Kalman filter) and two levels with jumps at random times (hidden Markov model, levels, scatter
/// and each run's mean by expectation maximisation, mean times between jumps over a grid): exp(−(ln L₂ − ln L₁ − k/2
/// ln n)), k the parameters that only the second fits. 1 where the sensor has no readings or its noise does not wander.
[[nodiscard]] double chance_of_telegraph(const CampaignModel& model, Sensor sensor);

}  // namespace soak::calib::gap
