// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "calib/vocabulary/sensor.h"
#include "hal/sim/config/campaign_config.h"
#include "hal/sim/config/lab_magnitudes.h"
#include "hal/sim/effects/conditions.h"
#include "hal/sim/effects/hidden_effects.h"
#include "hal/sim/lab/chamber_plant.h"
#include "hal/sim/lab/device_time.h"
#include "hal/sim/unit/attitude.h"
#include "hal/sim/unit/simulated_unit.h"

namespace soak::hal::sim {

/// Temperature of one unit in the chamber: (Tair + self-heating − T)/τ + (Tload − T)/τload.
class UnitHeat {
 public:
  UnitHeat(double start_c, double settling_time_s, double load_coupling_time_s, double self_heating_c)
      : temp_c_(start_c),
        settling_time_s_(settling_time_s),
        load_coupling_time_s_(load_coupling_time_s),
        self_heating_c_(self_heating_c) {}

  void step(double dt_s, const ChamberPlant& chamber, bool powered);
  [[nodiscard]] double temp_c() const { return temp_c_; }

 private:
  double temp_c_;
  double settling_time_s_;
  double load_coupling_time_s_;
  double self_heating_c_;
};

/// Slow noise of one sensor: first-order Gauss-Markov processes of equal variance, in steps of equal length. Their
/// common Allan deviation rises to 0.664 times the bias instability, and to no more. A function of seed, stream and
/// step alone.
class SlowNoise {
 public:
  SlowNoise(const std::vector<double>& correlation_times_s, double bias_instability, double step_s);

  /// Restarts in the stationary state, with the random numbers of `stream` (below 2^24) of `seed`.
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

  /// Restarts; `seed` names unit and power-on.
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

/// One output of three sensors.
struct SensedVector {
  std::array<float, 3> value{};  ///< rad/s or m/s², in the unit's own axes
  std::array<bool, 3> clipped{};
};

/// The `number`-th unit, from 1, of the laboratory: draw_unit() with a serial number of its own, eight hexadecimal
/// digits that are also its device identification.
[[nodiscard]] SimulatedUnit draw_lab_unit(const CampaignConfig& config, int number);

/// Device identification of the `number`-th unit.
[[nodiscard]] std::uint32_t device_id_of(int number);

/// What the sensors of a unit in the chamber read. Hidden effects, which must state an amplitude, take every power-on
/// for a new mounting.
class InertialUnit {
 public:
  InertialUnit(const CampaignConfig& config, int number);

  [[nodiscard]] std::uint32_t device_id() const { return device_id_of(number_); }
  [[nodiscard]] double temp_c() const { return heat_.temp_c(); }

  /// Power on or restart: the next power-on ordinal, from 0, with an offset and noise of its own.
  void start();
  void stop() { powered_ = false; }

  /// Advances the temperature by kStep_s, and the hidden effects with it.
  void step(const ChamberPlant& chamber, const Attitude& fixture);

  /// Goes on to internal sample `index` since the start, the one that the following are asked for.
  void advance_to(std::uint64_t index) { noise_.advance_to(index); }
  /// Averaged down to `rate_hz`. `fixture` is the attitude of the fixture.
  [[nodiscard]] SensedVector rate_of_turn(const Attitude& fixture, std::uint64_t index, double rate_hz) const;
  [[nodiscard]] SensedVector acceleration(const Attitude& fixture, std::uint64_t index, double rate_hz) const;
  [[nodiscard]] float thermometer_c(std::uint64_t index) const;

 private:
  [[nodiscard]] SensedVector sense(std::size_t first_sensor, const Attitude& fixture, std::uint64_t index,
                                   double rate_hz) const;
  void follow_temperature();
  void advance_effects(const ChamberPlant& chamber, const Attitude& fixture);

  CampaignConfig config_;
  int number_;
  SimulatedUnit truth_;
  Mounting mounting_;
  UnitHeat heat_;
  UnitNoise noise_;
  HiddenEffects hidden_;
  SupplyVoltage supply_;
  std::uint64_t step_ = 0;
  double start_s_ = 0.0;  ///< time of the last step before the start
  bool powered_ = false;
  int starts_ = 0;
  std::uint64_t run_seed_ = 0;
  std::array<double, calib::kSensorCount> offset_{};
  std::array<SensorAtTemperature, calib::kSensorCount> state_{};
};

}  // namespace soak::hal::sim
