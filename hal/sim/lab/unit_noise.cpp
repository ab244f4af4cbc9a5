// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/lab/unit_noise.h"

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "hal/sim/lab/device_time.h"
#include "hal/sim/unit/draws.h"

namespace soak::hal::sim {
namespace {

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

}  // namespace soak::hal::sim
