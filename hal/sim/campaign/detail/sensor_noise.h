// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "calib/vocabulary/sensor.h"
#include "hal/sim/config/campaign_config.h"

namespace soak::hal::sim {

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

}  // namespace soak::hal::sim
