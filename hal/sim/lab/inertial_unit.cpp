// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/inertial_unit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "base/units.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

using calib::Sensor;
using calib::Vector3;

constexpr std::uint32_t kFirstDeviceId = 0x0380A000;

UnitHeat drawn_heat(const CampaignConfig& config, const SimulatedUnit& unit) {
  const ElectronicsMagnitudes& magnitudes = config.lab.electronics;
  base::Random random(unit.seed, stream_of(Purpose::lab_unit));
  const double settling_time_s = drawn_from(random, magnitudes.settling_time_s);
  const double self_heating_c = drawn_from(random, magnitudes.self_heating_c);
  return {config.lab.plant.room_c, settling_time_s, magnitudes.load_coupling_time_s, self_heating_c};
}

double quantised(double value, double lsb) { return lsb * std::round(value / lsb); }

/// A vector of the fixture in the axes of the unit, times `factor`.
Vector3 in_unit_axes(const Mounting& mounting, const Vector3& v, double factor) {
  Vector3 turned{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3& axis = mounting.axes[i];
    turned[i] = factor * (axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2]);
  }
  return turned;
}

constexpr double kFloorPerInstability = 0.664;  // √(2 ln 2 / π), IEEE Std 952
constexpr std::uint64_t kMaxProcesses = 256;

/// Allan variance at `tau_s` of a first-order Gauss-Markov process of unit variance (IEEE Std 952, annex C):
/// (2 Tc/τ)·(1 − (Tc/2τ)·(3 − 4 e^(−τ/Tc) + e^(−2τ/Tc)))
double allan_variance(double correlation_time_s, double tau_s) {
  const double x = tau_s / correlation_time_s;
  return 2.0 / x * (1.0 - (3.0 - 4.0 * std::exp(-x) + std::exp(-2.0 * x)) / (2.0 * x));
}

/// Largest Allan deviation of the sum of processes of unit variance, over averaging times 5 % apart.
double largest_allan_deviation(const std::vector<double>& correlation_times_s) {
  const auto [shortest, longest] = std::minmax_element(correlation_times_s.begin(), correlation_times_s.end());
  double largest = 0.0;
  for (double tau_s = *shortest; tau_s <= 10.0 * *longest; tau_s *= 1.05) {
    double variance = 0.0;
    for (const double time_s : correlation_times_s) variance += allan_variance(time_s, tau_s);
    largest = std::max(largest, variance);
  }
  return std::sqrt(largest);
}

}  // namespace

void UnitHeat::step(double dt_s, const ChamberPlant& chamber, bool powered) {
  const double surroundings_c = chamber.air_c() + (powered ? self_heating_c_ : 0.0);
  temp_c_ +=
      dt_s * ((surroundings_c - temp_c_) / settling_time_s_ + (chamber.load_c() - temp_c_) / load_coupling_time_s_);
}

SlowNoise::SlowNoise(const std::vector<double>& correlation_times_s, double bias_instability, double step_s)
    : sigma_(kFloorPerInstability * bias_instability / largest_allan_deviation(correlation_times_s)) {
  for (const double time_s : correlation_times_s) {
    const double decay = std::exp(-step_s / time_s);
    processes_.push_back({decay, std::sqrt(1.0 - decay * decay)});
  }
}

void SlowNoise::start(std::uint64_t seed, std::uint64_t stream) {
  seed_ = seed;
  first_stream_ = stream_of(Purpose::lab_slow_noise, stream * kMaxProcesses);
  step_ = 0;
  for (std::size_t i = 0; i < processes_.size(); ++i) {
    processes_[i].state = base::hashed_gaussian(seed_, first_stream_ + i, 0);
  }
  sum_up();
}

void SlowNoise::step() {
  ++step_;
  for (std::size_t i = 0; i < processes_.size(); ++i) {
    Process& process = processes_[i];
    process.state =
        process.decay * process.state + process.innovation * base::hashed_gaussian(seed_, first_stream_ + i, step_);
  }
  sum_up();
}

void SlowNoise::sum_up() {
  value_ = 0.0;
  for (const Process& process : processes_) value_ += sigma_ * process.state;
}

UnitNoise::UnitNoise(const LabMagnitudes& magnitudes) {
  for (const calib::Sensor sensor : calib::kSensors) {
    const OutputMagnitudes& output = calib::is_gyro(sensor) ? magnitudes.gyro : magnitudes.accel;
    random_walk_[calib::index_of(sensor)] = output.random_walk;
    slow_.emplace_back(magnitudes.slow_correlation_times_s, output.bias_instability, kStep_s);
  }
}

void UnitNoise::start(std::uint64_t seed) {
  seed_ = seed;
  step_ = 0;
  for (std::size_t i = 0; i < slow_.size(); ++i) slow_[i].start(seed, i);
}

void UnitNoise::advance_to(std::uint64_t index) {
  for (; step_ < index / static_cast<std::uint64_t>(kTicksPerStep); ++step_) {
    for (SlowNoise& slow : slow_) slow.step();
  }
}

double UnitNoise::at(calib::Sensor sensor, std::uint64_t index, double rate_hz) const {
  const std::size_t i = calib::index_of(sensor);
  // White noise of density N, averaged over 1/rate: variance N² · rate.
  const double white = random_walk_[i] * std::sqrt(rate_hz);
  return white * base::hashed_gaussian(seed_, stream_of(Purpose::lab_white_noise, i), index) + slow_[i].value();
}

std::uint32_t device_id_of(int number) { return kFirstDeviceId + static_cast<std::uint32_t>(number); }

SimulatedUnit draw_lab_unit(const CampaignConfig& config, int number) {
  SimulatedUnit unit = draw_unit(config, number);
  unit.serial = fmt::format("{:08X}", device_id_of(number));
  return unit;
}

InertialUnit::InertialUnit(const CampaignConfig& config, int number)
    : config_(config),
      number_(number),
      truth_(draw_lab_unit(config, number)),
      mounting_(config.lab.mounting(number)),
      heat_(drawn_heat(config, truth_)),
      noise_(config.lab),
      supply_(truth_.seed) {
  for (const LabEffect& effect : lab_effects(config, number)) {
    hidden_.add(effect.drawn, effect.amplitude, lab_surroundings(config));
  }
  follow_temperature();
}

void InertialUnit::advance_effects(const ChamberPlant& chamber, const Attitude& fixture) {
  Conditions now;
  now.time_s = kStep_s * static_cast<double>(step_);
  now.utc_s = kFirstUtc_s + now.time_s;
  now.powered = powered_;
  now.since_power_on_s = powered_ ? now.time_s - start_s_ : 0.0;
  now.run = now.mounting = std::max(starts_ - 1, 0);
  now.thermometer_c = heat_.temp_c();
  now.air_c = chamber.air_c();
  now.up = in_unit_axes(mounting_, fixture.up, 1.0);
  now.compressor = chamber.compressor_runs() ? 1.0 : 0.0;
  now.supply_v = supply_.at(now.time_s, now.run);
  hidden_.advance_to(now);
}

void InertialUnit::start() {
  const int ordinal = starts_++;
  powered_ = true;
  start_s_ = kStep_s * static_cast<double>(step_);
  run_seed_ = run_seed(truth_, ordinal);
  noise_.start(run_seed_);
  follow_temperature();
  for (const Sensor sensor : calib::kSensors) {
    offset_[calib::index_of(sensor)] = power_on_offset(config_, truth_, ordinal, sensor);
  }
}

void InertialUnit::follow_temperature() {
  const double element_c = hidden_.empty() || step_ == 0 ? heat_.temp_c() : hidden_.element_c();
  for (std::size_t i = 0; i < state_.size(); ++i) state_[i] = at_temperature(truth_.sensors[i], element_c);
}

void InertialUnit::step(const ChamberPlant& chamber, const Attitude& fixture) {
  ++step_;
  heat_.step(kStep_s, chamber, powered_);
  if (!hidden_.empty()) advance_effects(chamber, fixture);
  if (powered_) follow_temperature();
}

SensedVector InertialUnit::sense(std::size_t first_sensor, const Attitude& fixture, std::uint64_t index,
                                 double rate_hz) const {
  const Vector3 force_mps2 = in_unit_axes(mounting_, fixture.up, base::kStandardGravity_mps2);
  const Vector3 rate_rps = in_unit_axes(mounting_, fixture.rate_rps, 1.0);
  SensedVector sensed;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t i = first_sensor + axis;
    const Sensor sensor = calib::kSensors[i];
    const OutputMagnitudes& output = calib::is_gyro(sensor) ? config_.lab.gyro : config_.lab.accel;
    const double value =
        hidden_.sensed(sensor, reading_of(truth_.sensors[i], state_[i], sensor, force_mps2, rate_rps) + offset_[i],
                       noise_.at(sensor, index, rate_hz));
    sensed.clipped[axis] = std::abs(value) > output.range;
    const double word = quantised(std::clamp(value, -output.range, output.range), output.lsb);
    sensed.value[axis] = static_cast<float>(hidden_.output(sensor, word));
  }
  return sensed;
}

SensedVector InertialUnit::rate_of_turn(const Attitude& fixture, std::uint64_t index, double rate_hz) const {
  return sense(calib::index_of(Sensor::gyro_x), fixture, index, rate_hz);
}

SensedVector InertialUnit::acceleration(const Attitude& fixture, std::uint64_t index, double rate_hz) const {
  return sense(calib::index_of(Sensor::accel_x), fixture, index, rate_hz);
}

float InertialUnit::thermometer_c(std::uint64_t index) const {
  const ElectronicsMagnitudes& magnitudes = config_.lab.electronics;
  const double noise = base::hashed_gaussian(run_seed_, stream_of(Purpose::lab_thermometer), index);
  return static_cast<float>(
      quantised(heat_.temp_c() + magnitudes.thermometer_noise_sigma_c * noise, magnitudes.thermometer_lsb_c));
}

}  // namespace soak::hal::sim
