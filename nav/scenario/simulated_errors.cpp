// SPDX-License-Identifier: Apache-2.0
#include "nav/scenario/simulated_errors.h"

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "base/units.h"

namespace soak::nav {
namespace {

using base::hashed_gaussian;
using base::kRadPerDeg;
using base::kStandardGravity_mps2;
using Eigen::Vector3d;

/// A random walk per sqrt(h) in the same per sqrt(s).
constexpr double kPerRootHour = 1.0 / 60.0;
constexpr double kMilliG = 1e-3 * kStandardGravity_mps2;

/// Streams of random numbers: a sensor has four of its own.
enum Stream : std::uint64_t { power_on, scale, markov, white };
constexpr std::uint64_t kFixStream = 100;

std::uint64_t stream_of(std::size_t sensor, Stream stream) { return 4 * sensor + stream; }

/// One sensor of a unit on one drive.
class SensorError {
 public:
  SensorError(const SensorErrors& errors, std::size_t sensor, double interval_s, std::uint64_t seed)
      : errors_(errors),
        sensor_(sensor),
        seed_(seed),
        constant_(errors.power_on_sigma * hashed_gaussian(seed, stream_of(sensor, power_on), 0)),
        scale_(errors.scale_sigma * hashed_gaussian(seed, stream_of(sensor, scale), 0)),
        bend_(hashed_gaussian(seed, stream_of(sensor, scale), 1) < 0.0 ? -1.0 : 1.0),
        kept_(std::exp(-interval_s / errors.markov_time_s)),
        white_sigma_(errors.white / std::sqrt(interval_s)),
        slow_(errors.markov_sigma * hashed_gaussian(seed, stream_of(sensor, markov), 0)) {}

  double reading(double truth, double thermal, std::uint64_t index) {
    const double share = truth / errors_.range;
    const double read = truth * (1.0 + scale_) + bend_ * errors_.nonlinearity * errors_.range * share * share +
                        constant_ + slow_ + thermal +
                        white_sigma_ * hashed_gaussian(seed_, stream_of(sensor_, white), index);
    slow_ = kept_ * slow_ + errors_.markov_sigma * std::sqrt(1.0 - kept_ * kept_) *
                                hashed_gaussian(seed_, stream_of(sensor_, markov), index + 1);
    return errors_.step > 0.0 ? errors_.step * std::round(read / errors_.step) : read;
  }

 private:
  const SensorErrors& errors_;
  std::size_t sensor_;
  std::uint64_t seed_;
  double constant_;
  double scale_;
  double bend_;
  double kept_;
  double white_sigma_;
  double slow_;
};

}  // namespace

UnitErrors ahrs400ca() {
  return {
      "ahrs400ca",
      {0.5 * kRadPerDeg, 0.03 * kRadPerDeg, 100.0, 0.5 * 2.25 * kPerRootHour * kRadPerDeg, 0.005, 0.0015,
       100.0 * kRadPerDeg, 0.025 * kRadPerDeg},
      {4.25 * kMilliG, 1.0 * kMilliG, 100.0, 0.5 * 0.1 * kPerRootHour, 0.005, 0.005, 2000.0 * kMilliG, 0.25 * kMilliG}};
}

UnitErrors motionpak2() {
  // 6 and 5 mV root mean square in B = 30 and 20 Hz, of 2.5 V at full range: N = rms/sqrt(2 B).
  const double gyro_white = 0.006 / 2.5 * 75.0 * kRadPerDeg / std::sqrt(2.0 * 30.0);
  const double accel_white = 0.005 / 2.5 * 1500.0 * kMilliG / std::sqrt(2.0 * 20.0);
  return {"motionpak2",
          {2.5 * kRadPerDeg, 0.03 * kRadPerDeg, 100.0, gyro_white, 0.03, 0.015, 75.0 * kRadPerDeg, 0.0},
          {62.5 * kMilliG, 1.0 * kMilliG, 100.0, accel_white, 0.025, 0.015, 1500.0 * kMilliG, 0.0}};
}

UnitErrors isi() {
  return {"isi",
          {0.5 * kRadPerDeg, 0.005 * kRadPerDeg, 100.0, 0.5 * 0.5 * kPerRootHour * kRadPerDeg, 0.001, 0.001,
           90.0 * kRadPerDeg, 2.0 / 3600.0 * kRadPerDeg},
          {0.0, 1.0 * kMilliG, 100.0, 0.5 * 0.1 * kPerRootHour, 0.001, 0.0025, 20000.0 * kMilliG, 1.0 * kMilliG}};
}

double TemperatureProfile::at(double t_s) const { return end_c + (start_c - end_c) * std::exp(-t_s / time_s); }

void add_errors(std::vector<ImuSample>& samples, const UnitErrors& errors, const TemperatureProfile& temperature,
                const ThermalBias& thermal, std::uint64_t seed) {
  if (samples.size() < 2) return;
  const double interval_s = samples[1].t_s - samples[0].t_s;
  std::vector<SensorError> sensors;
  for (const calib::Sensor sensor : calib::kSensors) {
    sensors.emplace_back(calib::is_gyro(sensor) ? errors.gyro : errors.accel, calib::index_of(sensor), interval_s,
                         seed);
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    ImuSample& sample = samples[i];
    sample.temp_c = temperature.at(sample.t_s);
    for (const calib::Sensor sensor : calib::kSensors) {
      const auto axis = static_cast<Eigen::Index>(calib::axis_of(sensor));
      double& value = calib::is_gyro(sensor) ? sample.rate_rps(axis) : sample.force_mps2(axis);
      value = sensors[calib::index_of(sensor)].reading(value, thermal ? thermal(sensor, sample.temp_c) : 0.0, i);
    }
  }
}

std::vector<GnssFix> simulated_fixes(const std::vector<TruthPoint>& truth, std::size_t every, const GnssErrors& errors,
                                     std::uint64_t seed) {
  const Vector3d position_sigma(errors.horizontal_m, errors.horizontal_m, errors.vertical_m);
  const Vector3d velocity_sigma(errors.horizontal_mps, errors.horizontal_mps, errors.vertical_mps);
  std::vector<GnssFix> fixes;
  for (std::size_t i = 0; i < truth.size(); i += every) {
    const TruthPoint& point = truth[i];
    const auto noise = [&](std::uint64_t k) {
      return Vector3d(hashed_gaussian(seed, kFixStream + k, i), hashed_gaussian(seed, kFixStream + k + 1, i),
                      hashed_gaussian(seed, kFixStream + k + 2, i));
    };
    fixes.push_back({point.t_s, moved(point.position, position_sigma.cwiseProduct(noise(0))), position_sigma,
                     point.velocity_mps + velocity_sigma.cwiseProduct(noise(3)), velocity_sigma});
  }
  return fixes;
}

}  // namespace soak::nav
