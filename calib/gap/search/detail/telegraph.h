// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/gap/base/campaign_model.h"

namespace soak::calib::gap {

/// Chance that the wander of a sensor's noise only looks like telegraph noise, a bias that jumps to and fro between two
/// levels: by their covariance the two are the same. Over the means of placements two models are compared, the wander
/// of the model's noise (Kalman filter) and two levels with jumps at random times (hidden Markov model, levels, scatter
/// and each run's mean by expectation maximisation, mean times between jumps over a grid): exp(−(ln L₂ − ln L₁ − k/2
/// ln n)), k the parameters that only the second fits. 1 where the sensor has no readings or its noise does not wander.
[[nodiscard]] double chance_of_telegraph(const CampaignModel& model, Sensor sensor);

}  // namespace soak::calib::gap
