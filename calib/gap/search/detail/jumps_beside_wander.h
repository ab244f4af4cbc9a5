// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/gap/base/campaign_model.h"

namespace soak::calib::gap {

/// Chance that the wander of a sensor's noise only looks like one beside which the bias jumps to and fro between two
/// levels. By their covariance levels and a Gauss-Markov process of half the mean stay are the same, so that the noise
/// of the model holds the jumps as wander; but a jump comes at once. Over the means of placements two models are
/// compared: such levels, and such a process or none (Kalman filter), each beside what it leaves of the wander. For
/// each path of jumps the first is a Kalman filter too; the paths that the readings make most likely are followed and
/// their densities summed [Ackerson and Fu 1970]. Variance and mean stay are those of the largest density L, in each
/// model by itself. The two have the same parameters, so that neither pays for more of them; the chance is L₁/L₂: where
/// the process is the truth, a ratio above x has a chance of at most 1/x [Markov's inequality]. 1 where the sensor has
/// no readings or its noise does not wander. A jump within a placement is taken for one before or after it.
[[nodiscard]] double chance_of_jumps_beside_wander(const CampaignModel& model, Sensor sensor);

}  // namespace soak::calib::gap
