// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "calib/vocabulary/recording.h"
#include "calib/vocabulary/sensor.h"
#include "hal/sim/campaign/run_plan.h"
#include "hal/sim/config/campaign_config.h"
#include "hal/sim/unit/simulated_unit.h"

namespace soak::hal::sim {

/// Temperatures of a unit and of the chamber's air through one run, without noise.
class RunTemperature {
 public:
  RunTemperature(const CampaignConfig& config, const std::vector<Visit>& visits, std::uint64_t run_seed);

  /// Temperature of the unit, which all its sensors and its thermometer share: an exponential approach to where the
  /// visit settles, then also the linear drift of the plateau.
  [[nodiscard]] double unit_c(std::size_t visit, double t_s) const;

  /// Temperature of the air: exponential approach to the set point.
  [[nodiscard]] double chamber_c(std::size_t visit, double t_s) const;

 private:
  struct VisitTemperature {
    Visit visit;
    double from_c = 0.0;          ///< the unit when the set point changed
    double settled_c = 0.0;       ///< where the unit's approach ends
    double drift_c = 0.0;         ///< over the plateau
    double chamber_from_c = 0.0;  ///< the set point before
  };

  ThermometerMagnitudes thermometer_;
  ChamberMagnitudes chamber_;
  std::vector<VisitTemperature> visits_;
};

/// Noise of one sensor through one run: white noise plus first-order Gauss-Markov processes of equal variance. The mean
/// of one segment has the standard deviation `segment_mean_sigma` of the sensor, whatever the rows of a segment are.
class SensorNoise {
 public:
  SensorNoise(const CampaignConfig& config, calib::Sensor sensor, std::uint64_t run_seed);

  /// Noise of row `index` at `t_s`, rad/s or m/s². Rows are asked for in order of time.
  [[nodiscard]] double at(std::uint64_t index, double t_s);

 private:
  struct Process {
    double correlation_time_s;
    double state = 0.0;  ///< of unit variance
  };

  std::uint64_t run_seed_;
  std::uint64_t sensor_index_;
  double white_sigma_ = 0.0;
  double slow_sigma_ = 0.0;  ///< of each process
  std::vector<Process> slow_;
  double last_t_s_ = 0.0;
  bool started_ = false;
};

/// Variance of the mean of `count` samples `interval_s` apart of a first-order Gauss-Markov process of unit variance:
/// (1/n²) Σᵢ Σⱼ exp(−|i − j|·interval/correlation_time).
[[nodiscard]] double mean_variance_of_gauss_markov(double correlation_time_s, double interval_s, int count);

/// What the station would record of `unit` in run `run` that passes through `set_points`: SI, every channel in every
/// row, auxiliary channel `chamber_c`. `run_id` is run_label(run). The numbers depend on (configuration, unit, run)
/// alone.
[[nodiscard]] calib::Recording simulate_run(const CampaignConfig& config, const SimulatedUnit& unit, int run,
                                            const std::vector<SetPoint>& set_points);

/// Run `run` (from 1) of the campaign.
[[nodiscard]] calib::Recording simulate_campaign_run(const CampaignConfig& config, const SimulatedUnit& unit, int run);

/// The verification run: between the plateaus, with a power-on offset of its own.
[[nodiscard]] calib::Recording simulate_verification_run(const CampaignConfig& config, const SimulatedUnit& unit);

}  // namespace soak::hal::sim
