// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "calib/vocabulary/sensor.h"
#include "hal/sim/config/lab_magnitudes.h"

namespace soak::hal::sim {

/// Slow noise of one sensor: first-order Gauss-Markov processes of equal variance, in steps of equal length. Their
/// common Allan deviation rises to 0.664 times the bias instability, and to no more. A function of seed, stream and
/// step alone.
class SlowNoise {
 public:
  SlowNoise(const std::vector<double>& correlation_times_s, double bias_instability, double step_s);

  /// Starts anew in the stationary state, with the random numbers of `stream` (below 2^24) of `seed`.
  void start(std::uint64_t seed, std::uint64_t stream);
  void step();
  /// In the unit of the bias instability.
  [[nodiscard]] double value() const { return value_; }

 private:
  struct Process {
    double decay;       ///< of the state in one step
    double innovation;  ///< standard deviation that a step adds
    double state = 0.0;
  };

  void sum_up();

  double sigma_;  ///< stationary, of each process
  std::vector<Process> processes_;
  std::uint64_t seed_ = 0;
  std::uint64_t first_stream_ = 0;
  std::uint64_t step_ = 0;
  double value_ = 0.0;
};

/// Noise of all sensors of a unit from one power-on to the next.
class UnitNoise {
 public:
  explicit UnitNoise(const LabMagnitudes& magnitudes);

  /// Starts anew; `seed` names unit and power-on.
  void start(std::uint64_t seed);
  /// Advances the slow noise, which has a new value each kTicksPerStep internal samples, to sample `index`.
  void advance_to(std::uint64_t index);
  /// Noise of internal sample `index` since the power-on, the one last advanced to, where the unit puts out `rate_hz`
  /// of them: rad/s or m/s². A function of the seed, `index` and `rate_hz`.
  [[nodiscard]] double at(calib::Sensor sensor, std::uint64_t index, double rate_hz) const;

 private:
  std::uint64_t seed_ = 0;
  std::uint64_t step_ = 0;
  std::array<double, calib::kSensorCount> random_walk_{};
  std::vector<SlowNoise> slow_;  ///< one per sensor
};

}  // namespace soak::hal::sim
