// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "base/result.h"
#include "hal/sim/design/detail/base_fit.h"
#include "hal/sim/design/detail/block_table.h"
#include "hal/sim/effects/hidden_effects.h"
#include "hal/sim/unit/simulated_unit.h"

namespace soak::hal::sim {

/// A hidden effect of one unit whose size is known.
struct SizedEffect {
  DrawnEffect drawn;
  double amplitude = 0.0;
  double magnitude = 0.0;
  /// What the effect alone, without noise, adds to each block mean: rad/s or m/s².
  BlockValues contributions;
};

/// How hard effects are to see in a planned campaign. The magnitude of an effect is, by its Measure:
///
///   blocks         RMS, over the blocks and the sensors that are hit, of the part of its contributions to block means
///                  that BaseFit cannot absorb, over the standard deviation of one block mean
///   curve          the same with a cubic in temperature in the place of the free levels, which would absorb all
///   runs           RMS over runs of its mean contribution, the mean of all runs removed, over the standard deviation
///   of
///                  the run offset: a run absorbs all of it
///   block_noise    RMS of the change that it makes to the logarithm of a block's variance, mean removed, over the
///                  standard deviation of that logarithm for white noise, √ψ′((n − 1)/2) with n rows
///   row_noise      its step over the standard deviation of a row
///   clipped_share  ten times the share of the rows in position at the rails, without noise
///
/// pooled over the sensors. Everything is as planned: also blocks of a visit that is dropped count.
class EffectSizer {
 public:
  /// All must outlive the object.
  EffectSizer(const CampaignConfig& config, const CampaignCourse& course, const SimulatedUnit& unit);

  /// The effect that `spec` hides in unit `number`. Errors (bad_input): a magnitude that no amplitude reaches.
  [[nodiscard]] base::Result<SizedEffect> sized(const HiddenSpec& spec, int number) const;

  [[nodiscard]] const std::vector<PlannedBlock>& blocks() const { return blocks_; }

 private:
  [[nodiscard]] BlockValues contributions(const DrawnEffect& drawn, double amplitude) const;
  [[nodiscard]] BlockValues log_variances(const DrawnEffect& drawn, double amplitude) const;
  [[nodiscard]] double magnitude_of(const DrawnEffect& drawn, double amplitude) const;
  [[nodiscard]] base::Result<double> amplitude_for(const DrawnEffect& drawn, double magnitude) const;
  [[nodiscard]] double rail_for(const DrawnEffect& drawn, double share) const;
  [[nodiscard]] double clipped_share(const DrawnEffect& drawn, double rail) const;
  /// Sum over the blocks of the squares that count, for one sensor.
  [[nodiscard]] double sum_of_squares(const DrawnEffect& drawn, calib::Sensor sensor,
                                      const std::vector<double>& values) const;
  [[nodiscard]] double reading(calib::Sensor sensor, const Moment& moment, double element_c) const;

  const CampaignConfig& config_;
  const DesignConfig& design_;
  const CampaignCourse& course_;
  const SimulatedUnit& unit_;
  EffectSurroundings surroundings_;
  std::vector<PlannedBlock> blocks_;
  std::array<std::vector<double>, calib::kSensorCount> readings_;  ///< of each row in a block, without effects
  std::vector<BaseFit> levels_;                                    ///< one per sensor
  std::vector<BaseFit> cubics_;
};

/// What effects of a designed campaign are told about it.
[[nodiscard]] EffectSurroundings design_surroundings(const CampaignConfig& config);

}  // namespace soak::hal::sim
