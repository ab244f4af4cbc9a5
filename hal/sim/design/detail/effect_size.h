// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/sensor.h"
#include "hal/sim/design/detail/campaign_timeline.h"
#include "hal/sim/effects/hidden_effects.h"
#include "hal/sim/unit/simulated_unit.h"

namespace soak::hal::sim {

/// One block of a minute in one position of one visit.
struct PlannedBlock {
  std::size_t first_moment = 0;  ///< of kRowsPerBlock that follow each other
  int run = 0;                   ///< index into CampaignTimeline::runs
  int set_point = 0;
  double temp_c = 0.0;  ///< mean of the thermometer, without noise
  calib::Vector3 up{};
};

/// All blocks of the plan, also those of a visit that is dropped, in order of time.
[[nodiscard]] std::vector<PlannedBlock> planned_blocks(const CampaignTimeline& timeline);

/// One number per block, for each sensor; empty = nothing happens to the sensor.
using BlockValues = std::array<std::vector<double>, calib::kSensorCount>;

/// What a refitted model without hidden effects can absorb of block means of one sensor, by least squares:
///
///   one free level per set point (or, instead, a cubic in temperature), one offset per run;
///   accelerometers also one free scale per set point and two constant off-axis terms.
class BaseFit {
 public:
  enum class Temperature { levels, cubic };

  BaseFit(const std::vector<PlannedBlock>& blocks, calib::Sensor sensor, Temperature temperature);

  /// What is left of `values`, one per block.
  [[nodiscard]] std::vector<double> residual(std::vector<double> values) const;

 private:
  void add_column(std::vector<double> column);

  std::vector<std::vector<double>> columns_;  ///< orthonormal
};

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
  EffectSizer(const CampaignConfig& config, const CampaignTimeline& timeline, const SimulatedUnit& unit);

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
  const CampaignTimeline& timeline_;
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
